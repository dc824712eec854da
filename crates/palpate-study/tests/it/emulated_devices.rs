//! Calibration of the emulated devices in simulated time recovers the emulated values.
#![cfg(unix)]
#![allow(missing_docs, clippy::cast_possible_truncation)]

use std::sync::Arc;
use std::time::Duration;

use palpate_core::AlongAxis;
use palpate_device::Device;
use palpate_device::clock::SteppedClock;
use palpate_drivers::emulator::inverse3::{Body, Latency, SteppedInverse3};
use palpate_drivers::emulator::port::Usb;
use palpate_drivers::emulator::two_diy::{Hand, Settings, SteppedTwoDiy};
use palpate_drivers::inverse3::Pace;
use palpate_drivers::two_diy::{Board, Generation};
use palpate_rt::StopFlag;
use palpate_rt::safety::{Heartbeat, SafetyParams};
use palpate_study::calibrate::{Calibration, ExcitationParams, Quantity, measure};
use palpate_study::device_loop::{ShakeDeclined, ShakeError, Shaker};
use palpate_testbed::actuator::ActuatorParams;

const PUT_IN: ActuatorParams = ActuatorParams {
    gain: 0.9,
    lag: 0.2e-3,
};

/// Calibrates `device` along `normal`: from its current position, or from its rest position after `wait`.
fn calibrated(
    device: impl Device + 'static,
    clock: &SteppedClock,
    normal: [f64; 3],
    params: ExcitationParams,
    wait: Option<Duration>,
) -> Result<Calibration, ShakeError> {
    let axis = AlongAxis::new([0.0; 3], normal).unwrap();
    let period = Duration::from_secs_f64(params.period);
    let limit = SafetyParams::default().stall_after(period);
    let heartbeat = Arc::new(Heartbeat::default());
    let opened: (Box<dyn Device>, _) = (Box::new(device), axis);
    let timed = (clock.clone(), period);
    let shaker = Shaker::new(opened, timed, params, heartbeat, limit)?.waiting(wait);
    let motion = shaker.run(&StopFlag::new())?;
    let (positions, forces) = (&motion.positions, &motion.forces);
    let measured = measure(&params, motion.excited(), positions, forces);
    Ok(measured.unwrap().fitted.calibration)
}

/// Fails if the calibration deviates from the emulated values by more than three standard deviations, or by more than
/// `worst` `[s]` or `worst_mass` of the mass.
#[allow(clippy::print_stdout)] // what was measured
fn check(found: &Calibration, (delay, worst): (f64, f64), (mass, worst_mass): (f64, f64)) {
    for (quantity, put_in, worst) in [
        (Quantity::DelayPlusLag, delay, worst),
        (Quantity::DeviceMass, mass, worst_mass * mass),
    ] {
        let value = found.value(quantity).unwrap();
        let deviation = found.standard_deviation(quantity).unwrap();
        let error = (value - put_in).abs();
        println!("{quantity:?}: {put_in:.6} put in, {value:.6} +- {deviation:.6} found");
        assert!(error <= worst, "{quantity:?}: {value} is not {put_in}");
        assert!(
            quantity != Quantity::DelayPlusLag || error <= 3.0 * deviation,
            "{value} +- {deviation} is not {put_in}"
        );
    }
}

/// A third-generation board in the middle of its workspace, in a relaxed hand.
fn in_a_hand(board: Board, usb: Usb) -> Settings {
    let settings = Settings {
        angles: Some([130.0, 50.0]),
        usb,
        amplifier: PUT_IN,
        ..Settings::new(Generation::Three, board)
    };
    let place = SteppedTwoDiy::new(&settings, SteppedClock::new())
        .unwrap()
        .position();
    Settings {
        hand: Hand::at(place),
        ..settings
    }
}

