//! Properties of coupled rendering besides the energy ledger.

use palpate_core::{
    Contact, Coupled, CoupledParams, LoopParams, ObjectState, Output, Renderer, Sample, State,
};

use crate::common::{PointMass, Random};

const PERIOD: f64 = 0.01;
const WEIGHT: f64 = -0.981;

type Loop = Renderer<f64, Coupled<f64>>;

fn renderer(contact: Contact<f64>, model_mass: f64, quantum: f64) -> Loop {
    let params = CoupledParams::new(model_mass).with_encoder_quantum(quantum);
    Renderer::new(contact, LoopParams::new(PERIOD), params).unwrap()
}

fn measured(device: &PointMass, quantum: f64) -> f64 {
    if quantum > 0.0 {
        (device.position / quantum).round() * quantum
    } else {
        device.position
    }
}

/// Runs one period of the loop on a device.
fn tick(
    renderer: &Loop,
    state: &mut State<f64, palpate_core::CoupledMemory<f64>>,
    device: &mut PointMass,
    quantum: f64,
) -> Output<f64> {
    let sample = Sample::at(measured(device, quantum)).with_virtual_force(WEIGHT);
    let output = renderer.step(state, sample);
    assert_eq!(output.fault, None);
    device.hold(output.force_on_device, PERIOD);
    output
}

fn device(mass: f64) -> PointMass {
    PointMass {
        mass,
        user_force: 1.0,
        position: 0.0,
        velocity: 0.0,
    }
}

#[test]
fn it_never_pulls() {
    let mut random = Random(11);
    for _ in 0..200 {
        let stiffness = 10f64.powf(random.between(1.0, 4.5));
        let contact = if random.between(0.0, 1.0) < 0.2 {
            Contact::wall(stiffness)
        } else {
            Contact::object(stiffness, 10f64.powf(random.between(-2.0, 1.0)))
        };
        let renderer = renderer(contact, 0.25, 0.0);
        let mut state = renderer.start(ObjectState::at_rest(0.01)).unwrap();
        let mut position = 0.0;
        for _ in 0..500 {
            position = (position + random.between(-0.004, 0.004)).clamp(-0.02, 0.04);
            let sample = Sample::at(position).with_virtual_force(WEIGHT);
            let output = renderer.step(&mut state, sample);
            assert!(output.force_on_object >= 0.0, "{output:?}");
        }
    }
}

#[test]
fn the_mass_is_learned_from_contact() {
    for model in [0.15, 0.25, 0.5] {
        let renderer = renderer(Contact::object(100.0, 0.1), model, 0.0);
        let mut state = renderer.start(ObjectState::at_rest(0.05)).unwrap();
        let mut device = device(0.25);
        for _ in 0..300 {
            tick(&renderer, &mut state, &mut device, 0.0);
        }
        let learned = state.memory().device_mass().unwrap();
        assert!((learned / 0.25 - 1.0).abs() < 1e-3, "{model}: {learned}");
    }
}

#[test]
fn a_device_at_rest_teaches_nothing_however_long() {
    let quantum = 1e-5;
    let wall = renderer(Contact::wall(1000.0), 0.4, quantum);
    let mut state = wall.start(ObjectState::at_rest(0.0)).unwrap();
    // Estimation on the way to rest, then ten million samples of a device that is pressed in at rest.
    let mut pressing = Random(3);
    for _ in 0..200 {
        let position = pressing.between(0.001, 0.0012);
        wall.step(
            &mut state,
            Sample::at((position / quantum).round() * quantum),
        );
    }
    let settle = |state: &mut _, ticks: usize| {
        let mut last = wall.step(state, Sample::at(0.002));
        for _ in 1..ticks {
            last = wall.step(state, Sample::at(0.002));
        }
        last
    };
    let early = settle(&mut state, 10_000);
    let learned = state.memory().device_mass().unwrap();
    let late = settle(&mut state, 10_000_000);
    assert!((late.force_on_object - 2.0).abs() < 1e-9, "{late:?}");
    assert!((late.force_on_object - early.force_on_object).abs() < 1e-9);
    let now = state.memory().device_mass().unwrap();
    assert!((now / learned - 1.0).abs() < 1e-6, "{learned} became {now}");
}

