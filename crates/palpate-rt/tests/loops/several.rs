//! Several devices in one loop: each within its own limits, and no device has a force if one has none.

mod ends;

use std::sync::atomic::Ordering;
use std::time::Duration;

use palpate_device::clock::{Clock, SteppedClock};
use palpate_device::{DeviceErrorKind, ScriptedDevice, Step, Vector};
use palpate_record::recording::Flags;
use palpate_rt::safety::{SafetyParams, SafetyStop};
use palpate_rt::{
    BoundedWorld, ControlLoop, Listener, LoopEvent, Message, Note, RenderedWorld, SetupError,
    WorldFrame, tap,
};
use palpate_scene::world::{WorldFile, WorldScene};
use palpate_study::sim::device::SpatialDevice;
use palpate_world::Sample;

use crate::wide;
use crate::worlds::{length, scene};

type Several<D = ScriptedDevice<SteppedClock>> = ControlLoop<D, SteppedClock, RenderedWorld>;

/// A table of 1000 N/m under two points without friction: 1 N on each per millimetre below z = 0.
const TWO_POINTS: &str = r#"
format = 2
[loop]
period_s = 0.001
[[device]]
name = "left"
mass_kg = 0.2
tool = { sphere = { radius_m = 0.0 } }
[[device]]
name = "right"
mass_kg = 0.2
tool = { sphere = { radius_m = 0.0 } }
[[body]]
name = "table"
fixed = true
shape = { half_space = { normal = [0.0, 0.0, 1.0], offset_m = 0.0 } }
[[contact]]
between = ["left", "table"]
stiffness_n_per_m = 1000.0
[[contact]]
between = ["right", "table"]
stiffness_n_per_m = 1000.0
[render]
method = "basic"
"#;

fn rendered(scene: &WorldScene, method: &'static str) -> RenderedWorld {
    let renderer = scene.renderer(method).unwrap();
    let frames = vec![WorldFrame::the_same(); scene.devices.len()];
    RenderedWorld::of_devices(&scene.world, renderer, method, frames).unwrap()
}

fn two_points() -> RenderedWorld {
    let scene = WorldFile::parse("points.toml", TWO_POINTS).unwrap().scene;
    rendered(&scene, "basic")
}

/// Returns a step below the table by `millimetres`.
fn down(millimetres: f64) -> Step {
    Step::At([0.0, 0.0, -millimetres * 1e-3])
}

/// Creates two points on the table, on devices that follow `scripts`.
fn scripted(scripts: [Vec<Step>; 2], limits: [SafetyParams; 2]) -> (Several, SteppedClock) {
    let clock = SteppedClock::new();
    let devices = scripts.into_iter().zip(limits).map(|(script, limits)| {
        let device = ScriptedDevice::new(clock.clone(), 3, script);
        (device, limits)
    });
    let control = ControlLoop::of_devices(devices.collect(), clock.clone(), two_points()).unwrap();
    (control, clock)
}

/// Returns the last written force of each device along z [N].
fn written(control: &Several) -> [f64; 2] {
    let mut last = control.devices().map(|device| device.forces().last());
    [(); 2].map(|()| last.next().flatten().map_or(f64::NAN, |force| force[2]))
}

fn notes(listener: &mut Listener) -> Vec<LoopEvent> {
    let messages = listener.by_ref().filter_map(|messages| match messages {
        Message::Note(noted) => Some(noted),
        Message::Tick(..) => None,
    });
    messages.collect()
}

fn limits() -> SafetyParams {
    SafetyParams {
        workspace: Some([[-0.05; 3], [0.05; 3]]),
        largest_speed: 2.0,
        // Nothing is late by itself, because the clock is stepped manually.
        tolerated_lateness: 0.0,
        ..SafetyParams::default()
    }
}

/// Returns samples that touch the table gradually and then stay `depth` millimetres in it.
fn touching(depth: f64, samples: usize) -> Vec<Step> {
    let mut script = vec![down(-1.0), down(0.0)];
    script.resize(samples, down(depth));
    script
}

