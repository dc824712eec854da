//! Which method leaks most: sums of absolute leaks, whose terms cannot cancel.

use palpate_core::Contact;
use palpate_scene::Measure;
use palpate_scene::method::{MethodName, Settings};
use palpate_study::sim::closed_loop::Bench;
use palpate_study::sim::replay::Replay;

use crate::common::{
    Random, Trajectory, damping, lifted_object, recorded_hands, scene, synthetic_hand,
};

const ORDERED: [MethodName; 3] = [
    MethodName::HfcrModSt,
    MethodName::HfcrMod,
    MethodName::Basic,
];

fn hands(caller: &str) -> Vec<Trajectory> {
    let mut hands: Vec<_> = (0..6).map(synthetic_hand).collect();
    hands.extend(recorded_hands(caller));
    hands
}

/// Source: Eq. (10), the leak that the paper's steps are made to lower; the order is derived here.
///
/// Open loop: every method sees the same device motion.
#[test]
fn on_the_same_hand_motion_each_step_of_the_method_leaks_less() {
    for hand in hands("the order of leaks") {
        for period in [0.002, 0.005, 0.01] {
            let replay = lifted_object(&hand, period, false);
            let [smooth, modified, basic] = ORDERED.map(|method| {
                let run = replay.run(method, &Settings::default()).unwrap();
                run.last().ledger.held_leak.absolute
            });
            eprintln!(
                "{} at {:.0} ms: basic {:.3} mJ, modified {:.3} mJ, with transition {:.3} mJ",
                hand.name,
                1e3 * period,
                1e3 * basic,
                1e3 * modified,
                1e3 * smooth
            );
            assert!(smooth < basic && smooth < modified, "{}", hand.name);
        }
    }
}

/// Source: derived here. In a closed loop each method makes its own motion, so the order is a
/// tendency and no law.
#[test]
fn in_closed_loops_the_order_of_leaks_holds_mostly() {
    let mut random = Random(5);
    let loops = 400;
    let (mut least, mut below_basic, mut in_order) = (0, 0, 0);
    for _ in 0..loops {
        let mut scene = scene("experiment1");
        let (kappa, object_kappa) = (random.decades(1e-2, 2.0), random.decades(1e-2, 2.0));
        let (m, t) = (scene.device.mass(), scene.loop_params.period);
        let stiffness = kappa * m / (t * t);
        let mass = stiffness * t * t / object_kappa;
        scene.contact = Contact::object(stiffness, mass);
        scene.virtual_force = -9.81 * mass;
        scene.device.point_mass_mut().unwrap().hand.force = random.between(0.5, 1.5) * 9.81 * mass;
        scene.measure = Measure::Duration(60.0 * t);
        let bench = Bench::new(&scene).unwrap();
        let [smooth, modified, basic] =
            ORDERED.map(|method| bench.run(method).unwrap().last().ledger.held_leak.absolute);
        least += usize::from(smooth <= modified && smooth <= basic);
        below_basic += usize::from(smooth <= basic);
        in_order += usize::from(smooth <= modified && modified <= basic);
    }
    eprintln!(
        "of {loops} closed loops: with transition least in {least}, below basic in {below_basic}, \
         and modified between them in {in_order}"
    );
    assert!(least > loops * 7 / 10, "{least}");
    assert!(below_basic > loops * 9 / 10, "{below_basic}");
    // The order does not hold in every loop.
    assert!(in_order < loops);
}

/// Source: the paper's second experiment, with a point mass; derived here. The 80 samples of the
/// reference vectors close 79 intervals; the window of six collisions has 62.
#[test]
fn in_the_second_experiment_the_modified_force_alone_leaks_most() {
    let mut scene = scene("experiment2");
    for (intervals, expected) in [(79.0, [0.082, 4.09, 1.29]), (62.0, [0.062, 3.35, 1.29])] {
        scene.measure = Measure::Duration(intervals * scene.loop_params.period);
        let bench = Bench::new(&scene).unwrap();
        let leaks =
            ORDERED.map(|method| bench.run(method).unwrap().last().ledger.held_leak.absolute);
        eprintln!("{intervals} intervals: with transition, modified, basic: {leaks:.4?} J");
        assert_eq!(bench.reference().profile.intervals() as f64, intervals);
        for (leak, expected) in leaks.into_iter().zip(expected) {
            assert!(
                (leak / expected - 1.0).abs() < 0.03,
                "{leak} for {expected}"
            );
        }
    }
}

/// Source: derived here; the paper's methods are bilateral for part of an interval.
#[test]
fn transition_and_dissipation_can_pull_and_a_unilateral_contact_cannot() {
    for hand in hands("sticky forces") {
        let mut pulls = Vec::new();
        for unilateral in [false, true] {
            let replay: Replay = lifted_object(&hand, 0.01, unilateral);
            for (method, settings) in [
                (MethodName::HfcrModSt, Settings::default()),
                (MethodName::Hfcr, damping(0.5)),
            ] {
                let run = replay.run(method, &settings).unwrap();
                pulls.push(run.strongest_pull(1.0));
                assert_eq!(run.limited() > 0, unilateral, "{} {method}", hand.name);
            }
        }
        eprintln!(
            "{}: transition pulls by {:.3} N, with dissipation {:.3} N; unilateral {:.3} and {:.3} N",
            hand.name, pulls[0], pulls[1], pulls[2], pulls[3]
        );
        assert!(pulls[0] > 0.01 && pulls[1] > 0.01, "{pulls:?}");
        assert_eq!(pulls[2..], [0.0, 0.0]);
    }
}