#[test]
fn an_emulated_2diy_is_found_as_it_was_made() {
    let us = Duration::from_micros;
    let latency = Usb {
        frame: Duration::ZERO,
        latency: us(150),
    };
    let frames = Usb {
        frame: us(1000),
        latency: us(100),
    };
    let free = Settings {
        hand: Hand::None,
        ..in_a_hand(Board::M0, latency)
    };
    // A sample travels to the host and its force to the board: two latencies, or two frames.
    let both: &[[f64; 2]] = &[[0.0, 1.0], [1.0, 0.0]];
    for (settings, period, delay, worst, axes) in [
        (in_a_hand(Board::M3, latency), 1e-3, 0.3e-3, 0.08e-3, both),
        (free, 1e-3, 0.3e-3, 0.06e-3, &both[..1]),
        (
            in_a_hand(Board::M3, frames),
            4e-3,
            2e-3,
            0.12e-3,
            &both[1..],
        ),
    ] {
        for &axis in axes {
            let clock = SteppedClock::new();
            let device = SteppedTwoDiy::new(&settings, clock.clone()).unwrap();
            let mass = device.effective_mass(axis) / PUT_IN.gain;
            let params = ExcitationParams::new(period);
            let normal = [axis[0], axis[1], 0.0];
            let found = calibrated(device, &clock, normal, params, None).unwrap();
            check(&found, (delay + PUT_IN.lag, worst), (mass, 0.025));
        }
    }
}

#[test]
fn an_emulated_inverse3_is_found_as_it_was_made() {
    let us = Duration::from_micros;
    for (period, latency, jitter) in [(1e-3, 300, 0), (1e-3, 300, 200), (4e-3, 300, 200)] {
        let clock = SteppedClock::new();
        let body = Body {
            amplifier: PUT_IN,
            ..Body::default()
        };
        let latency = Latency {
            least: us(latency),
            jitter: us(jitter),
        };
        let every = Pace::default().exchange_every;
        let device = SteppedInverse3::new(&body, latency, every, clock.clone()).unwrap();
        let delays = device.delays();
        let params = ExcitationParams::new(period);
        let found = calibrated(device, &clock, [1.0, 0.0, 0.0], params, None).unwrap();
        let delay = delays.mean().unwrap().as_secs_f64();
        check(
            &found,
            (delay + PUT_IN.lag, 0.05e-3),
            (body.mass / PUT_IN.gain, 0.01),
        );
    }
}

/// A 2DIY is opened in its start pose, and the hand moves it from there to the calibration position.
#[test]
fn a_device_is_calibrated_where_the_hand_brings_it() {
    let place = [0.019, 0.08];
    let settings = Settings {
        hand: Hand::at(place),
        hand_waits: true,
        ..Settings::new(Generation::Three, Board::M0)
    };
    let run = |wait| {
        let clock = SteppedClock::new();
        let device = SteppedTwoDiy::new(&settings, clock.clone()).unwrap();
        calibrated(
            device,
            &clock,
            [0.0, 1.0, 0.0],
            ExcitationParams::new(1e-3),
            wait,
        )
    };
    let Err(ShakeError::Declined(why)) = run(None) else {
        panic!("calibrated on the way");
    };
    let why = why.to_string();
    assert!(why.contains("from where it started"), "{why}");
    let there = Settings {
        angles: Some([148.62, 31.38]),
        ..settings.clone()
    };
    let there = SteppedTwoDiy::new(&there, SteppedClock::new()).unwrap();
    assert!((there.position()[1] - place[1]).abs() < 1e-5);
    let found = run(Some(Duration::ZERO)).unwrap();
    check(
        &found,
        (0.0, 0.08e-3),
        (there.effective_mass([0.0, 1.0]), 0.04),
    );
}

#[test]
fn a_device_that_is_never_still_is_not_calibrated() {
    let settings = Settings {
        hand: Hand::at([0.019, 0.08]).swaying([0.0, 0.01], 0.7),
        ..Settings::new(Generation::Three, Board::M0)
    };
    let clock = SteppedClock::new();
    let device = SteppedTwoDiy::new(&settings, clock.clone()).unwrap();
    let params = ExcitationParams::new(1e-3);
    let wait = Some(Duration::from_secs(1));
    match calibrated(device, &clock, [0.0, 1.0, 0.0], params, wait) {
        Err(ShakeError::Declined(ShakeDeclined::NeverStill { .. })) => {}
        other => panic!("{other:?}"),
    }
}
