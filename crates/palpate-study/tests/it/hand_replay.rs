//! Replay of a recorded hand: its force is estimated within the stated uncertainty, and the replayed loop equals the
//! true loop of this hand.

use std::f64::consts::TAU;
use std::sync::Arc;

use crate::common::{Random, recorded_hands};
use palpate_core::{
    Actuation, AnyRenderer, Contact, LoopParams, ObjectState, Renderer, Sample, Side,
};
use palpate_scene::method::MethodName;
use palpate_study::sim::closed_loop::Bench;
use palpate_study::sim::hand_replay::{
    HandError, HandModel, RecordedHand, Recording, largest_departure, scene,
};
use palpate_study::sim::replay::ReplaySetup;

/// Recording step `[s]`.
const STEP: f64 = 0.001;
const MASS: f64 = 0.25;
const QUANTUM: f64 = 5e-6;

/// A hand that swings a device to and fro and trembles: its force `[N]`.
fn hand_force(t: f64) -> f64 {
    0.9 * (TAU * 1.3 * t).cos() - 0.35 * (TAU * 3.1 * t + 0.4).sin() + 0.05 * (TAU * 8.0 * t).sin()
}

/// A device in that hand, moved in fine steps between samples, exactly for a force that is a straight
/// line over each.
struct True {
    time: f64,
    position: f64,
    velocity: f64,
}

impl True {
    const FINE: f64 = 5e-5;

    fn at_rest() -> Self {
        Self {
            time: 0.0,
            position: -0.01,
            velocity: 0.0,
        }
    }

    fn advance(&mut self, force_on_device: f64, duration: f64) {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a few hundred"
        )]
        let steps = (duration / Self::FINE).round() as u32;
        let h = duration / f64::from(steps);
        for _ in 0..steps {
            let now = (hand_force(self.time) + force_on_device) / MASS;
            let then = (hand_force(self.time + h) + force_on_device) / MASS;
            self.position += h * (self.velocity + h * (2.0 * now + then) / 6.0);
            self.velocity += 0.5 * h * (now + then);
            self.time += h;
        }
    }
}

fn setup(contact: Contact<f64>, period: f64) -> ReplaySetup {
    ReplaySetup {
        contact,
        loop_params: LoopParams::new(period),
        object: ObjectState::at_rest(0.004),
        virtual_force: 0.0,
        actuation: Actuation::default(),
        device_mass: None,
        encoder_quantum: 0.0,
    }
}

fn block() -> Contact<f64> {
    Contact::object(400.0, 0.1)
}

/// The true closed loop of that hand by `method`: positions, and forces on the device from each sample
/// on.
fn true_loop(method: MethodName, setup: &ReplaySetup, samples: usize) -> (Vec<f64>, Vec<f64>) {
    let model = ReplaySetup {
        device_mass: Some(MASS),
        ..*setup
    };
    let mut device = True::at_rest();
    let params = model
        .params(method, &Default::default(), device.position, false)
        .unwrap();
    let renderer: AnyRenderer<f64> =
        Renderer::new(setup.contact, setup.loop_params, params).unwrap();
    let mut state = renderer.start(setup.object).unwrap();
    let (mut positions, mut forces) = (Vec::new(), Vec::new());
    for _ in 0..samples {
        let output = renderer.step(&mut state, Sample::at(device.position));
        positions.push(device.position);
        forces.push(output.force_on_device);
        device.advance(output.force_on_device, setup.loop_params.period);
    }
    (positions, forces)
}

/// Recording at 1 kHz of `seconds` of that hand on the block.
struct Recorded {
    times: Vec<f64>,
    exact: Vec<f64>,
    positions: Vec<f64>,
    forces: Vec<f64>,
}

fn recorded(seconds: f64) -> Recorded {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a few thousand"
    )]
    let samples = (seconds / STEP).round() as usize + 1;
    let (exact, forces) = true_loop(MethodName::Basic, &setup(block(), STEP), samples);
    Recorded {
        times: (0..samples).map(|i| 7.0 + i as f64 * STEP).collect(),
        positions: exact
            .iter()
            .map(|x| (x / QUANTUM).round() * QUANTUM)
            .collect(),
        exact,
        forces,
    }
}

