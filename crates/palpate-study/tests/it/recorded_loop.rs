//! A loop that was recorded, closed again around its hand: by the method that was recorded, at the
//! instants at which it sampled, it does again what it did.

use std::sync::Arc;

use crate::common::scene;
use palpate_core::Side;
use palpate_scene::method::MethodName;
use palpate_scene::{Delay, Dropped, Grip, Hand, Intention, Jitter, Measure, Scene, Wave};
use palpate_study::sim::closed_loop::Bench;
use palpate_study::sim::hand_replay::{
    HandModel, RecordedHand, Recording, largest_departure, scene_at_recorded_instants,
};
use palpate_study::sim::replay::ReplaySetup;
use palpate_study::sim::run::Run;

const QUANTUM: f64 = 2e-6;

/// A hand that swings and holds on, at 500 Hz; the loop comes early and late and misses samples.
fn recorded_scene() -> Scene {
    let mut scene = scene("experiment1");
    scene.loop_params.period = 0.002;
    scene.contact.stiffness = 400.0;
    scene.object.position = 0.01;
    let device = scene.device.point_mass_mut().unwrap();
    device.encoder_quantum = QUANTUM;
    device.hand = Hand {
        grip: Some(Grip {
            mass: 0.0,
            stiffness: 60.0,
            damping: 2.0,
            intention: Intention::Place {
                position: 0.01,
                swing: Some(Wave {
                    amplitude: 0.02,
                    frequency_hz: 1.5,
                }),
            },
        }),
        ..Hand::default()
    };
    scene.timing.jitter = Jitter::Uniform { bound: 0.0006 };
    scene.timing.dropped = Dropped::Probability(0.03);
    scene.timing.seed = 5;
    scene.measure = Measure::Duration(1.5);
    scene
}

/// The same on the device's other side.
fn mirrored(mut scene: Scene) -> Scene {
    scene.contact.side = Side::Negative;
    let device = scene.device.point_mass_mut().unwrap();
    let grip = device.hand.grip.as_mut().unwrap();
    let Intention::Place {
        position,
        swing: Some(swing),
    } = &mut grip.intention
    else {
        panic!("the hand swings")
    };
    for value in [
        &mut scene.object.position,
        &mut scene.virtual_force,
        &mut device.position,
        position,
        &mut swing.amplitude,
    ] {
        *value = -*value;
    }
    scene
}

/// A recording.
struct Recorded {
    times: Vec<f64>,
    positions: Vec<f64>,
    forces: Vec<f64>,
}

impl Recorded {
    fn new(run: &Run) -> Self {
        Self {
            times: run.ticks.iter().map(|tick| 3.0 + tick.time).collect(),
            positions: run.ticks.iter().map(|tick| tick.device_position).collect(),
            forces: run
                .ticks
                .iter()
                .map(|tick| -tick.held_force_on_object)
                .collect(),
        }
    }

    fn model(scene: &Scene) -> HandModel {
        HandModel {
            encoder_quantum: scene.device.encoder_quantum(),
            ..HandModel::force_on(scene.device.mass())
        }
    }

    fn hand(&self, scene: &Scene) -> Arc<RecordedHand> {
        self.hand_as(&Self::model(scene))
    }

    fn hand_as(&self, model: &HandModel) -> Arc<RecordedHand> {
        let recording = Recording {
            times: &self.times,
            positions: &self.positions,
            forces_on_device: Some(&self.forces),
        };
        Arc::new(RecordedHand::estimate(&recording, model).unwrap())
    }
}

/// The loop of `scene` closed again around `hand`.
fn again(hand: &Arc<RecordedHand>, scene: &Scene, method: MethodName) -> Run {
    let setup = ReplaySetup::of_scene(scene);
    let mut closed = scene_at_recorded_instants(Arc::clone(hand), &setup).unwrap();
    closed.settings.clone_from(&scene.settings);
    Bench::new(&closed).unwrap().run(method).unwrap()
}

fn farthest(run: &Run, other: &Run, of: fn(&palpate_study::sim::run::Tick) -> f64) -> f64 {
    assert_eq!(run.ticks.len(), other.ticks.len());
    let apart = run.ticks.iter().zip(&other.ticks);
    apart
        .map(|(a, b)| (of(a) - of(b)).abs())
        .fold(0.0, f64::max)
}

