//! Interpretations of ambiguous parts of the paper, and their properties.

use crate::common::Random;
use palpate_core::{
    Actuation, AnyParams, AnyRenderer, BasicParams, Contact, DamperObject, HfcrParams, LoopParams,
    Mass, ObjectState, Output, Prediction, Renderer, Sample, VirtualDamperParams,
};

const STIFFNESS: f64 = 400.0;
const MASS: f64 = 0.1;
const PERIOD: f64 = 0.005;
const WEIGHT: f64 = -0.981;
const B: f64 = 0.8;

fn damper(object: DamperObject, prediction: Prediction<f64>) -> AnyParams<f64> {
    AnyParams::VirtualDamper(VirtualDamperParams {
        object,
        prediction,
        ..VirtualDamperParams::new(B)
    })
}

/// A motion into and out of contact, at uneven instants.
fn samples() -> Vec<(f64, f64)> {
    let mut random = Random(11);
    let mut time = 0.0;
    (0..400)
        .map(|_| {
            let elapsed = PERIOD * random.pick(&[1.0, 1.0, 0.7, 1.6]);
            time += elapsed;
            (
                0.012 * (9.0 * time).sin() + 0.004 * (31.0 * time).cos(),
                elapsed,
            )
        })
        .collect()
}

fn outputs(renderer: &AnyRenderer<f64>, samples: &[(f64, f64)]) -> Vec<Output<f64>> {
    let mut state = renderer.start(ObjectState::at_rest(0.006)).unwrap();
    samples
        .iter()
        .map(|&(device, elapsed)| {
            let sample = Sample::at(device).with_virtual_force(WEIGHT).after(elapsed);
            let output = renderer.step(&mut state, sample);
            assert_eq!(output.fault, None);
            output
        })
        .collect()
}

fn on_object(params: AnyParams<f64>, loop_params: LoopParams<f64>) -> AnyRenderer<f64> {
    Renderer::new(Contact::object(STIFFNESS, MASS), loop_params, params).unwrap()
}

/// Runs samples one period apart against a wall at 0.
fn on_wall(params: AnyParams<f64>, positions: impl IntoIterator<Item = f64>) -> Vec<Output<f64>> {
    let renderer: AnyRenderer<f64> =
        Renderer::new(Contact::wall(STIFFNESS), LoopParams::new(PERIOD), params).unwrap();
    let mut state = renderer.start(ObjectState::at_rest(0.0)).unwrap();
    let steps = positions
        .into_iter()
        .map(|xi| renderer.step(&mut state, Sample::at(xi)));
    steps.collect()
}

#[test]
fn with_the_spring_alone_the_object_moves_as_in_the_basic_model_and_only_the_force_is_damped() {
    let loop_params = LoopParams::new(PERIOD);
    let spring = damper(DamperObject::Spring, Prediction::LastStep);
    let samples = samples();
    let damped = outputs(&on_object(spring, loop_params), &samples);
    let basic = outputs(&on_object(AnyParams::Basic, loop_params), &samples);
    let mut in_contact = 0;
    for tick in 1..samples.len() {
        let (damped, basic) = ([damped[tick - 1], damped[tick]], basic[tick]);
        let [before, now] = damped;
        assert_eq!(
            (now.object_position, now.object_velocity),
            (basic.object_position, basic.object_velocity)
        );
        if now.penetration > 0.0 {
            let rate = (now.penetration - before.penetration) / samples[tick].1;
            let expected = basic.force_on_object + B * rate;
            assert!((now.force_on_object - expected).abs() < 1e-12);
            in_contact += 1;
        } else {
            assert_eq!(now.force_on_object, 0.0);
        }
    }
    assert!(in_contact > 100, "{in_contact}");
    // The default gives another motion.
    let both = damper(DamperObject::SpringAndDamper, Prediction::LastStep);
    let both = outputs(&on_object(both, loop_params), &samples);
    assert!((both[399].object_position - basic[399].object_position).abs() > 1e-4);
}

