//! Agreement of the loop on a virtual device with the simulator.

use std::time::Duration;

use palpate_device::Device;
use palpate_device::clock::SteppedClock;
use palpate_rt::safety::SafetyParams;
use palpate_scene::method::MethodName;
use palpate_scene::{ActuatorParams, Delay};
use palpate_study::sim::closed_loop::Bench;
use palpate_study::sim::device::SimulatedDevice;

use crate::{scene, simulated, wide};

/// A clock of whole nanoseconds divides 0.02 s into the same periods as a floating-point number, up to rounding:
/// loops that are not chaotic agree.
#[test]
fn it_is_the_loop_of_the_simulator() {
    for name in [
        "fig2.toml",
        "experiment1.toml",
        "experiment2.toml",
        "experiment1_in_a_hand.toml",
        "coupled/wall-1000.toml",
        "users/s03-heavy-cup.toml",
    ] {
        let scene = scene(name);
        let bench = Bench::new(&scene).unwrap();
        for method in MethodName::ALL {
            let expected = bench.run(method).unwrap();
            if expected.diverged == Some(true) {
                continue;
            }
            let (mut control, _) = simulated(&scene, method, wide());
            let scale = expected.ticks.iter().fold(1e-3, |most: f64, tick| {
                most.max(tick.output.force_on_object.abs())
            });
            for expected in &expected.ticks {
                let tick = control.tick();
                let off = tick.contact.force_on_object - expected.output.force_on_object;
                assert!(
                    off.abs() < 1e-6 * scale,
                    "{name}, {method}, {} s: {} N, simulated {} N",
                    expected.time,
                    tick.contact.force_on_object,
                    expected.output.force_on_object
                );
                assert_eq!(
                    tick.contact.force_on_device, -tick.contact.force_on_object,
                    "{name}, {method}"
                );
            }
        }
    }
}

#[test]
fn a_device_with_a_delay_holds_its_forces_later() {
    let mut delayed = scene("experiment1.toml");
    delayed.delay = Delay::samples(2);
    let bench = Bench::new(&delayed).unwrap();
    let expected = bench.run(MethodName::Coupled).unwrap();
    let (mut control, _) = simulated(&delayed, MethodName::Coupled, wide());
    let mut held = Vec::new();
    for expected in &expected.ticks {
        let tick = control.tick();
        held.push(tick.contact.force_on_device);
        let off = tick.contact.force_on_object - expected.output.force_on_object;
        assert!(off.abs() < 1e-6, "{} s: {off} N", expected.time);
        assert_eq!(
            tick.contact.force_on_device,
            -expected.held_force_on_object + 0.0
        );
    }
    assert!(held.iter().any(|force| *force != 0.0));
}

/// With a modelled fraction of a period, lag or gain the renderer's ledger contains the sent force when it acts, in
/// the loop and in the simulator. The limits of both the motor and the safety apply.
#[test]
fn loop_with_modelled_actuation_matches_simulator_under_force_limits() {
    let period = scene("experiment1.toml").loop_params.period;
    for (delay, lag, gain) in [
        (Delay::Seconds(0.5 * period), 0.0, 1.0),
        (Delay::Seconds(1.25 * period), 0.2 * period, 0.9),
        (Delay::NONE, 0.3 * period, 1.0),
        (Delay::NONE, 0.0, 0.8),
        (Delay::samples(2), 0.1 * period, 1.1),
    ] {
        let mut late = scene("experiment1.toml");
        late.delay = delay;
        late.actuator = ActuatorParams { gain, lag };
        for limit in [f64::INFINITY, 1.0] {
            let mut weak = late.clone();
            weak.device.point_mass_mut().unwrap().largest_force =
                Some(limit).filter(|limit| limit.is_finite());
            let bench = Bench::new(&weak).unwrap();
            let expected = bench.run(MethodName::Coupled).unwrap();
            assert!(
                expected.diverged == Some(false),
                "{delay:?} {lag} {gain} {limit}"
            );
            let by_motor = simulated(&weak, MethodName::Coupled, wide());
            // The motor clips the command, and the safety also the command times the gain.
            let safe = SafetyParams {
                largest_force: (limit * gain.max(1.0)).min(1e6),
                ..wide()
            };
            let by_safety = simulated(&late, MethodName::Coupled, safe);
            for (kind, (mut control, _)) in [("motor", by_motor), ("safety", by_safety)] {
                let (mut most, mut largest) = (0.0_f64, 0.0_f64);
                for expected in &expected.ticks {
                    let tick = control.tick();
                    let off = tick.contact.force_on_object - expected.output.force_on_object;
                    most = most.max(off.abs());
                    largest = largest.max(tick.contact.force_on_object.abs());
                }
                println!(
                    "{delay:?}, lag {lag} s, gain {gain}, {kind} {limit} N: {most:.1e} N \
                     of {largest:.2} N"
                );
                assert!(most < 1e-5 * largest, "{most}");
                assert!(limit > largest || largest > 1.2, "{largest}");
            }
        }
    }
}

/// A cut takes effect at its own instant, not when the loop detects it.
#[test]
fn a_simulated_device_that_is_cut_holds_no_force_from_then_on() {
    let scene = scene("wall.toml");
    let clock = SteppedClock::new();
    let mut devices = [0, 1].map(|_| SimulatedDevice::new(&scene, clock.clone()).unwrap());
    let mut zero = devices[0].zero_writer().unwrap();
    for device in &mut devices {
        device.read().unwrap();
        device.write([-3.0, 0.0, 0.0].into()).unwrap();
    }
    clock.advance(Duration::from_millis(3));
    zero.write_zero();
    devices[1].write([0.0; 3].into()).unwrap();
    clock.advance(Duration::from_millis(5));
    // The force is already cut; a second cut changes nothing.
    zero.write_zero();
    clock.advance(Duration::from_millis(2));
    let positions = devices.each_mut().map(|device| {
        let reading = device.read().unwrap();
        assert_eq!(reading.time, Duration::from_millis(10));
        reading.position
    });
    assert_eq!(positions[0], positions[1]);
}
