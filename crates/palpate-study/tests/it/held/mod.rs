//! Long sustained contacts with every method: coupled rendering with wrong model masses, and each other method with
//! the best setting of its `tune` candidates.
#![allow(clippy::print_stdout)] // what was measured
#![allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // numbers of samples
#![allow(dead_code, reason = "the parts of the scenes that other tests use")]

#[path = "../../../../palpate-world/tests/laws/common.rs"]
mod common;
#[path = "../../../../palpate-world/tests/laws/ideal.rs"]
mod ideal;
#[path = "../../../../palpate-world/tests/laws/held.rs"]
mod sustained;

use palpate_scene::world::{WorldFile, WorldSettings};
use palpate_study::world::candidates::{Scale, Tunable};
use palpate_world::{BasicParams, CoupledParams, Vector, WorldMethod, WorldRenderer};
use rayon::prelude::*;
use sustained::{
    FINGER, PINCHED, PRESSED, RESTING_PERIOD, TRAY, drift, resting, resting_stiffness,
};

const OTHERS: [&str; 4] = ["basic", "virtual-damper", "virtual-coupling", "god-object"];

/// Result of a method with its best setting, the number of tried settings, and the number of settings that lost the
/// scene during the search: a sample was rejected, or the held object was lost.
struct Best<const N: usize> {
    numbers: Option<[f64; N]>,
    settings: usize,
    lost: usize,
}

/// Simulated time of a setting in the search for the lowest first number, and in the evaluation of the best one
/// `[s]`.
const TRIED: usize = 10;
const EVALUATED: usize = 60;

fn best<const N: usize>(
    name: &str,
    scales: &[Scale],
    tools: usize,
    numbers: impl Fn(WorldMethod, usize) -> Option<[f64; N]> + Sync,
) -> Best<N> {
    let feels_torque = scales.iter().any(|scale| scale.gyration.is_some());
    let methods: Vec<WorldMethod> = match Tunable::named(name) {
        None => vec![BasicParams::default().into()],
        Some(tunable) => {
            let settings = scales.iter().flat_map(|scale| tunable.candidates(*scale));
            let method = |it: WorldSettings| it.method(name, tools, feels_torque).unwrap();
            settings.filter_map(method).collect()
        }
    };
    let settings = methods.len();
    let one = |method: WorldMethod| {
        let numbers = numbers(method.clone(), TRIED)?;
        let are_finite = numbers.iter().all(|number| number.is_finite());
        are_finite.then_some((numbers[0].abs(), method))
    };
    let kept: Vec<(f64, WorldMethod)> = methods.into_par_iter().filter_map(one).collect();
    let lost = settings - kept.len();
    let best = kept
        .into_iter()
        .min_by(|one, other| one.0.total_cmp(&other.0));
    Best {
        numbers: best.and_then(|(_, method)| numbers(method, EVALUATED)),
        settings,
        lost,
    }
}

/// Returns the maximum of each number of coupled rendering with 1.5 and 0.67 times the true masses in its model.
fn coupled<const N: usize>(
    mass: Vector,
    tools: usize,
    quantum: f64,
    numbers: impl Fn(WorldMethod, usize) -> Option<[f64; N]>,
) -> [f64; N] {
    let all = [1.5, 0.67].map(|model| {
        let params = CoupledParams::new(vec![mass.map(|mass| model * mass); tools]);
        numbers(params.with_encoder_quantum(quantum).into(), EVALUATED).unwrap()
    });
    std::array::from_fn(|number| all[0][number].abs().max(all[1][number].abs()))
}

/// Prints a row per method, and returns the results of the other methods in the order of [`OTHERS`].
fn table<const N: usize>(
    title: &str,
    coupled: [f64; N],
    others: impl Fn(&str) -> Best<N>,
) -> [Option<[f64; N]>; 4] {
    let row = |numbers: [f64; N]| numbers.map(|it| format!("{it:.4}")).join(" | ");
    println!("{title}");
    let all = OTHERS.map(|name| {
        let best = others(name);
        let numbers = best.numbers.map_or_else(|| "none".to_owned(), row);
        println!(
            "  {name}: {numbers} ({} of {} lost)",
            best.lost, best.settings
        );
        best.numbers
    });
    println!("  coupled: {}", row(coupled));
    all
}

