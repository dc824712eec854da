//! Readings of the paper's scenes: where the hand's force acts, the ball's radius, the safety box, the
//! window of leak dissipation, and the friction under SEH. `docs/results/readings.md` has the tables.

use palpate_scene::method::MethodName;
use palpate_scene::{Measure, Scene};
use palpate_study::claims::{CLAIMS, Holds, PaperScenes, check};
use palpate_study::sim::closed_loop::Bench;
use palpate_study::sim::run::Run;
use palpate_study::suite::Column;
use palpate_study::sweep::{Quantity, Stability, SweepError, Swept, sweep};

use crate::common::{damping, fidelity, scene, with};

fn run(scene: &Scene, method: MethodName) -> Run {
    Bench::new(scene).unwrap().run(method).unwrap()
}

fn swept(scene: &Scene, over: Quantity, values: &[f64], columns: &[Column]) -> Vec<Vec<Swept>> {
    sweep(scene, over, values, columns, false, || {}).unwrap()
}

/// Source: the paper's second experiment, in which the damper and POPC-REF leave the safety box and
/// HFCR stays. The paper does not state the box: y within 0.11 m of home fits its text best.
#[test]
fn who_leaves_the_box_depends_on_its_size() {
    let columns = [
        MethodName::VirtualDamper,
        MethodName::PopcRef,
        MethodName::Hfcr,
        MethodName::Coupled,
    ]
    .map(Column::new);
    let at = swept(
        &scene("fig5"),
        Quantity::SafetyBox,
        &[0.1, 0.11, 0.3, 0.5],
        &columns,
    );
    let left: Vec<Vec<Option<f64>>> = at
        .iter()
        .map(|columns| {
            let rounded = |time: f64| (100.0 * time).round() / 100.0;
            columns
                .iter()
                .map(|of| of.outcome.bounce.unwrap().left_box_at.map(rounded))
                .collect()
        })
        .collect();
    eprintln!("damper, POPC-REF, HFCR and coupled leave at {left:?} s");
    assert_eq!(left[0], [Some(0.32), Some(0.32), Some(0.80), None]);
    assert_eq!(left[1], [Some(0.34), Some(0.56), Some(0.82), None]);
    assert_eq!(left[2], [Some(0.56), Some(0.74), None, None]);
    assert_eq!(left[3], [Some(0.76), None, None, None]);
    // Coupled rendering is near its hold bound in every box: it never needs the motors outside.
    for columns in &at {
        let coupled = columns[3].own;
        assert!(coupled.force_rendering_error < coupled.hold_bound + 0.5);
    }
}

/// Source: derived here. Whether HFCR stays in a box also depends on its damping b.
#[test]
fn hfcr_stays_in_the_box_that_fits_with_little_damping_only() {
    let scene = scene("fig5_box");
    let hfcr = [Column::new(MethodName::Hfcr)];
    let dampings = [0.0, 0.04, 0.07, 0.08, 0.21];
    let at = swept(&scene, Quantity::Damping, &dampings, &hfcr);
    let stays: Vec<bool> = at
        .iter()
        .map(|of| of[0].outcome.bounce.unwrap().left_box_at.is_none())
        .collect();
    assert_eq!(stays, [true, true, true, false, false]);
    // The committed b has the lowest error of all values with which HFCR stays.
    let grid: Vec<f64> = (0..=7).map(|step| 0.01 * f64::from(step)).collect();
    let at = swept(&scene, Quantity::Damping, &grid, &hfcr);
    let errors: Vec<f64> = at
        .iter()
        .map(|of| of[0].own.force_rendering_error)
        .collect();
    eprintln!("FRE for b = 0 to 0.07 N s/m: {errors:.1?} %");
    let least = errors.iter().copied().fold(f64::INFINITY, f64::min);
    assert_eq!(
        fidelity(&scene, MethodName::Hfcr).force_rendering_error,
        least
    );
}