impl Recorded {
    fn recording(&self) -> Recording<'_> {
        Recording {
            times: &self.times,
            positions: &self.positions,
            forces_on_device: Some(&self.forces),
        }
    }
}

fn model() -> HandModel {
    HandModel {
        encoder_quantum: QUANTUM,
        ..HandModel::force_on(MASS)
    }
}

fn root_mean_square(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| {
        (sum + value * value, count + 1.0)
    });
    f64::sqrt(sum / count)
}

#[test]
fn the_force_of_a_hand_is_found_within_what_is_said_of_it() {
    let recorded = recorded(2.0);
    assert!(
        recorded.forces.iter().any(|force| *force < -1.0),
        "no contact"
    );
    let hand = RecordedHand::estimate(&recorded.recording(), &model()).unwrap();
    let said = hand.uncertainty();
    eprintln!("{said:?}");
    // At the ends only one side has samples, and the reported deviation is larger.
    let errors: Vec<f64> = hand
        .forces()
        .map(|at| (at.force - hand_force(at.time)) / at.deviation)
        .collect();
    let spread = root_mean_square(errors.iter().copied());
    let largest = errors.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    eprintln!("errors over their deviation: rms {spread:.2}, largest {largest:.2}");
    assert!((0.3..1.5).contains(&spread), "{spread}");
    assert!(largest < 5.0, "{largest}");
    // Well enough to be of use: a few percent of the force.
    assert!(said.force_deviation < 0.05 * said.force, "{said:?}");
    let true_force = root_mean_square(recorded.times.iter().map(|t| hand_force(t - 7.0)));
    assert!((said.force / true_force - 1.0).abs() < 0.02, "{said:?}");
    // The sensor's noise is found, too.
    let noise = QUANTUM / 12.0_f64.sqrt();
    assert!(
        (0.9..1.3).contains(&(said.position_noise / noise)),
        "{said:?}"
    );
    // Errors within the quantum are below the sensor noise.
    let exact = (0..recorded.times.len()).map(|i| {
        let (position, _) = hand.motion(i as f64 * STEP);
        position - recorded.exact[i]
    });
    assert!(root_mean_square(exact) < noise);
}

#[test]
fn without_the_recorded_force_it_is_taken_for_the_hand_s() {
    let recorded = recorded(2.0);
    let blind = Recording {
        forces_on_device: None,
        ..recorded.recording()
    };
    let hand = RecordedHand::estimate(&blind, &model()).unwrap();
    let both = hand
        .forces()
        .zip(&recorded.forces)
        .map(|(at, motor)| at.force - hand_force(at.time) - motor);
    let motor = root_mean_square(recorded.forces.iter().copied());
    assert!(root_mean_square(both) < 0.25 * motor);
}

#[test]
fn the_recorded_force_gives_the_recorded_motion_back() {
    let recorded = recorded(2.0);
    let hand = Arc::new(RecordedHand::estimate(&recorded.recording(), &model()).unwrap());
    let within = hand.uncertainty().given_back_within;
    // Two seconds of a force on a mass: a thousandth of it wrong would be 7 mm.
    assert!(within < 2.0 * QUANTUM, "{within}");
    // In the loop that was recorded, on the recorder's own samples, the same force comes out again.
    let scene = scene(Arc::clone(&hand), &setup(block(), STEP)).unwrap();
    let run = Bench::new(&scene).unwrap().run(MethodName::Basic).unwrap();
    assert_eq!(run.ticks.len(), recorded.times.len());
    let off = run
        .ticks
        .iter()
        .zip(&recorded.exact)
        .map(|(tick, exact)| (tick.true_device_position - exact).abs())
        .fold(0.0, f64::max);
    eprintln!("given back within {within:.2e} m, in the loop {off:.2e} m");
    assert!(off < 5e-5, "{off}");
}

