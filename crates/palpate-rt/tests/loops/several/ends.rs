//! Endings of a loop with two devices, and slow devices.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use palpate_device::clock::{Clock, SteppedClock};
use palpate_device::{Capabilities, Device, DeviceError, Pose, Wrench, ZeroWriter};
use palpate_record::recording::Flags;
use palpate_rt::realtime::Request;
use palpate_rt::safety::SafetyStop;
use palpate_rt::{ControlLoop, Ending, LoopThread, StopFlag};

use super::{Several, two_points};
use crate::wide;

/// A device pressed 2 mm into the table, which holds its commands and panics on request.
struct Pressed {
    clock: SteppedClock,
    capabilities: Capabilities,
    held: Arc<AtomicU64>,
    panics: Arc<AtomicBool>,
    /// Response time.
    takes: Duration,
}

impl Device for Pressed {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn read(&mut self) -> Result<Pose, DeviceError> {
        self.clock.advance(self.takes);
        assert!(!self.panics.load(Ordering::SeqCst), "so it was asked to");
        Ok(Pose::at([0.0, 0.0, -2e-3], self.clock.now()))
    }

    fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError> {
        assert!(!self.panics.load(Ordering::SeqCst), "so it was asked to");
        let [.., up] = wrench.force;
        self.held.store(up.to_bits(), Ordering::SeqCst);
        Ok(wrench)
    }

    fn zero_writer(&mut self) -> Option<Box<dyn ZeroWriter>> {
        struct Zero(Arc<AtomicU64>);
        impl ZeroWriter for Zero {
            fn write_zero(&mut self) {
                self.0.store(0, Ordering::SeqCst);
            }
        }
        assert!(!self.panics.load(Ordering::SeqCst), "so it was asked to");
        Some(Box::new(Zero(Arc::clone(&self.held))))
    }
}

type Held = [(Arc<AtomicU64>, Arc<AtomicBool>); 2];

fn pressed(takes: [Duration; 2]) -> (Several<Pressed>, Held) {
    let clock = SteppedClock::new();
    let held: Held = Default::default();
    let devices = held.iter().zip(takes).map(|((held, panics), takes)| {
        let device = Pressed {
            clock: clock.clone(),
            capabilities: Capabilities::unknown("pressed", 3),
            held: Arc::clone(held),
            panics: Arc::clone(panics),
            takes,
        };
        (device, wide())
    });
    let control = ControlLoop::of_devices(devices.collect(), clock.clone(), two_points()).unwrap();
    (control, held)
}

fn forces(held: &Held) -> [f64; 2] {
    [0, 1].map(|device| f64::from_bits(held[device].0.load(Ordering::SeqCst)))
}

#[test]
fn however_a_loop_ends_all_devices_are_without_a_force() {
    let begin = || {
        let (mut control, held) = pressed([Duration::ZERO; 2]);
        for _ in 0..5 {
            control.tick();
        }
        assert_eq!(forces(&held), [2.0; 2]);
        (control, held)
    };
    let (control, held) = begin();
    drop(control);
    assert_eq!(forces(&held), [0.0; 2]);

    let (mut control, held) = begin();
    assert_eq!(control.run(&StopFlag::new(), Some(20)), Ending::Complete);
    assert_eq!(forces(&held), [0.0; 2]);

    let (mut control, held) = begin();
    let stop = StopFlag::new();
    stop.raise();
    assert_eq!(control.run(&stop, None), Ending::Stopped);
    assert_eq!(forces(&held), [0.0; 2]);

    // One device panics repeatedly, in `write` and in its zero writer: the output of the other device is disabled.
    for at_fault in [0, 1] {
        let (control, held) = begin();
        let running = LoopThread::start(control, Request::nothing(), &StopFlag::new(), None);
        held[at_fault].1.store(true, Ordering::SeqCst);
        let end = running.unwrap().join();
        assert_eq!(end.ending, Ending::Panicked);
        assert_eq!(forces(&held)[1 - at_fault], 0.0, "device {at_fault}");

        let (control, held) = begin();
        held[at_fault].1.store(true, Ordering::SeqCst);
        catch_unwind(AssertUnwindSafe(|| drop(control))).unwrap();
        assert_eq!(forces(&held)[1 - at_fault], 0.0, "device {at_fault}");
    }
}

/// A tick contains the response times of all devices, and a device that is too slow removes all forces.
#[test]
fn answers_of_several_devices_take_their_time_one_after_the_other() {
    let micros = Duration::from_micros;
    let (mut control, held) = pressed([micros(200), micros(300)]);
    for _ in 0..10 {
        let tick = control.tick().tick;
        assert!((tick.device_round_trip - 500e-6).abs() < 1e-12);
        assert!(!tick.flags.has(Flags::MISSED_DEADLINE));
        let said = control.device_ticks();
        for (device, (time, answer)) in said.iter().zip([(200e-6, 200e-6), (500e-6, 300e-6)]) {
            let time = time + 1e-3 * tick.sequence as f64;
            assert!((device.time - time).abs() < 1e-12, "{device:?}");
            assert!((device.round_trip - answer).abs() < 1e-12, "{device:?}");
        }
        // Time of the newest sample.
        assert_eq!(tick.time, said[1].time);
        assert_eq!(forces(&held), [2.0; 2]);
    }
    // Together they miss each deadline, and the loop continues with every second one.
    let (mut control, held) = pressed([micros(700), micros(600)]);
    for _ in 0..10 {
        assert!(control.tick().tick.flags.has(Flags::MISSED_DEADLINE));
    }
    assert_eq!(control.statistics().missed_deadlines, 10);
    assert_eq!(forces(&held), [2.0; 2]);
    drop(control);
    let (mut control, held) = pressed([micros(200), Duration::from_millis(30)]);
    for _ in 0..10 {
        control.tick();
    }
    assert_eq!(control.safety_stop(), Some(SafetyStop::Stalled));
    assert_eq!(forces(&held), [0.0; 2]);
}