/// The pinch grasp of two fingers, by both ways to render a world of several devices.
#[test]
fn forces_and_ledger_match_a_bounded_world() {
    let pinch = scene("pinch.toml");
    for method in ["basic", "coupled"] {
        let limits = SafetyParams {
            largest_force: 1.2,
            slew_limit: 50.0,
            soft_start: 0.05,
            oscillation: wide().oscillation,
            ..SafetyParams::default()
        };
        let places = |tick: usize| {
            let into = 0.8e-3 * (1.0 - (0.03 * tick as f64).cos());
            let up = 1e-5 * tick as f64;
            [
                [-0.0202 + into, 0.0005, 0.016 + up],
                [0.0202 - 0.9 * into, -0.0003, 0.016 + up],
            ]
        };
        let ticks = 300;
        let clock = SteppedClock::new();
        let devices = (0..2).map(|device| {
            let script = (0..ticks).map(|tick| Step::At(places(tick)[device]));
            let device = ScriptedDevice::new(clock.clone(), 3, script.collect());
            (device, limits)
        });
        let world = rendered(&pinch, method);
        let mut control: Several =
            ControlLoop::of_devices(devices.collect(), clock.clone(), world).unwrap();
        let mut bounded = BoundedWorld::new(pinch.renderer(method).unwrap(), limits).unwrap();
        let mut most: f64 = 0.0;
        let mut limited = [0; 2];
        for tick in 0..ticks {
            let said = control.tick().tick;
            let positions = places(tick);
            let sample = Sample {
                elapsed: (tick > 0).then_some(1e-3),
                ..Sample::at(&positions)
            };
            let held = bounded.step(&sample);
            assert_eq!(held.fault, None);
            limited[0] += usize::from(held.bounded.force);
            limited[1] += usize::from(held.bounded.slew);
            let ticks = control.device_ticks().iter();
            let forces: Vec<Vector> = ticks.map(|device| device.commanded_force).collect();
            let expected: Vec<Vector> = held.wrenches.iter().map(|held| held.force).collect();
            assert_eq!(forces, expected, "{method}, tick {tick}");
            assert_eq!(said.commanded_force, forces[0]);
            most = most.max(length(forces[1]));
        }
        assert_eq!(
            control.rendered().state().ledger(),
            bounded.state().ledger()
        );
        assert_eq!(
            control.rendered().state().bodies(),
            bounded.state().bodies()
        );
        println!("{method}: up to {most:.2} N, {limited:?} ticks at the limits");
        assert!(limited.iter().all(|ticks| *ticks > 3), "{limited:?}");
        assert!(most > 0.5 && control.safety_stop().is_none(), "{most} N");
    }
}

#[test]
fn it_is_the_loop_of_the_simulator_with_two_hands() {
    let pinch = scene("pinch.toml");
    let bench = palpate_study::sim::world::WorldBench::new(&pinch).unwrap();
    let expected = bench
        .run("coupled", &pinch.renderer("coupled").unwrap())
        .unwrap();
    let clock = SteppedClock::new();
    let devices = (0..pinch.devices.len()).map(|number| {
        let device = SpatialDevice::new(&pinch, number, clock.clone()).unwrap();
        (device, wide())
    });
    let world = rendered(&pinch, "coupled");
    let mut control: Several<SpatialDevice<SteppedClock>> =
        ControlLoop::of_devices(devices.collect(), clock.clone(), world).unwrap();
    let mut worst: f64 = 0.0;
    for positions in expected.positions.iter().take(60) {
        control.tick();
        for (device, position) in control.devices().zip(positions) {
            let now = device.position();
            let off: Vector = std::array::from_fn(|axis| now[axis] - position[axis]);
            worst = worst.max(length(off));
        }
    }
    println!("at most {worst:.1e} m from the simulator's motion");
    assert!(worst < 1e-6, "{worst} m");
}

