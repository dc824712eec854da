//! A device with a flexible transmission, backlash and cogging: by its laws, and against devices that are
//! known in closed form.
#![allow(clippy::print_stdout)] // what was measured

use std::f64::consts::TAU;

use palpate_testbed::device::{DevicePlant, PointMass};
use palpate_testbed::drivetrain::{Cogging, Drivetrain, DrivetrainParams, Transmission};
use palpate_testbed::hand::{Hand, Intention, Sinusoid};
use palpate_testbed::held_mass::HeldMass;

fn rigid(mass: f64) -> DrivetrainParams {
    DrivetrainParams {
        mass,
        viscous_friction: 0.0,
        coulomb_friction: 0.0,
        transmission: None,
        cogging: None,
    }
}

fn flexible(mass: f64, resonance_hz: f64) -> DrivetrainParams {
    DrivetrainParams {
        transmission: Some(Transmission {
            resonance_hz,
            damping_ratio: 0.0,
            motor_share: 0.6,
            backlash: 0.0,
        }),
        ..rigid(mass)
    }
}

fn hand() -> Hand {
    Hand::Impedance {
        mass: 0.07,
        stiffness: 250.0,
        damping: 3.0,
        intention: Intention::constant(0.002),
        force: 0.8,
        tremor: Some(Sinusoid {
            amplitude: 0.3,
            frequency_hz: 8.0,
            phase: 0.4,
        }),
    }
}

#[test]
fn one_body_moves_as_the_exact_mass_does() {
    for (viscous, dry) in [(0.0, 0.0), (2.0, 0.0), (0.5, 0.1)] {
        let mut exact = HeldMass::new(0.15, hand())
            .and_then(|device| device.with_friction(viscous, dry))
            .unwrap();
        let params = DrivetrainParams {
            viscous_friction: viscous,
            coulomb_friction: dry,
            ..rigid(0.15)
        };
        let mut device = Drivetrain::new(params, hand()).unwrap();
        let mut largest: f64 = 0.0;
        for i in 0..300_i32 {
            let force = if i % 40 < 10 { 6.0 } else { -1.0 };
            exact.advance(force, 1e-3);
            device.advance(force, 1e-3);
            largest = largest.max((exact.position() - device.position()).abs());
        }
        println!("B {viscous}, F_c {dry}: {largest:.1e} m apart at most");
        assert!(largest < if dry > 0.0 { 1e-6 } else { 1e-9 });
    }
}

#[test]
fn a_stiff_transmission_is_a_point_mass() {
    let mut point = PointMass::new(0.2, 0.5).unwrap();
    let mut device = Drivetrain::new(flexible(0.2, 3000.0), Hand::pushing(0.5)).unwrap();
    for i in 0..100_i32 {
        let force = if i < 50 { 2.0 } else { -1.0 };
        point.advance(force, 1e-3);
        device.advance(force, 1e-3);
    }
    let apart = (point.position() - device.position()).abs();
    println!("{apart:.1e} m apart after 0.1 s");
    // Its own stretch is f m₂/(m k_t) = 3e-8 m per newton.
    assert!(apart < 1e-6);
}

/// The two sides against each other are an oscillator of the stated frequency and damping.
#[test]
fn the_free_device_rings_at_its_resonance_and_decays_by_its_damping() {
    for (hz, ratio) in [(50.0, 0.0), (150.0, 0.03), (300.0, 0.1)] {
        let mut params = flexible(0.3, hz);
        params.transmission = params.transmission.map(|transmission| Transmission {
            damping_ratio: ratio,
            ..transmission
        });
        let mut device = Drivetrain::new(params, Hand::pushing(0.0)).unwrap();
        // A blow on the motor.
        device.advance(-50.0, 1e-4);
        let stretch = |device: &Drivetrain| device.end_point().0 - device.position();
        let (mut crossings, mut peaks) = (Vec::new(), Vec::new());
        let (mut before, mut speed_before) = (stretch(&device), 0.0);
        let step = 1e-5;
        for i in 1..40_000_u32 {
            device.advance(0.0, step);
            let now = stretch(&device);
            if before < 0.0 && now >= 0.0 {
                crossings.push((f64::from(i) - now / (now - before)) * step);
            }
            let speed = now - before;
            if speed_before < 0.0 && speed >= 0.0 {
                peaks.push(-before);
            }
            (before, speed_before) = (now, speed);
            if crossings.len() == 8 {
                break;
            }
        }
        let damped = hz * (1.0 - ratio * ratio).sqrt();
        let found = 7.0 / (crossings[7] - crossings[0]);
        let decrement = (peaks[1] / peaks[5]).ln() / 4.0;
        let expected = TAU * ratio / (1.0 - ratio * ratio).sqrt();
        println!("{hz} Hz: {found} Hz; decrement {decrement} for {expected}");
        assert!((found / damped - 1.0).abs() < 1e-4);
        assert!((decrement - expected).abs() < 2e-3);
    }
}

