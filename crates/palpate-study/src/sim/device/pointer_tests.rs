//! Compares a pointer's device with closed forms, and tests the transfer of state from its hand.

use super::*;
use palpate_device::clock::SteppedClock;

const MS: Duration = Duration::from_millis(1);

fn device(
    params: PointerParams,
    hand: &PointerHand,
) -> (PointerDevice<SteppedClock>, SteppedClock) {
    let clock = SteppedClock::new();
    let mut device = PointerDevice::new(params, hand, clock.clone()).unwrap();
    device.read().unwrap();
    (device, clock)
}

#[test]
fn a_command_acts_after_its_delay_and_within_the_motor_s_limit() {
    let params = PointerParams {
        largest_force: Some(0.5),
        delay: 2,
        ..PointerParams::default()
    };
    let (mut device, clock) = device(params, &PointerHand::free());
    let mut given = Vec::new();
    for force in [0.3, 4.0, -4.0, 0.0, 0.0] {
        clock.advance(MS);
        device.read().unwrap();
        given.push(device.write([force, 0.0, 0.0].into()).unwrap().force[0]);
    }
    assert_eq!(given, [0.0, 0.0, 0.3, 0.5, -0.5]);
    let slow = PointerParams {
        largest_force: Some(0.0),
        ..params
    };
    let refused = PointerDevice::new(slow, &PointerHand::free(), SteppedClock::new());
    assert_eq!(refused.unwrap_err().name, "largest_force");
}

/// A delay in seconds of a number of whole periods equals a delay of as many writes. A fraction of a period and a lag
/// delay the device by their own duration.
#[test]
fn a_delay_in_seconds_and_a_lag_delay_the_device_by_as_much() {
    let moved = |params: PointerParams| {
        let (mut device, clock) = device(params, &PointerHand::at(0.0));
        let mut positions = Vec::new();
        for tick in 0..40 {
            device.read().unwrap();
            positions.push(device.position());
            let force = if tick < 3 { 0.0 } else { 2.0 };
            device.write([force, 0.0, 0.0].into()).unwrap();
            clock.advance(MS);
        }
        (device.velocity(), positions)
    };
    let params = PointerParams::default();
    let writes = moved(PointerParams { delay: 2, ..params });
    let seconds = moved(PointerParams {
        delay_seconds: 2e-3,
        ..params
    });
    for (a, b) in writes.1.iter().zip(&seconds.1) {
        assert!((a - b).abs() < 1e-15, "{a} {b}");
    }
    let late = |delay_seconds, lag| {
        let actuator = ActuatorParams { gain: 0.5, lag };
        let params = PointerParams {
            delay_seconds,
            actuator,
            ..params
        };
        moved(params).1[39]
    };
    // A settled lag equals a delay, except for the hand's effect in the meantime.
    let (together, as_delay) = (late(0.7e-3, 0.5e-3), late(1.2e-3, 0.0));
    assert!(
        (together / as_delay - 1.0).abs() < 1e-3,
        "{together} {as_delay}"
    );
    assert!((late(0.7e-3, 0.0) / as_delay - 1.0).abs() > 5e-3);
    let never = PointerParams {
        delay_seconds: f64::NAN,
        ..params
    };
    let refused = PointerDevice::new(never, &PointerHand::free(), SteppedClock::new());
    assert_eq!(refused.unwrap_err().name, "delay_seconds");
}

/// m x″ = −k x − (b + b_h) x′ + f from rest: the textbook's step response.
#[test]
fn a_held_force_moves_it_as_the_closed_form_says() {
    let params = PointerParams::default();
    let (mut device, clock) = device(params, &PointerHand::at(0.0));
    device.write([2.0, 0.0, 0.0].into()).unwrap();
    let mass = params.device_mass + params.hand_mass;
    let decay = 0.5 * (params.hand_damping + params.viscous_friction) / mass;
    let swing = (params.hand_stiffness / mass - decay * decay).sqrt();
    for millisecond in 1..=300 {
        clock.advance(MS);
        let time = f64::from(millisecond) * 1e-3;
        let (sine, cosine) = (swing * time).sin_cos();
        let left = (-decay * time).exp() * (cosine + decay / swing * sine);
        let expected = 2.0 / params.hand_stiffness * (1.0 - left);
        let position = device.read().unwrap().position[0];
        assert!((position - expected).abs() < 1e-14, "{time} s: {position}");
    }
}

/// With a stiff hand of small mass, the device is at the hand's aim.
#[test]
fn the_hand_comes_to_its_target_by_a_critically_damped_step() {
    let params = PointerParams {
        device_mass: 1e-3,
        hand_mass: 0.0,
        viscous_friction: 0.0,
        hand_stiffness: 1e5,
        hand_damping: 10.0,
        ..PointerParams::default()
    };
    let hand = PointerHand::at(0.0);
    let (mut device, clock) = device(params, &hand);
    hand.move_to(0.05);
    device.read().unwrap();
    for millisecond in 1..=100 {
        clock.advance(MS);
        let turned = params.aim_rate * f64::from(millisecond) * 1e-3;
        let expected = 0.05 * (1.0 - (1.0 + turned) * (-turned).exp());
        let position = device.read().unwrap().position[0];
        assert!((position - expected).abs() < 1e-5, "{position}, {expected}");
    }
}