#[test]
fn each_device_has_its_own_limits() {
    let unbounded = SafetyParams {
        largest_force: 100.0,
        ..wide()
    };
    let weak = SafetyParams {
        largest_force: 1.5,
        ..unbounded
    };
    let slow = SafetyParams {
        slew_limit: 500.0,
        ..unbounded
    };
    for (limits, expected, limited) in [
        ([weak, unbounded], [1.5, 3.0], [true, false]),
        ([unbounded, weak], [3.0, 1.5], [false, true]),
        ([slow, weak], [0.5, 1.5], [true, true]),
    ] {
        let (mut control, _) = scripted([vec![down(3.0)], vec![down(3.0)]], limits);
        let tick = control.tick().tick;
        let said = control.device_ticks();
        for (device, (force, is_limited)) in said.iter().zip(expected.into_iter().zip(limited)) {
            assert!(
                (device.commanded_force[2] - force).abs() < 1e-12,
                "{said:?}"
            );
            assert_eq!(device.flags.has(Flags::SAFETY_LIMITED), is_limited);
        }
        assert!(tick.flags.has(Flags::SAFETY_LIMITED));
    }
    // The workspace of one device does not apply to the other.
    let boxed = SafetyParams {
        workspace: Some([[-1.0, -1.0, -1e-3], [1.0; 3]]),
        ..unbounded
    };
    let scripts = || [vec![down(2.0)], vec![down(2.0)]];
    for (limits, device) in [([boxed, unbounded], 0), ([unbounded, boxed], 1)] {
        let (mut control, _) = scripted(scripts(), limits);
        control.tick();
        let expected = Some((device, SafetyStop::OutsideWorkspace));
        assert_eq!(control.stopped_device(), expected);
        assert_eq!(written(&control), [0.0; 2]);
    }
}

/// The table of `docs/realtime.md`, for each of two devices; the other device has no fault.
#[test]
fn a_fault_of_one_device_takes_the_force_off_both_and_is_named() {
    use DeviceErrorKind::{Disconnected, NothingNew, Refused};
    let faults = [
        (Step::At([f64::NAN; 3]), 5, 1, SafetyStop::NotANumber),
        (Step::At([f64::INFINITY; 3]), 5, 1, SafetyStop::NotANumber),
        (Step::Stale, 5, 2, SafetyStop::StaleSample),
        (Step::Fails(NothingNew), 5, 2, SafetyStop::StaleSample),
        (Step::At([0.02, 0.0, -1e-3]), 5, 1, SafetyStop::TooFast),
        (
            Step::At([0.06, 0.0, -1e-3]),
            5,
            1,
            SafetyStop::OutsideWorkspace,
        ),
        (Step::Fails(Refused), 5, 1, SafetyStop::DeviceRefused),
        (Step::Fails(Disconnected), 1, 1, SafetyStop::DeviceLost),
        (
            Step::FailsForce(Refused, [0.0, 0.0, -1e-3]),
            5,
            1,
            SafetyStop::DeviceRefused,
        ),
    ];
    for at_fault in [0, 1] {
        for (fault, times, periods, safety_stop) in faults {
            let case = format!("device {at_fault}, {fault:?}");
            let mut script = touching(1.0, 20);
            script.extend(vec![fault; times]);
            script.push(down(1.0));
            let mut scripts = [vec![down(-1.0), down(0.0), down(1.0)], script];
            if at_fault == 0 {
                scripts.reverse();
            }
            let (control, _) = scripted(scripts, [limits(); 2]);
            let (tap, mut listener) = tap(10_000);
            let mut control = control.tapped(tap);
            for _ in 0..20 {
                control.tick();
            }
            assert_eq!(written(&control), [1.0; 2], "{case}");
            let mut until_none = 0;
            while written(&control) != [0.0; 2] {
                until_none += 1;
                control.tick();
                assert!(until_none <= periods, "{case}: {:?}", written(&control));
                let is_off = written(&control) == [0.0; 2];
                // Both lose their force in the same tick.
                assert!(is_off || written(&control) == [1.0; 2], "{case}");
            }
            assert_eq!(until_none, periods, "{case}");
            assert_eq!(
                control.stopped_device(),
                Some((at_fault, safety_stop)),
                "{case}"
            );
            let said = control.device_ticks();
            for (number, device) in said.iter().enumerate() {
                let has_stopped = device.flags.has(Flags::SAFETY_STOPPED);
                assert_eq!(has_stopped, number == at_fault, "{case}");
                assert_eq!(device.delivered_force, [0.0; 3], "{case}");
            }
            let messages = notes(&mut listener);
            let stopped: Vec<_> = messages
                .iter()
                .filter(|noted| matches!(noted.note, Note::Stopped(_)))
                .collect();
            assert_eq!(stopped.len(), 1, "{case}: {messages:?}");
            let number = u32::try_from(at_fault).unwrap();
            assert_eq!(stopped[0].device, Some(number), "{case}");
            let text = stopped[0].event_of(listener.device_names()).text;
            let name = ["left", "right"][at_fault];
            assert_eq!(
                text,
                format!("device `{name}`: {safety_stop}; the force of all devices is 0")
            );
            // The force returns gradually on both, or stays off on both until the safety is rearmed.
            let still_there = if safety_stop == SafetyStop::TooFast {
                0
            } else {
                times - 1
            };
            for _ in 0..still_there.saturating_sub(periods - 1) {
                control.tick();
                assert_eq!(written(&control), [0.0; 2], "{case}");
            }
            if !safety_stop.is_passing() {
                for _ in 0..300 {
                    control.tick();
                }
                assert_eq!(written(&control), [0.0; 2], "{case}");
                control.rearm().store(true, Ordering::Release);
            }
            let mut last = [0.0; 2];
            for _ in 0..300 {
                control.tick();
                let now = written(&control);
                let largest = 1.0 / 3.0 + 1e-9;
                for (now, last) in now.iter().zip(last) {
                    assert!(now - last < largest, "{case}: {last} N, then {now} N");
                }
                last = now;
            }
            assert_eq!((last, control.safety_stop()), ([1.0; 2], None), "{case}");
        }
    }
}