/// Returns the largest difference `[N]` between the force and the spring force of the penetration, in the last 200 of
/// `ticks` against a wall with a device held in place by a stiff hand.
fn a_stopped_encoder_is_survived(renderer: &Loop) -> f64 {
    let mut state = renderer.start(ObjectState::at_rest(0.01)).unwrap();
    let mut device = device(0.25);
    for _ in 0..150 {
        tick(renderer, &mut state, &mut device, 0.0);
    }
    // The sensor value is constant, whatever the motor does.
    let stopped = measured(&device, 0.0);
    let mut largest = 0.0_f64;
    for _ in 0..20_000 {
        let output = renderer.step(&mut state, Sample::at(stopped).with_virtual_force(WEIGHT));
        assert_eq!(output.fault, None);
        largest = largest.max(output.force_on_object.abs());
    }
    largest
}

#[test]
fn a_stopped_encoder_leads_to_no_force_beyond_that_of_the_collisions_before() {
    let renderer = renderer(Contact::object(100.0, 0.1), 0.25, 1e-6);
    let largest = a_stopped_encoder_is_survived(&renderer);
    // The object continues to bounce on a device that is assumed at rest: 0.1 kg from 0.1 m on 100 N/m is 4.5 N plus
    // its weight.
    assert!(largest < 8.0, "{largest} N");
}

#[test]
fn device_mass_is_reestimated_after_grab_or_release() {
    for (before, after) in [(0.25, 1.0), (1.0, 0.25), (0.25, 1e5)] {
        let renderer = renderer(Contact::object(200.0, 0.1), 0.25, 1e-6);
        let mut state = renderer.start(ObjectState::at_rest(0.05)).unwrap();
        let mut device = device(before);
        for _ in 0..300 {
            tick(&renderer, &mut state, &mut device, 1e-6);
        }
        device.mass = after;
        device.user_force = after.min(1.0);
        for i in 0..600 {
            let output = tick(&renderer, &mut state, &mut device, 1e-6);
            assert!(
                output.force_on_object < 40.0,
                "{before} -> {after} kg, sample {i}: {output:?}"
            );
        }
        let learned = state.memory().device_mass().unwrap();
        // Limit of the estimate relative to the model value.
        let reachable = after.min(1000.0 * 0.25);
        println!("{before} -> {after} kg: learned {learned:.3} kg");
        assert!(
            learned / reachable > 0.7 && learned / reachable < 1.4,
            "{before} -> {after} kg: learned {learned}"
        );
    }
}

#[test]
fn momentum_of_the_object_is_the_impulse_it_got() {
    // Over a whole collision, with a model mass wrong by 1.5: the momentum lost by the device equals that gained by the
    // object, except for the part of the last correction that is still pending.
    let renderer = renderer(Contact::object(400.0, 0.1), 0.375, 0.0);
    let mut state = renderer.start(ObjectState::at_rest(0.05)).unwrap();
    let mut device = device(0.25);
    let mut impulse = 0.0;
    let mut samples = 0;
    let mut output = tick(&renderer, &mut state, &mut device, 0.0);
    while samples < 5 || output.penetration > 0.0 || impulse == 0.0 {
        impulse += output.force_on_object * PERIOD;
        output = tick(&renderer, &mut state, &mut device, 0.0);
        samples += 1;
        assert!(samples < 200);
    }
    for _ in 0..6 {
        impulse += output.force_on_object * PERIOD;
        samples += 1;
        output = tick(&renderer, &mut state, &mut device, 0.0);
    }
    let gained = 0.1 * output.object_velocity;
    let given = impulse + WEIGHT * PERIOD * f64::from(samples);
    assert!(
        (gained - given).abs() < 1e-4 * impulse,
        "gained {gained}, was given {given}, of that {impulse} by contact"
    );
}

#[test]
fn a_slower_loop_is_planned_for_after_two_samples() {
    // A device at constant speed into a heavy wall that cannot deflect it: a recorded motion, for which the mean force
    // of an interval is the spring force at its middle.
    let params = CoupledParams::new(f64::INFINITY);
    let renderer: Loop =
        Renderer::new(Contact::wall(100.0), LoopParams::new(PERIOD), params).unwrap();
    let mut state = renderer.start(ObjectState::at_rest(0.0)).unwrap();
    let (mut time, speed) = (0.0, 0.1);
    let mut off = Vec::new();
    for i in 0..60 {
        let elapsed = if i < 40 { PERIOD } else { 5.0 * PERIOD };
        time += elapsed;
        let sample = Sample::at(speed * time).after(elapsed);
        let output = renderer.step(&mut state, sample);
        let next = if i < 39 { PERIOD } else { 5.0 * PERIOD };
        let mean = 100.0 * speed * (time + 0.5 * next);
        off.push((output.force_on_object - mean).abs());
    }
    assert!(off[30..39].iter().all(|off| *off < 1e-3), "{off:?}");
    // Two intervals are planned too short; afterwards the plan is for the slow loop.
    assert!(
        off[40] > 0.1 && off[43..].iter().all(|off| *off < 1e-3),
        "{off:?}"
    );
}

