//! Two devices in one loop: a pinch in two hands, the faults of each, and two hostile devices.

use std::hint::black_box;
use std::sync::atomic::Ordering;
use std::time::Duration;

use palpate_device::clock::SteppedClock;
use palpate_device::{Device, DeviceErrorKind, ScriptedDevice, Step, Wrench};
use palpate_rt::safety::{SafetyParams, SafetyStop};
use palpate_rt::{ControlLoop, Message, RenderedWorld, WorldFrame, tap};
use palpate_scene::world::WorldScene;
use palpate_study::sim::device::SpatialDevice;

use crate::hostile::Hostile;
use crate::in_worlds::world_scene;
use crate::situations::Watch;

type Two<D> = ControlLoop<D, SteppedClock, RenderedWorld>;

fn two<D: Device>(
    scene: &WorldScene,
    method: &'static str,
    devices: [D; 2],
    clock: SteppedClock,
    limits: SafetyParams,
) -> Two<D> {
    let renderer = scene.renderer(method).unwrap();
    let frames = vec![WorldFrame::the_same(); 2];
    let world = RenderedWorld::of_devices(&scene.world, renderer, method, frames).unwrap();
    let devices = devices.into_iter().map(|device| (device, limits)).collect();
    ControlLoop::of_devices(devices, clock, world).unwrap()
}

/// Two hands pinch a cube, with a listener.
pub fn a_pinch(watch: &mut Watch) {
    let scene = world_scene("worlds/pinch.toml");
    for method in ["basic", "coupled"] {
        let clock = SteppedClock::new();
        let devices =
            [0, 1].map(|device| SpatialDevice::new(&scene, device, clock.clone()).unwrap());
        let (tap, listener) = tap(10_000);
        let limits = SafetyParams::default();
        let mut control = two(&scene, method, devices, clock, limits).tapped(tap);
        let mut forces = 0;
        for _ in 0..300 {
            watch(&mut || {
                black_box(control.tick());
            });
            let said = control.device_ticks().iter();
            forces += usize::from(said.clone().all(|said| said.commanded_force != [0.0; 3]));
        }
        assert!(forces > 50, "{method}: {forces} ticks with two forces");
        let messages = listener.filter(
            |messages| matches!(messages, Message::Tick(.., devices) if devices.len() == 2),
        );
        assert_eq!(messages.count(), 300);
    }
}

/// Every fault of each device, with rearming.
pub fn faults_of_each(watch: &mut Watch) {
    use DeviceErrorKind::{Disconnected, NothingNew, Refused};
    let scene = world_scene("worlds/pinch.toml");
    let limits = SafetyParams {
        workspace: Some([[-0.2; 3], [0.2; 3]]),
        ..SafetyParams::default()
    };
    let places = [[-0.0195, 0.0005, 0.016], [0.0195, -0.0003, 0.016]];
    for at_fault in [0, 1] {
        let place = places[at_fault];
        for (fault, safety_stop) in [
            (Step::At([f64::NAN; 3]), SafetyStop::NotANumber),
            (Step::Stale, SafetyStop::StaleSample),
            (Step::Fails(NothingNew), SafetyStop::StaleSample),
            (Step::At([0.0, 0.0, 0.3]), SafetyStop::OutsideWorkspace),
            (Step::At([0.0, 0.1, 0.1]), SafetyStop::TooFast),
            (Step::Fails(Refused), SafetyStop::DeviceRefused),
            (Step::Fails(Disconnected), SafetyStop::DeviceLost),
            (Step::FailsForce(Refused, place), SafetyStop::DeviceRefused),
        ] {
            let clock = SteppedClock::new();
            let devices = [0, 1].map(|device| {
                let mut script = vec![Step::At(places[device]); 20];
                if device == at_fault {
                    script.extend([fault; 5]);
                }
                script.push(Step::At(places[device]));
                ScriptedDevice::new(clock.clone(), 3, script)
            });
            let (tap, _listener) = tap(1000);
            let mut control = two(&scene, "coupled", devices, clock, limits).tapped(tap);
            let mut has_stopped = false;
            for tick in 0..60 {
                if tick == 50 {
                    control.rearm().store(true, Ordering::Release);
                }
                watch(&mut || {
                    black_box(control.tick());
                });
                has_stopped |= control.stopped_device() == Some((at_fault, safety_stop));
            }
            assert!(has_stopped, "device {at_fault}, {fault:?}");
            assert_eq!(control.safety_stop(), None, "device {at_fault}, {fault:?}");
        }
    }
}

/// Arbitrary readings of two devices. After a safety stop of one, neither is commanded a force.
pub fn anything_of_two(watch: &mut Watch) {
    let scene = world_scene("worlds/pinch.toml");
    let (mut stopped, mut on) = (0, 0);
    for seed in 0..200 {
        let mut random = fastrand::Rng::with_seed(seed);
        let limits = SafetyParams {
            largest_force: 10_f64.powf(3.0 * random.f64() - 1.0),
            slew_limit: [f64::INFINITY, 100.0][random.usize(..2)],
            largest_speed: [f64::INFINITY, 5.0][random.usize(..2)],
            stale_after: random.u32(1..=2),
            soft_start: [0.0, 0.2][random.usize(..2)],
            ..SafetyParams::default()
        };
        let clock = SteppedClock::new();
        let devices = [0, 1].map(|_| Hostile::new(&clock, 3, random.fork(), limits.largest_force));
        let method = ["basic", "coupled"][random.usize(..2)];
        let (tap, mut listener) = tap(10);
        let mut control = two(&scene, method, devices, clock.clone(), limits).tapped(tap);
        let mut supervisor = control.supervisor().unwrap();
        for _ in 0..100 {
            match random.u8(..20) {
                1 => control.rearm().store(true, Ordering::Release),
                2 => clock.advance(Duration::from_nanos(random.u64(..20_000_000))),
                3 => clock.oversleep_once(Duration::from_nanos(random.u64(..u64::MAX >> 20))),
                4 => drop(supervisor.look(palpate_device::clock::Clock::now(&clock))),
                5 => drop(listener.by_ref().count()),
                _ => {}
            }
            watch(&mut || {
                black_box(control.tick());
            });
            let mut asked = control.devices().map(|device| device.asked);
            if control.safety_stop().is_some() {
                stopped += 1;
                assert!(
                    asked.all(|asked| asked == Wrench::NONE),
                    "{:?}",
                    control.safety_stop()
                );
            } else {
                on += usize::from(asked.any(|asked| asked != Wrench::NONE));
            }
        }
    }
    assert!(stopped > 1000 && on > 100, "{stopped}, {on}");
}