#[test]
fn an_object_that_the_held_force_moves_takes_its_impulse_whatever_limits_and_delays_make_of_it() {
    let loops = [
        LoopParams::new(PERIOD),
        LoopParams::new(PERIOD).with_force_limit(1.5),
        LoopParams {
            actuation: Actuation::after_samples(2, PERIOD),
            ..LoopParams::new(PERIOD)
        },
    ];
    for (loop_params, delay) in loops.into_iter().zip([0, 0, 2]) {
        let params = damper(DamperObject::HeldForce, Prediction::LastStep);
        // A delay is a time; whole samples of delay require even spacing.
        let samples: Vec<_> = samples()
            .into_iter()
            .map(|(position, h)| (position, if delay > 0 { PERIOD } else { h }))
            .collect();
        let outputs = outputs(&on_object(params, loop_params), &samples);
        let (mut pushed, mut limited) = (0, 0);
        for tick in delay..samples.len() - 1 {
            let [now, next] = [outputs[tick], outputs[tick + 1]];
            let h = samples[tick + 1].1;
            // Force that has reached the motor.
            let force = outputs[tick - delay].force_on_object;
            let acceleration = (WEIGHT + force) / MASS;
            let velocity = now.object_velocity + acceleration * h;
            let position = now.object_position + (now.object_velocity + 0.5 * acceleration * h) * h;
            assert!((next.object_velocity - velocity).abs() < 1e-12);
            assert!((next.object_position - position).abs() < 1e-13);
            pushed += usize::from(force != 0.0);
            limited += usize::from(outputs[tick - delay].limited.force);
        }
        assert!(pushed > 40, "{pushed}");
        assert_eq!(loop_params.force_limit.is_some(), limited > 0);
    }
}

/// Positions of a device at constant acceleration that is in the wall from the start.
fn accelerated(count: u32) -> impl Iterator<Item = f64> {
    (0..count).map(|i| along(f64::from(i) * PERIOD))
}

fn along(t: f64) -> f64 {
    0.001 + 0.02 * t + 0.5 * 3.0 * t * t
}

#[test]
fn an_extrapolated_damper_knows_the_velocity_at_the_sample_and_the_last_step_half_a_period_before()
{
    let velocity = |t: f64| 0.02 + 3.0 * t;
    for (prediction, late) in [
        (Prediction::LastStep, 0.5),
        (Prediction::Extrapolation, 0.0),
    ] {
        let forces = on_wall(damper(DamperObject::Spring, prediction), accelerated(20));
        for (tick, output) in forces.iter().enumerate().skip(2) {
            let t = tick as f64 * PERIOD;
            let expected = STIFFNESS * along(t) + B * velocity(t - late * PERIOD);
            let error = output.force_on_object - expected;
            assert!(error.abs() < 1e-11, "{prediction:?}, {tick}: {error}");
        }
    }
}

#[test]
fn an_observed_damper_knows_the_velocity_at_the_sample_less_that_of_the_object() {
    let observer = Prediction::Observer {
        device_mass: Mass::Infinite,
        encoder_quantum: 0.0,
    };
    let forces = on_wall(damper(DamperObject::Spring, observer), accelerated(60));
    let t = 59.0 * PERIOD;
    let estimated = (forces[59].force_on_object - STIFFNESS * along(t)) / B;
    assert!((estimated - (0.02 + 3.0 * t)).abs() < 1e-3, "{estimated}");

    // A device at rest in an object: the velocity of the penetration is the object's own.
    let params = damper(DamperObject::Spring, observer);
    let renderer = on_object(params, LoopParams::new(PERIOD));
    let outputs = outputs(&renderer, &[(0.02, PERIOD); 40]);
    let mut pressed = 0;
    for output in &outputs {
        if output.penetration > 0.0 {
            let expected = STIFFNESS * output.penetration - B * output.object_velocity;
            assert!((output.force_on_object - expected).abs() < 1e-9);
            pressed += 1;
        }
    }
    assert!(pressed > 10, "{pressed}");
}