/// The two devices have samples alternately, never both at once: after two periods no force is held.
#[test]
fn devices_whose_samples_are_missing_by_turns_hold_no_force() {
    let by_turns = |first: bool| {
        let mut script = touching(1.0, 20);
        for tick in 0..50 {
            let is_there = (tick % 2 == 0) == first;
            script.push(if is_there { down(1.0) } else { Step::Stale });
        }
        script
    };
    let (mut control, _) = scripted([by_turns(true), by_turns(false)], [limits(); 2]);
    for _ in 0..21 {
        control.tick();
    }
    assert_eq!(written(&control), [1.0; 2]);
    for _ in 0..40 {
        control.tick();
        assert_eq!(written(&control), [0.0; 2]);
    }
    assert!(matches!(
        control.stopped_device(),
        Some((_, SafetyStop::StaleSample))
    ));
}

/// A single missing sample has no effect, and the renderer gets the elapsed time.
#[test]
fn one_missing_sample_of_one_device_is_bridged() {
    for at_fault in [0, 1] {
        let mut script = touching(1.0, 20);
        script.extend([Step::Stale, down(1.0)]);
        let mut scripts = [vec![down(-1.0), down(0.0), down(1.0)], script];
        scripts.swap(1, usize::from(at_fault == 1));
        let (mut control, _) = scripted(scripts, [limits(); 2]);
        for _ in 0..21 {
            control.tick();
        }
        assert_eq!(written(&control), [1.0; 2]);
        let tick = control.tick().tick;
        assert!((tick.period - 2e-3).abs() < 1e-12, "{} s", tick.period);
        assert_eq!(written(&control), [1.0; 2]);
        assert_eq!(control.safety_stop(), None);
    }
}

#[test]
fn the_supervisor_and_each_watchdog_cut_all() {
    let (mut control, clock) = scripted([touching(1.0, 20), touching(1.0, 20)], [limits(); 2]);
    let zeroed: Vec<_> = control.devices().map(|d| d.times_zeroed()).collect();
    let watchdogs: Vec<_> = control.devices().map(|d| d.watchdog()).collect();
    let mut supervisor = control.supervisor().unwrap();
    for _ in 0..20 {
        control.tick();
        assert!(!supervisor.look(clock.now()));
    }
    clock.advance(Duration::from_millis(2));
    assert!(supervisor.look(clock.now()));
    let counts = zeroed.iter().map(|count| count.load(Ordering::SeqCst));
    assert_eq!(counts.collect::<Vec<_>>(), [1, 1]);
    control.tick();
    assert_eq!(written(&control), [0.0; 2]);
    assert_eq!(control.safety_stop(), Some(SafetyStop::Stalled));
    for _ in 0..300 {
        control.tick();
    }
    assert_eq!((written(&control), control.safety_stop()), ([1.0; 2], None));
    // The watchdog of one device removed its force during the stall.
    for watchdog in watchdogs {
        clock.oversleep_once(Duration::from_millis(5));
        watchdog.store(true, Ordering::SeqCst);
        control.tick();
        assert_eq!(written(&control), [0.0; 2]);
        assert_eq!(control.safety_stop(), Some(SafetyStop::Stalled));
        for _ in 0..300 {
            control.tick();
        }
        assert_eq!((written(&control), control.safety_stop()), ([1.0; 2], None));
    }
}

