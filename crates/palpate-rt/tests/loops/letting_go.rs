//! Every ending of a loop leaves the device without a force.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

use palpate_device::clock::{Clock, SteppedClock};
use palpate_device::{
    Capabilities, Device, DeviceError, DeviceErrorKind, NullDevice, Pose, Step, Wrench,
};
use palpate_rt::safety::{SafetyParams, SafetyStop};
use palpate_rt::{ControlLoop, Ending, Message, StopFlag, tap};
use palpate_scene::method::MethodName;

use crate::{at, scene, scripted, wide};

/// A device pressed 2 mm into the wall of `wall.toml`, which exposes its held force.
struct Pressed {
    device: NullDevice<SteppedClock>,
    held: Arc<AtomicU64>,
    /// Remaining number of zero commands that it rejects.
    refusals: Arc<AtomicUsize>,
}

impl Device for Pressed {
    fn capabilities(&self) -> &Capabilities {
        self.device.capabilities()
    }

    fn read(&mut self) -> Result<Pose, DeviceError> {
        let reading = self.device.read()?;
        Ok(Pose {
            orientation: None,
            position: [2e-3, 0.0, 0.0],
            ..reading
        })
    }

    fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError> {
        let left = self.refusals.load(Ordering::SeqCst);
        if wrench == Wrench::NONE && left > 0 {
            self.refusals.store(left - 1, Ordering::SeqCst);
            return Err(DeviceError::new(DeviceErrorKind::Refused, "not now"));
        }
        self.held.store(wrench.force[0].to_bits(), Ordering::SeqCst);
        Ok(wrench)
    }
}

#[test]
fn a_loop_that_is_dropped_commands_no_force_and_asks_twice() {
    for refuses in [0, 1] {
        let clock = SteppedClock::new();
        let held = Arc::new(AtomicU64::new(0));
        let refusals = Arc::new(AtomicUsize::new(0));
        let device = Pressed {
            device: NullDevice::new(clock.clone()),
            held: Arc::clone(&held),
            refusals: Arc::clone(&refusals),
        };
        let rendering = scene("wall.toml").rendering(MethodName::Basic).unwrap();
        let mut control = ControlLoop::new(device, clock, rendering, wide()).unwrap();
        for _ in 0..5 {
            control.tick();
        }
        assert_eq!(f64::from_bits(held.load(Ordering::SeqCst)), -2.0);
        refusals.store(refuses, Ordering::SeqCst);
        drop(control);
        assert_eq!(f64::from_bits(held.load(Ordering::SeqCst)), 0.0);
    }
}

#[test]
fn a_run_ends_when_the_device_is_gone() {
    let gone = Step::Fails(DeviceErrorKind::Disconnected);
    let (mut control, _) = scripted(vec![at(1.0), at(1.0), gone], wide());
    let ending = control.run(&StopFlag::new(), Some(100));
    assert_eq!(ending, Ending::DeviceLost);
    assert_eq!(control.statistics().ticks, 3);
    assert_eq!(control.safety_stop(), Some(SafetyStop::DeviceLost));
    assert_eq!(control.device().forces().last(), Some(&[0.0; 3]));
}

/// The device had no force meanwhile: the force returns with a soft start as after a start.
#[test]
fn a_loop_that_goes_on_begins_softly_again() {
    let limits = SafetyParams {
        soft_start: 0.2,
        slew_limit: 500.0,
        ..wide()
    };
    let (mut control, clock) = scripted(vec![at(-1.0), at(0.0), at(1.0)], limits);
    let stop = StopFlag::new();
    assert_eq!(control.run(&stop, Some(50)), Ending::Complete);
    let forces = control.device().forces();
    assert_eq!(forces[49], [-1.0, 0.0, 0.0]);
    assert_eq!(forces[50], [0.0; 3]);
    let before = clock.now();
    let forces: Vec<f64> = (0..300)
        .map(|_| -control.tick().contact.force_on_device)
        .collect();
    assert!(clock.now() > before);
    assert_eq!(forces[0], 0.0);
    assert!(
        forces.windows(2).all(|pair| pair[1] - pair[0] < 0.0051),
        "{forces:?}"
    );
    assert!((forces[299] - 1.0).abs() < 1e-9);
}

#[test]
fn what_finds_no_room_in_a_tap_is_lost_and_counted() {
    let (control, _) = scripted(vec![at(1.0)], wide());
    let (tap, mut listener) = tap(4);
    let mut control = control.tapped(tap);
    for _ in 0..10 {
        control.tick();
    }
    assert_eq!(listener.lost(), 6);
    let numbers: Vec<u64> = listener
        .by_ref()
        .map(|messages| match messages {
            Message::Tick(tick, ..) => tick.sequence,
            Message::Note(noted) => noted.sequence,
        })
        .collect();
    assert_eq!(numbers, [0, 1, 2, 3]);
    // There is free capacity again.
    control.tick();
    assert_eq!((listener.by_ref().count(), listener.lost()), (1, 6));
    // The loop's counters arrived and are final after closing.
    assert!(!listener.is_closed());
    assert_eq!(listener.counted().ticks, 11);
    drop(control);
    assert!(listener.is_closed());
    let counted = listener.counted();
    assert_eq!((counted.ticks, counted.notes, counted.lost), (11, 0, 6));
    assert_eq!((counted.motors_off, counted.ending), (0, None));
}