/// Source: Fig. 2, which shows 3 collisions. Over 10, leak dissipation matters, and so does its b.
#[test]
fn over_ten_collisions_the_damping_of_leak_dissipation_matters() {
    let long = scene("fig2_long");
    let short = scene("fig2");
    let mut same = short.clone();
    same.measure = Measure::Collisions(10);
    (same.title, same.settings, same.method) =
        (long.title.clone(), long.settings.clone(), long.method);
    assert_eq!(same, long, "nothing else differs");
    for (b, expected) in [(0.0, 92.3), (0.0125, 69.5), (0.03, 30.1), (0.05, 98.0)] {
        let over = |scene: &Scene| {
            let scene = with(scene.clone(), MethodName::Hfcr, damping(b));
            fidelity(&scene, MethodName::Hfcr).force_rendering_error
        };
        let (three, ten) = (over(&short), over(&long));
        eprintln!("b = {b}: FRE {three:.1} % over 3 collisions, {ten:.1} % over 10");
        assert!((ten - expected).abs() < 0.1, "{b}: {ten}");
        assert!(three < 29.0, "{b}: {three}");
    }
    let auto = run(&long, MethodName::Hfcr).force.fidelity.unwrap();
    assert!(
        (auto.force_rendering_error - 69.5).abs() < 0.1,
        "auto is 0.0125"
    );
}

/// Source: the paper calls SEH almost stable in its first experiment. It does not state the estimate that SEH holds,
/// and the friction of its device is unknown. Here *almost stable* is a number:
/// [`palpate_study::sweep::ALMOST_STABLE_UP_TO`].
#[test]
fn seh_is_almost_stable_by_some_estimates_with_much_friction() {
    let columns =
        Column::parse(include_str!("../../../../../experiments/columns/seh.toml")).unwrap();
    let mut fig4 = scene("fig4");
    let as_drawn = run(&fig4, MethodName::Seh);
    let faster: Vec<f64> = as_drawn
        .rebounds
        .iter()
        .filter_map(|rebound| rebound.error)
        .collect();
    eprintln!("AB2 on Fig. 4: rebounds off by {faster:.3?}");
    assert!((faster[0] - 0.243).abs() < 0.005 && (faster[1] - 0.509).abs() < 0.005);
    fig4.measure = Measure::Collisions(8);
    let frictions = [1.0, 10.0];
    let at = swept(&fig4, Quantity::Friction, &frictions, &columns);
    for (friction, at) in frictions.iter().zip(&at) {
        for (column, of) in columns.iter().zip(at) {
            eprintln!(
                "friction × {friction}, {}: peak {:.2} N of {:.2} N, rebound energy {:?}, {}",
                column.name,
                of.outcome.peak_force,
                of.outcome.ideal_peak_force,
                of.outcome.bounce.unwrap().rebound_energy,
                of.outcome.bounce.unwrap().stability.name()
            );
        }
    }
    let of = |row: usize| {
        at[row]
            .iter()
            .map(|of| of.outcome.bounce.unwrap().stability)
            .collect::<Vec<_>>()
    };
    use Stability::{AlmostStable, Diverged, Unstable};
    assert!(
        of(0).iter().all(|of| [Unstable, Diverged].contains(of)),
        "{:?}",
        of(0)
    );
    assert_eq!(of(1), [Unstable, AlmostStable, AlmostStable]);
    let peak = |column: usize| at[1][column].outcome.peak_force;
    assert!((peak(0) - 7.08).abs() < 0.05 && (peak(1) - 5.13).abs() < 0.05);
    assert!((at[1][0].outcome.ideal_peak_force - 4.10).abs() < 0.02);
}