#[test]
fn the_closed_loop_is_that_of_the_recorded_hand() {
    let recorded = recorded(2.0);
    let hand = Arc::new(RecordedHand::estimate(&recorded.recording(), &model()).unwrap());
    for (method, contact) in [
        (MethodName::Coupled, block()),
        (MethodName::Hfcr, block()),
        (MethodName::Coupled, Contact::object(900.0, 0.3)),
        (MethodName::VirtualDamper, Contact::wall(300.0)),
    ] {
        let other = setup(contact, 0.01);
        let scene = scene(Arc::clone(&hand), &other).unwrap();
        let run = Bench::new(&scene).unwrap().run(method).unwrap();
        let (truth, _) = true_loop(method, &other, run.ticks.len());
        let apart = run
            .ticks
            .iter()
            .zip(&truth)
            .map(|(tick, truth)| (tick.true_device_position - truth).abs())
            .fold(0.0, f64::max);
        let departure = largest_departure(&hand, &run);
        eprintln!("{method} on {contact:?}: off by {apart:.2e} m of {departure:.2e} m");
        // It is another motion than the recorded one, and the right one.
        assert!(departure > 2e-3, "{method}: {departure}");
        assert!(apart < 0.02 * departure, "{method}: {apart} of {departure}");
    }
}

#[test]
fn no_contact_leaves_the_recorded_motion_as_it_is() {
    // The motor was off, and nothing is touched.
    let times: Vec<f64> = (0..1000).map(|i| f64::from(i) * STEP).collect();
    let positions: Vec<f64> = times.iter().map(|t| 0.01 * (TAU * t).sin()).collect();
    let recording = Recording {
        times: &times,
        positions: &positions,
        forces_on_device: None,
    };
    let hand = Arc::new(RecordedHand::estimate(&recording, &model()).unwrap());
    let far = ReplaySetup {
        object: ObjectState::at_rest(0.1),
        ..setup(block(), 0.01)
    };
    let scene = scene(Arc::clone(&hand), &far).unwrap();
    let run = Bench::new(&scene)
        .unwrap()
        .run(MethodName::Coupled)
        .unwrap();
    // The clocks of the loop and of the recording round differently.
    assert!(largest_departure(&hand, &run) < 1e-15);
    assert_eq!(run.bench_port_work, Some(0.0));
}

/// The hand of `recorded` that holds on to its motion.
fn firm(recorded: &Recorded, stiffness: f64, damping: f64) -> Arc<RecordedHand> {
    let model = HandModel {
        stiffness,
        damping,
        ..model()
    };
    Arc::new(RecordedHand::estimate(&recorded.recording(), &model).unwrap())
}

#[test]
fn a_firm_hand_holds_on_to_its_motion() {
    let recorded = recorded(2.0);
    let other = setup(Contact::object(900.0, 0.3), 0.01);
    let departures =
        [(0.0, 0.0), (50.0, 2.0), (500.0, 10.0), (1e6, 1e3)].map(|(stiffness, damping)| {
            let hand = firm(&recorded, stiffness, damping);
            let scene = scene(Arc::clone(&hand), &other).unwrap();
            let run = Bench::new(&scene).unwrap().run(MethodName::Hfcr).unwrap();
            largest_departure(&hand, &run)
        });
    eprintln!("{departures:?}");
    assert!(departures.is_sorted_by(|a, b| a > b), "{departures:?}");
    assert!(departures[3] < 1e-4, "{departures:?}");
}

#[test]
fn a_mirrored_recording_gives_the_mirrored_run() {
    let recorded = recorded(1.0);
    let negated = |values: &[f64]| -> Vec<f64> { values.iter().map(|value| -value).collect() };
    let (positions, forces) = (negated(&recorded.positions), negated(&recorded.forces));
    let mirrored = Recording {
        times: &recorded.times,
        positions: &positions,
        forces_on_device: Some(&forces),
    };
    let run = |recording: &Recording, side: Side| {
        let sign: f64 = side.sign();
        let mut contact = Contact::object(900.0, 0.3);
        contact.side = side;
        let setup = ReplaySetup {
            object: ObjectState::at_rest(sign * 0.004),
            ..setup(contact, 0.01)
        };
        let hand = Arc::new(RecordedHand::estimate(recording, &model()).unwrap());
        let scene = scene(hand, &setup).unwrap();
        Bench::new(&scene)
            .unwrap()
            .run(MethodName::Coupled)
            .unwrap()
    };
    let one = run(&recorded.recording(), Side::Positive);
    let other = run(&mirrored, Side::Negative);
    for (one, other) in one.ticks.iter().zip(&other.ticks) {
        assert_eq!(one.true_device_position, -other.true_device_position);
        assert_eq!(one.output.force_on_object, -other.output.force_on_object);
    }
}