/// The position does not depend on whether the clock advances in one step or in a thousand.
#[test]
fn how_often_it_is_asked_changes_nothing() {
    let hand = PointerHand::at(0.0);
    let mut ends = [1_u32, 1000].map(|pieces| {
        hand.move_to(0.0);
        let (mut device, clock) = device(PointerParams::default(), &hand);
        hand.move_to(0.03);
        device.write([-1.5, 0.0, 0.0].into()).unwrap();
        for _ in 0..pieces {
            clock.advance(200 * MS / pieces);
            device.read().unwrap();
        }
        device.position()
    });
    ends.sort_by(f64::total_cmp);
    assert!(ends[1] - ends[0] < 1e-14, "{ends:?}");
    assert!(ends[0] > 0.02, "{ends:?}");
}

/// A mouse at 60 Hz: what reaches the device of its steps is a small part of them.
#[test]
fn the_steps_of_a_mouse_are_not_felt() {
    let hand = PointerHand::at(0.0);
    let (mut device, clock) = device(PointerParams::default(), &hand);
    let (speed, frame) = (0.3, 16_667);
    let mut off: f64 = 0.0;
    let mut fastest: f64 = 0.0;
    for microsecond in (0..800_000_u32).step_by(1000) {
        let frames = microsecond / frame;
        hand.move_to(speed * f64::from(frames * frame) * 1e-6);
        clock.advance(MS);
        device.read().unwrap();
        if microsecond > 400_000 {
            // Long after the start it moves along with the hand.
            off = off.max((device.velocity() - speed).abs());
            fastest = fastest.max(device.velocity());
        }
    }
    // 0.02 mm at 377 rad/s
    assert!(off < 0.03 * speed, "{off} m/s, {fastest} m/s");
    assert!(off > 0.0);
}

#[test]
fn a_device_that_nobody_holds_comes_to_rest_and_is_taken_hold_of_without_a_jolt() {
    let hand = PointerHand::at(0.1);
    let (mut device, clock) = device(PointerParams::default(), &hand);
    clock.advance(60 * MS);
    device.read().unwrap();
    let speed = device.velocity();
    assert!(speed > 0.3, "{speed}");
    hand.disable_output();
    device.read().unwrap();
    assert_eq!(device.velocity(), speed);
    clock.advance(1000 * MS);
    device.read().unwrap();
    assert_eq!(device.velocity(), 0.0);
    // The device carries an object that is lighter than its dry friction.
    let rests = device.position();
    device.write([-1.0, 0.0, 0.0].into()).unwrap();
    clock.advance(1000 * MS);
    device.read().unwrap();
    assert_eq!(device.position(), rests);
    device.write([0.0; 3].into()).unwrap();
    hand.move_to(0.0);
    device.read().unwrap();
    assert_eq!((device.position(), device.velocity()), (rests, 0.0));
    clock.advance(MS);
    device.read().unwrap();
    assert!(device.velocity().abs() < 0.05, "{}", device.velocity());
    clock.advance(2000 * MS);
    device.read().unwrap();
    assert!(device.position().abs() < 1e-9, "{}", device.position());
}

#[test]
fn two_devices_are_in_the_same_hand() {
    let hand = PointerHand::free();
    let (mut one, clock) = device(PointerParams::default(), &hand);
    let mut other = PointerDevice::new(PointerParams::default(), &hand, clock.clone()).unwrap();
    other.read().unwrap();
    for target in [0.02, f64::NAN, -0.01] {
        hand.move_to(target);
        clock.advance(30 * MS);
        assert_eq!(one.read().unwrap(), other.read().unwrap());
    }
    assert_eq!(hand.target(), Some(-0.01));
    assert!(one.position() != 0.0);
}

#[test]
fn what_is_no_hand_is_named() {
    let refused = |params| {
        let error = PointerDevice::new(params, &PointerHand::free(), SteppedClock::new());
        error.unwrap_err().to_string()
    };
    let usual = PointerParams::default();
    assert_eq!(
        refused(PointerParams {
            hand_stiffness: 0.0,
            ..usual
        }),
        "hand_stiffness = 0 is not allowed; allowed: finite and above 0 N/m"
    );
    let light = PointerParams {
        device_mass: 1e-9,
        hand_mass: 0.0,
        ..usual
    };
    assert!(refused(light).contains("no faster than 1e5 rad/s"));
    let nowhere = PointerParams {
        position: f64::NAN,
        ..usual
    };
    assert!(refused(nowhere).starts_with("position = NaN"));
}