/// Source: derived here. A sweep changes only its quantity.
#[test]
fn a_sweep_at_the_scene_s_own_value_is_the_scene() {
    let fig4 = scene("fig4");
    let hfcr = [Column::new(MethodName::Hfcr)];
    let own = fidelity(&fig4, MethodName::Hfcr);
    for (over, value) in [
        (Quantity::Friction, 1.0),
        (Quantity::Damping, 0.01),
        (Quantity::SafetyBox, 10.0),
    ] {
        let at = swept(&fig4, over, &[value], &hfcr);
        assert_eq!(at[0][0].own, own, "{}", over.name());
    }
    // The friction factor applies to both kinds of friction.
    let mut rough = fig4.clone();
    let params = &mut rough.device.pantograph_mut().unwrap().linkage.params;
    params.viscous_friction *= 3.0;
    params.coulomb_friction *= 3.0;
    let at = swept(&fig4, Quantity::Friction, &[3.0], &hfcr);
    assert_eq!(at[0][0].own, fidelity(&rough, MethodName::Hfcr));
    // A box extends equally far up and down.
    let damper = [Column::new(MethodName::VirtualDamper)];
    let at = swept(&scene("fig5"), Quantity::SafetyBox, &[0.11], &damper);
    let boxed = run(&scene("fig5_box"), MethodName::VirtualDamper);
    assert_eq!(Some(at[0][0].own), boxed.force.fidelity);
    assert_eq!(
        at[0][0].outcome.bounce.unwrap().left_box_at,
        boxed.left_box_at
    );
    // The rebound energy is proportional to the squared speed.
    let seh = [Column::new(MethodName::Seh)];
    let at = swept(&fig4, Quantity::Friction, &[1.0], &seh);
    let rebounds = run(&fig4, MethodName::Seh).rebounds;
    let speeds = rebounds.iter().filter_map(|rebound| rebound.rendered);
    let faster = speeds.fold(0.0, f64::max) / rebounds[0].ideal;
    let found = at[0][0].outcome.bounce.unwrap().rebound_energy.unwrap();
    assert!(
        (found / faster.powi(2) - 1.0).abs() < 1e-12,
        "{found} {faster}"
    );
    assert!(faster > 1.4, "{faster}");
    let none = sweep(
        &scene("experiment1"),
        Quantity::Friction,
        &[1.0],
        &hfcr,
        false,
        || {},
    );
    assert!(matches!(none, Err(SweepError::Nothing(_))), "{none:?}");
    let basic = [Column::new(MethodName::Basic)];
    let none = sweep(&fig4, Quantity::Damping, &[1.0], &basic, false, || {});
    assert_eq!(none, Err(SweepError::NoDamping("basic".into())));
    let negative = sweep(&fig4, Quantity::Friction, &[-1.0], &hfcr, false, || {});
    assert!(
        matches!(negative, Err(SweepError::Value { .. })),
        "{negative:?}"
    );
}

/// Source: the numbers in the paper's text. Each claim's numbers are pinned, whether it holds or not.
#[test]
fn the_paper_s_numbers_hold_in_part() {
    let [fig2, fig5_box] = ["fig2", "fig5_box"].map(scene);
    let point_mass = ["experiment1", "experiment2"].map(scene);
    let pantograph = ["fig4", "fig5"].map(scene);
    let mut heard = 0;
    let claims = check(
        &PaperScenes {
            fig2: &fig2,
            point_mass: point_mass.each_ref(),
            pantograph: pantograph.each_ref(),
            fig5_box: &fig5_box,
        },
        || heard += 1,
    )
    .unwrap();
    assert_eq!((claims.len(), heard), (CLAIMS, CLAIMS));
    let numbers = |claim: usize| -> Vec<f64> {
        let found = claims[claim].found.iter();
        found.filter_map(|found| found.value).collect()
    };
    let near = |claim: usize, expected: &[f64]| {
        let found = numbers(claim);
        eprintln!(
            "{}: {found:.3?}, {}",
            claims[claim].name, claims[claim].holds
        );
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(expected) {
            assert!((found / expected - 1.0).abs() < 0.02, "{found} {expected}");
        }
    };
    // Median, leaks and absolute leaks, of the modified force, with transitions, and HFCR, on three scenes.
    let leaks = [
        [
            0.159, 0.295, 0.335, 0.120, 0.0453, 0.090, 0.120, 0.0331, 0.0893,
        ],
        [
            0.222, 0.398, 0.339, 0.123, 0.0568, 0.0811, 0.123, 0.0568, 0.0811,
        ],
        [0.965, 18.3, 15.2, 0.245, 0.164, 0.223, 0.330, 0.285, 0.295],
    ];
    near(0, leaks.as_flattened());
    near(1, &[481.0, 24.5, 1217.0, 62.2]);
    near(2, &[20.3, 105.3]);
    near(3, &[13.7, 13.5, 16.2, 1.20, 83.6, 69.5, 17.7, 4.72]);
    near(6, &[0.56, 0.34, 1.0]);
    near(7, &[22.9, 48.8, 23.6, 87.3, 17.4]);
    near(8, &[5.02, 5.03, 5.04, 2.31, 2.31, 2.31, 2.31, 2.32, 2.32]);
    near(9, &[40e3, 160e3]);
    let holds: Vec<Holds> = claims.iter().map(|claim| claim.holds).collect();
    use Holds::{InPart, No, Yes};
    assert_eq!(
        holds,
        [
            InPart, InPart, No, InPart, InPart, InPart, Yes, InPart, InPart, Yes
        ]
    );
}