#[test]
fn the_method_that_was_recorded_gives_its_motion_and_its_forces_back() {
    let delayed = |mut scene: Scene| {
        // A command comes with a later sample, so samples come on time.
        scene.timing.jitter = Jitter::None;
        scene.timing.dropped = Dropped::None;
        scene.delay = Delay::samples(2);
        scene
    };
    for (scene, method) in [
        (recorded_scene(), MethodName::Basic),
        (recorded_scene(), MethodName::Hfcr),
        (recorded_scene(), MethodName::Coupled),
        (mirrored(recorded_scene()), MethodName::Coupled),
        (delayed(recorded_scene()), MethodName::Coupled),
    ] {
        let run = Bench::new(&scene).unwrap().run(method).unwrap();
        let hand = Recorded::new(&run).hand(&scene);
        let closed = again(&hand, &scene, method);
        for (a, b) in closed.ticks.iter().zip(&run.ticks) {
            assert!((a.time - b.time).abs() < 1e-9, "{} for {}", a.time, b.time);
        }
        let moved = farthest(&closed, &run, |tick| tick.true_device_position);
        let pushed = farthest(&closed, &run, |tick| tick.held_force_on_object);
        let peak = run.force.peak_force;
        eprintln!(
            "{method}: {moved:.1e} m apart, {pushed:.4} N of {peak:.2} N; {:?}",
            hand.uncertainty()
        );
        assert!(peak > 0.5, "{method}: {peak}");
        // The permanent displacement of the device, with a delay of two samples, dominates.
        assert!(moved < 30.0 * QUANTUM, "{method}: {moved}");
        assert!(pushed < 0.04 * peak, "{method}: {pushed} of {peak}");
        let departure = largest_departure(&hand, &closed);
        assert!(departure < 30.0 * QUANTUM, "{method}: {departure}");
        assert_eq!(closed.diverged, Some(false));
    }
}

#[test]
fn another_method_does_what_it_would_have_done_in_that_hand() {
    let scene = recorded_scene();
    let bench = Bench::new(&scene).unwrap();
    let run = bench.run(MethodName::Basic).unwrap();
    let mut holds_on = Recorded::model(&scene);
    let grip = scene.device.grip().unwrap();
    (holds_on.stiffness, holds_on.damping) = (grip.stiffness, grip.damping);
    let hand = Recorded::new(&run).hand_as(&holds_on);
    for method in [MethodName::Coupled, MethodName::Hfcr] {
        let closed = again(&hand, &scene, method);
        let departure = largest_departure(&hand, &closed);
        let truth = bench.run(method).unwrap();
        let apart = farthest(&closed, &truth, |tick| tick.true_device_position);
        eprintln!("{method}: {apart:.1e} m apart, {departure:.1e} m from the recorded motion");
        assert!(departure > 1e-3, "{method}: {departure}");
        assert!(apart < 0.01 * departure, "{method}: {apart} of {departure}");
    }
}

#[test]
fn a_sample_without_a_position_is_bridged_with_the_force_that_was_held_there() {
    let scene = recorded_scene();
    let run = Bench::new(&scene).unwrap().run(MethodName::Hfcr).unwrap();
    let mut recorded = Recorded::new(&run);
    let whole = recorded.hand(&scene);
    let mut missing = 0;
    let last = recorded.positions.len() - 1;
    for (at, position) in recorded.positions[..last].iter_mut().enumerate() {
        if at % 9 == 1 || (300..306).contains(&at) {
            *position = f64::NAN;
            missing += 1;
        }
    }
    let hand = recorded.hand(&scene);
    assert_eq!((whole.unmeasured(), hand.unmeasured()), (0, missing));
    assert_eq!(hand.times(), whole.times());
    let closed = again(&hand, &scene, MethodName::Hfcr);
    let moved = farthest(&closed, &run, |tick| tick.true_device_position);
    eprintln!("{missing} missing: {moved:.1e} m, {:?}", hand.uncertainty());
    assert!(moved < 40.0 * QUANTUM, "{moved}");
    // Where nothing was seen the force is known less well.
    let deviation = |hand: &RecordedHand, at| hand.forces().nth(at).unwrap().deviation;
    assert!(deviation(&hand, 302) > 1.2 * deviation(&hand, 200));
    // The motor forces between the measured positions still count.
    let mut without = recorded.forces.clone();
    for force in &mut without[301..306] {
        *force += 2.0;
    }
    recorded.forces = without;
    let misled = recorded.hand(&scene);
    let force = |hand: &RecordedHand| hand.forces().nth(303).unwrap().force;
    assert!((force(&misled) - force(&hand)).abs() > 1.0);
}

#[test]
fn ends_without_a_position_and_jitter_of_recorded_instants_are_refused() {
    let scene = recorded_scene();
    let run = Bench::new(&scene).unwrap().run(MethodName::Basic).unwrap();
    for at in [0, run.ticks.len() - 1] {
        let mut recorded = Recorded::new(&run);
        recorded.positions[at] = f64::NAN;
        let recording = Recording {
            times: &recorded.times,
            positions: &recorded.positions,
            forces_on_device: None,
        };
        let error = RecordedHand::estimate(&recording, &HandModel::force_on(0.2)).unwrap_err();
        let said = error.to_string();
        assert!(
            said.contains(&format!("position NaN m at index {at} ")),
            "{said}"
        );
    }
    let hand = Recorded::new(&run).hand(&scene);
    let setup = ReplaySetup::of_scene(&scene);
    let mut both = scene_at_recorded_instants(hand, &setup).unwrap();
    both.delay = Delay::Periods {
        samples: 0,
        fraction: 0.5,
    };
    let said = Bench::new(&both).unwrap_err().to_string();
    assert!(said.contains("samples as recorded"), "{said}");
}
