//! A recorded loop, replayed at the instants at which it sampled.

use crate::common::scene;
use palpate_core::Side;
use palpate_scene::method::{MethodName, Settings};
use palpate_scene::{Dropped, Jitter, Scene};
use palpate_study::sim::closed_loop::Bench;
use palpate_study::sim::replay::{Replay, ReplayError, ReplaySetup};
use palpate_study::sim::run::Run;
use palpate_testbed::recorded_path::PathError;

/// A loop that comes early and late, and misses samples.
fn imperfect() -> Scene {
    let mut scene = scene("experiment1");
    scene.timing.jitter = Jitter::Uniform { bound: 0.004 };
    scene.timing.dropped = Dropped::Probability(0.1);
    scene.timing.seed = 3;
    scene
}

/// The same on the device's other side.
fn mirrored(mut scene: Scene) -> Scene {
    scene.contact.side = Side::Negative;
    let device = scene.device.point_mass_mut().unwrap();
    for value in [
        &mut scene.object.position,
        &mut scene.object.velocity,
        &mut scene.virtual_force,
        &mut device.position,
        &mut device.velocity,
        &mut device.hand.force,
    ] {
        *value = -*value;
    }
    scene
}

fn recorded(run: &Run) -> (Vec<f64>, Vec<f64>) {
    let ticks = run.ticks.iter();
    ticks.map(|tick| (tick.time, tick.device_position)).unzip()
}

fn replay(scene: &Scene, run: &Run) -> Replay {
    let (times, positions) = recorded(run);
    Replay::at_recorded_instants(ReplaySetup::of_scene(scene), &times, &positions).unwrap()
}

#[test]
fn the_method_that_was_recorded_gives_the_forces_that_were_recorded() {
    for (scene, method) in [
        (imperfect(), MethodName::Basic),
        (imperfect(), MethodName::Hfcr),
        (imperfect(), MethodName::VirtualDamper),
        (mirrored(imperfect()), MethodName::Hfcr),
    ] {
        let run = Bench::new(&scene).unwrap().run(method).unwrap();
        let settings = scene.settings.get(&method).copied().unwrap_or_default();
        let again = replay(&scene, &run).run(method, &settings).unwrap();
        assert_eq!(again.ticks.len(), run.ticks.len());
        let peak = run.force.peak_force;
        assert!(peak > 0.5, "{method}: {peak} N");
        for (given, expected) in again.ticks.iter().zip(&run.ticks) {
            let (given, expected) = (
                given.output.force_on_object,
                expected.output.force_on_object,
            );
            assert!(
                (given - expected).abs() <= 1e-9 * peak,
                "{method}: {given} for {expected}"
            );
        }
        let leaks = [&again, &run].map(|run| run.last().ledger.held_leak.accumulated);
        assert!((leaks[0] - leaks[1]).abs() <= 1e-9, "{method}: {leaks:?}");
    }
}

#[test]
fn the_ideal_is_cut_where_the_recorded_loop_sampled() {
    let scene = imperfect();
    let run = Bench::new(&scene).unwrap().run(MethodName::Basic).unwrap();
    let replay = replay(&scene, &run);
    let grid = replay.reference().profile.grid();
    let (times, _) = recorded(&run);
    assert!(!grid.is_even());
    assert_eq!(grid.intervals(), times.len() - 1);
    for (interval, time) in times.iter().enumerate() {
        assert_eq!(grid.edge(interval), *time);
    }
    let smooth = replay.run(MethodName::Hfcr, &Settings::default()).unwrap();
    let error = |run: &Run| run.force.fidelity.unwrap().force_rendering_error;
    let basic = replay.run(MethodName::Basic, &Settings::default()).unwrap();
    assert!(error(&smooth) < error(&basic));
}

#[test]
fn a_loop_that_was_on_time_is_replayed_as_any_recording_is() {
    let scene = scene("experiment1");
    let run = Bench::new(&scene).unwrap().run(MethodName::Hfcr).unwrap();
    let (times, positions) = recorded(&run);
    let setup = ReplaySetup::of_scene(&scene);
    let resampled = Replay::new(setup, &times, &positions).unwrap();
    let measured = replay(&scene, &run);
    for method in MethodName::ALL {
        let [a, b] = [&resampled, &measured]
            .map(|replay| replay.run(method, &Settings::default()).unwrap().ticks);
        for (a, b) in a.iter().zip(&b) {
            assert_eq!(a.output, b.output, "{method}");
        }
    }
}

#[test]
fn what_is_no_motion_is_refused() {
    let setup = ReplaySetup::of_scene(&scene("experiment1"));
    let error = |times: &[f64], positions: &[f64]| {
        Replay::at_recorded_instants(setup, times, positions).unwrap_err()
    };
    assert_eq!(
        error(&[], &[]),
        ReplayError::Path(PathError::TooShort { samples: 0 })
    );
    assert!(matches!(
        error(&[0.0, 0.0], &[0.0, 0.0]),
        ReplayError::Path(PathError::TimeNotIncreasing { index: 1, .. })
    ));
    assert!(matches!(
        error(&[0.0, 0.1], &[0.0, f64::NAN]),
        ReplayError::Path(PathError::PositionNotFinite { index: 1, .. })
    ));
}