#[test]
fn a_stated_bandwidth_is_kept_and_costs_what_it_leaves_out() {
    let recorded = recorded(2.0);
    let with = |bandwidth| {
        let model = HandModel {
            bandwidth: Some(bandwidth),
            ..model()
        };
        let hand = RecordedHand::estimate(&recorded.recording(), &model).unwrap();
        assert!((hand.uncertainty().bandwidth / bandwidth - 1.0).abs() < 1e-12);
        let error = hand.forces().map(|at| at.force - hand_force(at.time));
        root_mean_square(error)
    };
    let likely = RecordedHand::estimate(&recorded.recording(), &model()).unwrap();
    let best = likely.uncertainty().bandwidth;
    let at_best = with(best);
    eprintln!(
        "{best:.1} Hz: {at_best:.4} N; {:.4}, {:.4}",
        with(2.0),
        with(200.0)
    );
    // Slower it loses the hand, faster it takes the sensor for it.
    assert!(with(2.0) > 5.0 * at_best);
    assert!(with(200.0) > 5.0 * at_best);
}

#[test]
fn hand_release_is_smeared_only_over_estimator_bandwidth() {
    // The hand pushes with 0.3 N against its own spring, and releases the device at 1 s.
    const RELEASE: f64 = 1.0;
    let (mut position, mut velocity) = (0.0, 0.0);
    let (mut times, mut positions, mut truth) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..2000 {
        let time = f64::from(i) * STEP;
        // Held over each step, which makes the truth a staircase; its steps are far below its error.
        let force = if time < RELEASE {
            0.3 - 20.0 * position - 0.5 * velocity
        } else {
            0.0
        };
        times.push(time);
        positions.push((position / QUANTUM).round() * QUANTUM);
        truth.push(force);
        position += STEP * (velocity + 0.5 * STEP * force / MASS);
        velocity += STEP * force / MASS;
    }
    let recording = Recording {
        times: &times,
        positions: &positions,
        forces_on_device: None,
    };
    let hand = RecordedHand::estimate(&recording, &model()).unwrap();
    let bandwidth = hand.uncertainty().bandwidth;
    let largest = |near: &dyn Fn(f64) -> bool| {
        hand.forces()
            .zip(&truth)
            .filter(|(at, _)| near(at.time))
            .map(|(at, truth)| (at.force - truth).abs() / at.deviation)
            .fold(0.0, f64::max)
    };
    let from_release = |time: f64| (time - RELEASE).abs() * bandwidth;
    let at_jumps = largest(&|time| from_release(time) < 0.5);
    // It begins with a jump, too.
    let away = largest(&|time| from_release(time) > 1.5 && time * bandwidth > 1.5);
    eprintln!(
        "{bandwidth:.1} Hz: at the release {at_jumps:.1} deviations off, away from it {away:.1}"
    );
    assert!(away < 4.0, "{away}");
    assert!(at_jumps > away, "a jump is what a smoother cannot follow");
}

#[test]
fn uneven_steps_are_taken_as_they_are() {
    let mut random = Random(3);
    let mut t = 0.0;
    let mut times = Vec::new();
    while t < 2.0 {
        times.push(t);
        t += random.between(0.0004, 0.0024);
    }
    // A device in that hand with its motor off.
    let mut device = True::at_rest();
    let mut positions = Vec::new();
    for pair in times.windows(2) {
        positions.push((device.position / QUANTUM).round() * QUANTUM);
        device.advance(0.0, pair[1] - pair[0]);
    }
    times.pop();
    let recording = Recording {
        times: &times,
        positions: &positions,
        forces_on_device: None,
    };
    let hand = RecordedHand::estimate(&recording, &model()).unwrap();
    let spread = root_mean_square(
        hand.forces()
            .map(|at| (at.force - hand_force(at.time)) / at.deviation),
    );
    assert!((0.3..1.5).contains(&spread), "{spread}");
}