#[test]
fn on_a_quantised_ramp_the_adaptive_window_quietens_damper_and_hfcr() {
    let quantum = 1e-4;
    let window = Prediction::FirstOrderAdaptiveWindow {
        noise_bound: quantum,
        longest_window: 15.0 * PERIOD,
    };
    let speed = 0.0137;
    let ramp = |i: u32| 0.001 + speed * f64::from(i) * PERIOD;
    let measured = |i: u32| (ramp(i) / quantum).round() * quantum;
    // Largest velocity error visible in a force, once the window is full.
    let worst = |params: AnyParams<f64>, velocity: &dyn Fn(f64, u32) -> f64| {
        let outputs = on_wall(params, (0..200).map(measured));
        let errors = (20..200).map(|i| {
            let found = velocity(outputs[i as usize].force_on_object, i);
            (found - speed).abs()
        });
        errors.fold(0.0, f64::max)
    };
    let of_damper = |force: f64, i: u32| (force - STIFFNESS * measured(i)) / B;
    let of_hfcr = |force: f64, i: u32| (force / STIFFNESS - measured(i)) / (0.5 * PERIOD);
    let hfcr = |prediction| {
        AnyParams::Hfcr(HfcrParams {
            prediction,
            ..HfcrParams::default()
        })
    };
    let by_damper = |prediction| worst(damper(DamperObject::Spring, prediction), &of_damper);
    let by_hfcr = |prediction| worst(hfcr(prediction), &of_hfcr);
    for found in [by_damper(window), by_hfcr(window)] {
        assert!(found <= quantum / (15.0 * PERIOD) + 1e-9, "{found}");
    }
    for found in [
        by_damper(Prediction::LastStep),
        by_hfcr(Prediction::LastStep),
    ] {
        assert!(found > 0.3 * quantum / PERIOD, "{found}");
    }
}

#[test]
fn without_noise_the_adaptive_window_is_the_last_step_wherever_the_motion_is_curved() {
    let window = Prediction::FirstOrderAdaptiveWindow {
        noise_bound: 0.0,
        longest_window: 15.0 * PERIOD,
    };
    let samples = samples();
    let forces = |prediction| {
        let renderer = on_object(
            damper(DamperObject::SpringAndDamper, prediction),
            LoopParams::new(PERIOD),
        );
        outputs(&renderer, &samples)
    };
    for (one, other) in forces(window).iter().zip(forces(Prediction::LastStep)) {
        assert!((one.force_on_object - other.force_on_object).abs() < 1e-9);
    }
}

#[test]
fn an_object_that_was_put_elsewhere_has_no_velocity_by_it() {
    for prediction in [
        Prediction::Extrapolation,
        Prediction::FirstOrderAdaptiveWindow {
            noise_bound: 1.0,
            longest_window: 15.0 * PERIOD,
        },
    ] {
        let params = damper(DamperObject::Spring, prediction);
        let renderer = on_object(params, LoopParams::new(PERIOD));
        let mut state = renderer.start(ObjectState::at_rest(0.0)).unwrap();
        for _ in 0..5 {
            renderer.step(&mut state, Sample::at(0.01));
        }
        renderer
            .teleport(&mut state, ObjectState::at_rest(0.003))
            .unwrap();
        let output = renderer.step(&mut state, Sample::at(0.01));
        let expected = STIFFNESS * 0.007;
        assert!(
            (output.force_on_object - expected).abs() < 1e-12,
            "{prediction:?}: {output:?}"
        );
    }
}

#[test]
fn a_window_or_a_noise_bound_that_cannot_be_is_refused() {
    for (noise_bound, longest_window, said) in [
        (
            -1e-6,
            0.1,
            "noise_bound is -0.000001 m, but must be finite and not below 0",
        ),
        (f64::NAN, 0.1, "noise_bound is NaN m"),
        (
            0.0,
            0.0,
            "longest_window is 0 s, but must be finite and greater than 0",
        ),
        (0.0, f64::INFINITY, "longest_window is inf s"),
    ] {
        let prediction = Prediction::FirstOrderAdaptiveWindow {
            noise_bound,
            longest_window,
        };
        let contact = Contact::wall(STIFFNESS);
        let damper = VirtualDamperParams {
            prediction,
            ..VirtualDamperParams::new(B)
        };
        let hfcr = HfcrParams {
            prediction,
            ..HfcrParams::default()
        };
        let loop_params = LoopParams::new(PERIOD);
        let errors = [
            Renderer::new(contact, loop_params, damper).unwrap_err(),
            Renderer::new(contact, loop_params, hfcr).unwrap_err(),
        ];
        for error in errors {
            assert!(error.to_string().starts_with(said), "{error}");
        }
    }
    // Otherwise the same loop is valid.
    Renderer::new(
        Contact::wall(STIFFNESS),
        LoopParams::new(PERIOD),
        BasicParams,
    )
    .unwrap();
}