#[test]
fn what_leaves_the_store_went_through_the_port_and_friction_only_takes() {
    let lossless = DrivetrainParams {
        cogging: Some(Cogging {
            amplitude: 0.4,
            pitch: 0.004,
        }),
        ..flexible(0.2, 120.0)
    };
    let spring = Hand::Impedance {
        mass: 0.05,
        stiffness: 200.0,
        damping: 0.0,
        intention: Intention::constant(0.0),
        force: 0.5,
        tremor: None,
    };
    for backlash in [0.0, 1e-4] {
        let mut params = lossless;
        params.transmission = params.transmission.map(|transmission| Transmission {
            backlash,
            ..transmission
        });
        let mut device = Drivetrain::new(params, spring.clone()).unwrap();
        let (start, mut work, mut largest, mut most) =
            (device.stored_energy(), 0.0, 0.0_f64, 0.0_f64);
        for i in 0..500_i32 {
            work += device.advance(if i % 30 < 15 { 3.0 } else { -3.0 }, 1e-3);
            let stored = device.stored_energy() - start;
            most = most.max(stored.abs());
            largest = largest.max((stored + work).abs());
        }
        println!("backlash {backlash} m: {largest:.1e} J of up to {most:.1e} J");
        assert!(most > 1e-3 && largest < 2e-4 * most);
    }
    let rubbing = DrivetrainParams {
        viscous_friction: 0.3,
        coulomb_friction: 0.1,
        ..lossless
    };
    let mut device = Drivetrain::new(rubbing, spring).unwrap();
    let mut balance = device.stored_energy();
    for i in 0..500_i32 {
        let given = device.advance(if i % 30 < 15 { 3.0 } else { -3.0 }, 1e-3);
        let left = device.stored_energy() + given;
        assert!(left <= balance + 1e-6, "{left} after {balance}");
        balance = device.stored_energy();
    }
}

#[test]
fn within_the_backlash_the_motor_moves_alone() {
    let mut params = flexible(0.2, 150.0);
    params.transmission = params.transmission.map(|transmission| Transmission {
        backlash: 1e-3,
        ..transmission
    });
    let mut device = Drivetrain::new(params, Hand::pushing(0.0)).unwrap();
    // 0.12 kg alone cross half of the backlash under 2 N in 7.7 ms.
    let mut alone = PointMass::new(0.12, 0.0).unwrap();
    for _ in 0..7 {
        device.advance(-2.0, 1e-3);
        alone.advance(-2.0, 1e-3);
    }
    assert!((device.position() - alone.position()).abs() < 1e-12);
    assert_eq!(device.end_point(), (0.0, 0.0));
    device.advance(-2.0, 5e-3);
    assert!(device.end_point().0 > 0.0);
}

#[test]
fn friction_and_cogging_hold_a_motor_up_to_their_level_and_not_beyond() {
    let params = DrivetrainParams {
        coulomb_friction: 0.3,
        ..rigid(0.1)
    };
    let moved = |params: DrivetrainParams, force: f64| {
        let mut device = Drivetrain::new(params, Hand::pushing(0.0)).unwrap();
        // Slowly, so that it is not the blow that moves it.
        for i in 0..2000_i32 {
            device.advance(-force * f64::from(i.min(1000)) * 1e-3, 1e-3);
        }
        device.position()
    };
    assert!(moved(params, 0.29).abs() < 1e-9);
    assert!(moved(params, 0.33) > 1e-3);
    // From the stable place at half a pitch, a force below the amplitude moves it by less than a quarter.
    let cogs = DrivetrainParams {
        viscous_friction: 2.0,
        cogging: Some(Cogging {
            amplitude: 0.3,
            pitch: 0.004,
        }),
        ..rigid(0.1)
    };
    let from_rest = |force: f64| {
        let mut device = Drivetrain::new(cogs, Hand::pushing(0.0))
            .and_then(|device| device.starting_at(0.002, 0.0))
            .unwrap();
        for i in 0..2000_i32 {
            device.advance(-force * f64::from(i.min(1000)) * 1e-3, 1e-3);
        }
        device.position() - 0.002
    };
    let held = from_rest(0.15);
    println!("cogging holds 0.15 N at {held} m");
    // sin(2π x/pitch) = 1/2 at a twelfth of the pitch.
    assert!((held - 0.004 / 12.0).abs() < 1e-6);
    assert!(from_rest(0.33) > 0.004);
}