#[test]
fn what_shows_no_hand_is_refused_by_name() {
    let times: Vec<f64> = (0..20).map(|i| f64::from(i) * 0.01).collect();
    let positions = vec![0.0; 20];
    let recording = Recording {
        times: &times,
        positions: &positions,
        forces_on_device: None,
    };
    let refused = |recording: &Recording, model: &HandModel| {
        let error = RecordedHand::estimate(recording, model).unwrap_err();
        error.to_string()
    };
    for (model, words) in [
        (HandModel::force_on(0.0), "device_mass = 0"),
        (HandModel::force_on(f64::INFINITY), "device_mass = inf"),
        (
            HandModel {
                stiffness: -1.0,
                ..model()
            },
            "hand_stiffness = -1",
        ),
        (
            HandModel {
                damping: f64::NAN,
                ..model()
            },
            "hand_damping = NaN",
        ),
        (
            HandModel {
                bandwidth: Some(0.0),
                ..model()
            },
            "hand_bandwidth = 0",
        ),
    ] {
        let said = refused(&recording, &model);
        assert!(said.starts_with(words), "{said}");
    }
    let short = Recording {
        times: &times[..7],
        positions: &positions[..7],
        ..recording
    };
    assert!(refused(&short, &model()).contains("at least 8 samples with a position, not 7"));
    let fewer = Recording {
        forces_on_device: Some(&positions[..19]),
        ..recording
    };
    assert!(refused(&fewer, &model()).contains("20 positions but 19 forces"));
    let mut forces = positions.clone();
    forces[3] = f64::NAN;
    let wrong = Recording {
        forces_on_device: Some(&forces),
        ..recording
    };
    assert!(refused(&wrong, &model()).contains("the force of sample 3 is NaN N"));
    let huge = vec![1e308; 20];
    let wrong = Recording {
        forces_on_device: Some(&huge),
        ..recording
    };
    assert_eq!(
        RecordedHand::estimate(&wrong, &model()).unwrap_err(),
        HandError::Overflow
    );
    // A device at rest is a hand that does nothing.
    let hand = RecordedHand::estimate(&recording, &model()).unwrap();
    assert_eq!(hand.uncertainty().force, 0.0);
    let error = scene(Arc::new(hand), &setup(block(), 0.5)).unwrap_err();
    assert!(error.to_string().contains("less than one period of 0.5 s"));
}

#[test]
fn a_scene_of_a_recorded_hand_runs_and_has_no_file() {
    let times: Vec<f64> = (0..100).map(|i| f64::from(i) * 0.01).collect();
    let positions = vec![0.0; 100];
    let recording = Recording {
        times: &times,
        positions: &positions,
        forces_on_device: None,
    };
    let hand = Arc::new(RecordedHand::estimate(&recording, &model()).unwrap());
    let plain = scene(hand, &setup(block(), 0.01)).unwrap();
    assert!(Bench::new(&plain).is_ok());
    assert!(plain.to_toml().is_err(), "no key says it");
}

#[test]
fn recorded_people_are_given_back() {
    for human in recorded_hands("the force of recorded hands") {
        let recording = Recording {
            times: &human.times,
            positions: &human.positions,
            forces_on_device: None,
        };
        let hand = RecordedHand::estimate(&recording, &HandModel::force_on(0.28)).unwrap();
        let said = hand.uncertainty();
        eprintln!("{}: {said:?}", human.name);
        // Within a few deviations of its sensor, over the whole recording, and with a force that
        // stands out of its own uncertainty.
        assert!(
            said.given_back_within < 30.0 * said.position_noise,
            "{said:?}"
        );
        assert!(said.force_deviation < 0.5 * said.force, "{said:?}");
        assert!((1.0..500.0).contains(&said.bandwidth), "{said:?}");
    }
}