/// Two fingers on a light and stiff cube, with the spring force of the sample: it buzzes.
#[test]
fn generated_energy_of_the_world_stops_all_devices_with_one_event() {
    let mut pinch = scene("pinch.toml");
    pinch.timing.period = 0.004;
    for contact in &mut pinch.world.contacts {
        contact.law.stiffness *= 4.0;
    }
    let clock = SteppedClock::new();
    let devices = (0..pinch.devices.len()).map(|number| {
        let device = SpatialDevice::new(&pinch, number, clock.clone()).unwrap();
        (device, SafetyParams::default())
    });
    let world = rendered(&pinch, "basic");
    let (tap, mut listener) = tap(10_000);
    let control: Several<SpatialDevice<SteppedClock>> =
        ControlLoop::of_devices(devices.collect(), clock.clone(), world).unwrap();
    let mut control = control.tapped(tap);
    for _ in 0..1000 {
        control.tick();
        if control.safety_stop() == Some(SafetyStop::Oscillation) {
            break;
        }
    }
    assert_eq!(control.safety_stop(), Some(SafetyStop::Oscillation));
    let said = control.device_ticks().iter();
    assert!(
        said.clone()
            .all(|device| device.delivered_force == [0.0; 3])
    );
    let messages = notes(&mut listener);
    let oscillated: Vec<_> = messages
        .iter()
        .filter(|noted| matches!(noted.note, Note::Oscillated { .. }))
        .collect();
    assert_eq!(oscillated.len(), 1, "{messages:?}");
    // The event concerns the world and no device.
    assert_eq!(oscillated[0].device, None);
}

#[test]
fn a_loop_has_a_device_for_each_tool() {
    let clock = SteppedClock::new();
    let device = || ScriptedDevice::new(clock.clone(), 3, vec![down(0.0)]);
    for given in [0, 1, 3] {
        let devices = (0..given).map(|_| (device(), limits())).collect();
        let refused = ControlLoop::of_devices(devices, clock.clone(), two_points());
        assert_eq!(refused.err(), Some(SetupError::Devices { world: 2, given }));
    }
    let refused = ControlLoop::of_world(device(), clock.clone(), two_points(), limits());
    let error = refused.err().unwrap().to_string();
    assert_eq!(
        error,
        "the world has 2 devices, but 1 are given; allowed: one for each"
    );
}

/// A recording contains each device; that of a loop with one device has no such data.
#[test]
fn a_listener_hears_of_each_device() {
    let (control, _) = scripted([touching(1.0, 20), touching(2.0, 20)], [wide(); 2]);
    let (tap, mut listener) = tap(1000);
    let mut control = control.tapped(tap);
    for _ in 0..20 {
        control.tick();
    }
    let Some(Message::Tick(tick, _, _, devices)) = listener.by_ref().last() else {
        panic!("the last thing told is a tick");
    };
    assert_eq!(tick.sequence, 19);
    let said: Vec<_> = devices
        .iter()
        .map(|device| {
            (
                device.sequence,
                device.device,
                device.devices,
                device.axes[2],
            )
        })
        .collect();
    assert_eq!(said, [(19, 0, 2, -1e-3), (19, 1, 2, -2e-3)]);
    assert_eq!(devices[1].delivered_force, [0.0, 0.0, 2.0]);
    assert_eq!(listener.device_names(), ["left", "right"]);
}