#[test]
fn released_device_moves_as_without_hand() {
    let release = 0.0123;
    let cogging = DrivetrainParams {
        cogging: Some(Cogging {
            amplitude: 0.2,
            pitch: 0.004,
        }),
        ..rigid(0.15)
    };
    for params in [flexible(0.15, 120.0), cogging] {
        let mut whole = Drivetrain::new(params, hand())
            .and_then(|device| device.released_at(release))
            .unwrap();
        let mut first = Drivetrain::new(params, hand()).unwrap();
        let mut worked = 0.0;
        // The release lies within a step.
        for _ in 0..40 {
            worked += whole.advance(0.1, 0.001);
        }
        let held = first.advance(0.1, release);
        assert!(first.velocity().abs() > 1e-3, "it moves when it is let go");
        let (end, end_velocity) = first.end_point();
        // Without the hand, from where that ended: the energy that is stored falls by what goes through the port.
        let mass_of_end = if params.transmission.is_some() {
            0.4
        } else {
            0.0
        } * params.mass;
        let kinetic = 0.5 * (params.mass - mass_of_end) * first.velocity().powi(2)
            + 0.5 * mass_of_end * end_velocity.powi(2);
        let spring = params.transmission.map_or(0.0, |transmission| {
            let (stiffness, _) = transmission.stiffness_and_damping(params.mass);
            0.5 * stiffness * (end - first.position()).powi(2)
        });
        let cogs = params.cogging.map_or(0.0, |cogging| {
            let rate = TAU / cogging.pitch;
            cogging.amplitude / rate * (rate * first.position()).cos()
        });
        let left = whole.stored_energy() - (kinetic + spring + cogs) + (worked - held);
        let turned_over = kinetic + spring + cogs.abs();
        println!("{left:.1e} J of {turned_over:.1e} J");
        assert!(
            left.abs() < 2e-4 * turned_over,
            "{left:e} of {turned_over:e}"
        );
    }
    for bad in [-1.0, f64::NAN, f64::INFINITY] {
        let device = Drivetrain::new(rigid(0.1), hand()).unwrap();
        assert_eq!(device.released_at(bad).unwrap_err().name, "release");
    }
}

#[test]
fn released_rigid_drivetrain_moves_like_the_exact_mass() {
    let mut exact = HeldMass::new(0.15, hand())
        .and_then(|device| device.released_at(0.0517))
        .unwrap();
    let mut device = Drivetrain::new(rigid(0.15), hand())
        .and_then(|device| device.released_at(0.0517))
        .unwrap();
    for i in 0..150_i32 {
        let force = if i % 40 < 10 { 6.0 } else { -1.0 };
        exact.advance(force, 1e-3);
        device.advance(force, 1e-3);
        let apart = (exact.position() - device.position()).abs();
        assert!(apart < 1e-8, "{apart:e} m apart after {i} ms");
    }
}

#[test]
fn a_rejected_parameter_is_named() {
    let refused = |params: DrivetrainParams| {
        Drivetrain::new(params, Hand::pushing(0.0))
            .unwrap_err()
            .name
    };
    let with = |change: fn(&mut Transmission)| {
        let mut params = flexible(0.2, 100.0);
        let mut transmission = params.transmission.unwrap();
        change(&mut transmission);
        params.transmission = Some(transmission);
        refused(params)
    };
    assert_eq!(refused(rigid(0.0)), "mass");
    assert_eq!(with(|t| t.resonance_hz = 5001.0), "resonance_hz");
    assert_eq!(with(|t| t.damping_ratio = 1.1), "damping_ratio");
    assert_eq!(with(|t| t.motor_share = 1.0), "motor_share");
    assert_eq!(with(|t| t.backlash = -1e-6), "backlash");
    let cogging = Some(Cogging {
        amplitude: 0.1,
        pitch: 0.0,
    });
    assert_eq!(
        refused(DrivetrainParams {
            cogging,
            ..rigid(0.1)
        }),
        "cogging.pitch"
    );
}