#[test]
fn single_precision_follows_double() {
    let model = 0.3;
    let double = renderer(Contact::object(100.0, 0.1), model, 1e-5);
    let single = Renderer::<f32, Coupled<f32>>::new(
        Contact::object(100.0, 0.1),
        LoopParams::new(0.01),
        CoupledParams::new(0.3).with_encoder_quantum(1e-5),
    )
    .unwrap();
    let mut state = double.start(ObjectState::at_rest(0.05)).unwrap();
    let mut narrow = single.start(ObjectState::at_rest(0.05)).unwrap();
    let mut device = device(0.25);
    let (mut difference, mut size) = (0.0, 0.0);
    for _ in 0..100 {
        #[allow(clippy::cast_possible_truncation)]
        let position = measured(&device, 1e-5) as f32;
        let output = tick(&double, &mut state, &mut device, 1e-5);
        let other = single.step(&mut narrow, Sample::at(position).with_virtual_force(-0.981));
        difference += (f64::from(other.force_on_object) - output.force_on_object).powi(2);
        size += output.force_on_object.powi(2);
    }
    let relative = (difference / size).sqrt();
    println!("f32 against f64: {relative:e} of the force");
    assert!(relative < 2e-3, "{relative}");
}

#[test]
fn a_wall_that_waited_for_a_sample_goes_back_to_its_place() {
    let renderer = renderer(Contact::wall(400.0), 0.25, 0.0);
    let mut state = renderer.start(ObjectState::at_rest(0.0)).unwrap();
    let (mut farthest, mut waited) = (0.0_f64, 0);
    for visit in 0..100 {
        let mut device = PointMass {
            position: -0.02,
            ..device(0.25)
        };
        for i in 0..60 {
            // The encoder sometimes fails, most often during contact.
            let pressed = device.position > 0.0;
            let fails = i % 7 == visit % 7;
            let at = if fails { f64::NAN } else { device.position };
            let output = renderer.step(&mut state, Sample::at(at));
            device.hold(output.force_on_device, PERIOD);
            device.velocity *= 0.99;
            farthest = farthest.max(output.object_position.abs());
            waited += usize::from(fails && pressed && output.object_position != 0.0);
        }
        // The hand moves the device away.
        for _ in 0..2 {
            renderer.step(&mut state, Sample::at(-0.02));
        }
        let output = renderer.step(&mut state, Sample::at(-0.02));
        assert!(
            output.object_position.abs() < 1e-15,
            "{} m off after {visit} visits",
            output.object_position
        );
    }
    assert!(waited > 100, "{waited}");
    assert!((1e-5..5e-3).contains(&farthest), "{farthest}");
}

/// After a collision has determined the mass, dry friction changes its sign. For an exact sensor this is a kick of a
/// micrometre, which must not widen the variance of the mass.
#[test]
fn a_kick_of_friction_puts_no_learned_mass_in_doubt() {
    const FRICTION: f64 = 0.01;
    let (mass, period) = (0.07, 0.0012);
    for model in [0.035, 0.05, 0.07, 0.1, 0.14] {
        let params = CoupledParams::new(model);
        let loop_params = LoopParams {
            actuation: palpate_core::Actuation::after_samples(1, period),
            ..LoopParams::new(period)
        };
        let contact = Contact::object(16_000.0, 0.025);
        let renderer: Loop = Renderer::new(contact, loop_params, params).unwrap();
        let mut state = renderer.start(ObjectState::at_rest(0.01)).unwrap();
        let mut device = device(mass);
        let (mut late, mut learned, mut touched) = (0.0, Vec::new(), false);
        for _ in 0..400 {
            let sample = Sample::at(device.position).with_virtual_force(-0.25);
            let output = renderer.step(&mut state, sample);
            assert_eq!(output.fault, None);
            touched |= output.penetration > 0.0;
            device.user_force = 0.2 - FRICTION.copysign(device.velocity);
            device.hold(late, period);
            late = output.force_on_device;
            if touched {
                learned.push(state.memory().device_mass().unwrap());
            }
        }
        // Two samples of delay, and one to observe their effect.
        let off = |mass_now: &f64| (mass_now / mass - 1.0).abs();
        let worst = learned[6..].iter().map(off).fold(0.0, f64::max);
        println!("told {model} kg: mass off by up to {:.2} %", 100.0 * worst);
        assert!(worst < 0.05, "told {model} kg: off by {worst}");
    }
}