fn scale(stiffness: f64, period: f64, mass: Vector) -> Scale {
    Scale {
        stiffness,
        period,
        mass: mass.iter().product::<f64>().cbrt(),
        gyration: None,
    }
}

#[test]
#[ignore = "takes minutes"]
fn a_cube_that_is_pinched_for_ten_seconds() {
    for (period, quantum) in [(0.001, 2e-6), (0.001, 1e-5), (0.004, 2e-6)] {
        let drift = |method: WorldMethod, _| Some([1e6 * drift(method, period, quantum)?]);
        let scales = [scale(PINCHED, period, FINGER)];
        let own = coupled(FINGER, 2, quantum, drift);
        let title = format!("{period} s, {quantum} m: drift um");
        let [basic, ..] = table(&title, own, |name| best(name, &scales, 2, drift));
        assert!(own[0] < 5.0 && basic.is_none(), "{own:?} {basic:?}");
    }
}

#[test]
#[ignore = "takes minutes"]
fn a_light_box_on_a_tool_at_rest() {
    for kc in [8.0, 15.0, 30.0] {
        for quantum in [0.0, 2e-6] {
            let ripple = |method: WorldMethod, _| {
                let it = resting(method, kc, quantum)?;
                Some([100.0 * it.ripple, 1e6 * it.place])
            };
            // Stiffness of one of the four contacts, and of all together.
            let scales = [0.25, 1.0]
                .map(|share| scale(share * resting_stiffness(kc), RESTING_PERIOD, [TRAY; 3]));
            let own = coupled([TRAY; 3], 1, quantum, ripple);
            let title = format!("Kc {kc}, {quantum} m: ripple %, lower by um");
            let [basic, damper, coupling, _] =
                table(&title, own, |name| best(name, &scales, 1, ripple));
            // The sampled spring throws the box, with any damper. With a coupling in series with the contacts the box
            // rests, but much lower.
            let throws = |it: Option<[f64; 2]>| it.is_none_or(|[ripple, _]| ripple > 500.0);
            assert!(own[0] < 2.0 && throws(basic) && throws(damper));
            let [_, lower] = coupling.unwrap();
            assert!(lower > 3.0 * own[1], "{lower} {own:?}");
        }
    }
}

#[test]
#[ignore = "takes minutes"]
fn pressed_into_a_groove_for_a_minute() {
    for (period, stiffness, friction) in [(0.001, 2e4, 0.0), (0.001, 2e4, 0.4), (0.01, 1000.0, 0.0)]
    {
        let numbers = |method: WorldMethod, seconds: usize| {
            let it = sustained::pressed(method, period, stiffness, friction, seconds as f64)?;
            Some([100.0 * it.ripple, 100.0 * it.mean, 1e6 * it.place])
        };
        let scales = [scale(stiffness, period, PRESSED)];
        let own = coupled(PRESSED, 1, 2e-6, numbers);
        let title = format!(
            "{period} s, {stiffness} N/m, friction {friction}: ripple %, mean off %, place um"
        );
        let [basic, ..] = table(&title, own, |name| best(name, &scales, 1, numbers));
        assert!(own[1] < 0.1, "{own:?}");
        assert!(basic.is_none_or(|it| it[0] > 3.0 * own[0]), "{basic:?}");
    }
}

#[test]
#[ignore = "takes minutes"]
fn a_peg_that_is_pressed_for_a_minute() {
    let source = include_str!("../../../../../experiments/worlds/peg.toml");
    let scene = WorldFile::parse("peg.toml", source).unwrap().scene;
    let renders = |method: WorldMethod, seconds: usize| {
        let renderer = WorldRenderer::new(&scene.world, scene.loop_params(), method).ok()?;
        let [force, torque, deepest] = crate::pressed::pressed(&scene, &renderer, seconds)?;
        Some([force, torque, 1e3 * deepest])
    };
    let scales = [Scale::new(&scene)];
    let own = renders(scene.method("coupled").unwrap(), EVALUATED).unwrap();
    let title = "ripple of the force %, of the torque %, deepest mm";
    let [_, _, coupling, god_object] = table(title, own, |name| best(name, &scales, 1, renders));
    assert_eq!(god_object, None, "it does not turn its tool");
    assert!(own[0] < 3.0 && own[2] < 0.5 * coupling.unwrap()[2]);
}
