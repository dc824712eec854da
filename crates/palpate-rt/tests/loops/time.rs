//! Time stamps of devices, and durations of runs.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use palpate_device::clock::{Clock, SteppedClock};
use palpate_device::{Capabilities, Device, DeviceError, NullDevice, Pose, Wrench};
use palpate_rt::safety::SafetyStop;
use palpate_rt::{ControlLoop, Ending, Message, Note, StopFlag, tap};
use palpate_scene::method::MethodName;

use crate::{at, scene, scripted, wide};

/// A device pressed into the wall, whose time stamps are `ahead` of the clock for a while.
struct Stamps {
    device: NullDevice<SteppedClock>,
    ahead: Duration,
    wrong: Arc<AtomicUsize>,
}

impl Device for Stamps {
    fn capabilities(&self) -> &Capabilities {
        self.device.capabilities()
    }

    fn read(&mut self) -> Result<Pose, DeviceError> {
        let mut reading = self.device.read()?;
        reading.position = [2e-3, 0.0, 0.0];
        let left = self.wrong.load(Ordering::SeqCst);
        if left > 0 {
            self.wrong.store(left - 1, Ordering::SeqCst);
            reading.time = reading.time.saturating_add(self.ahead);
        }
        Ok(reading)
    }

    fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError> {
        Ok(wrench)
    }
}

fn stamps(ahead: Duration) -> (ControlLoop<Stamps, SteppedClock>, Arc<AtomicUsize>) {
    let clock = SteppedClock::new();
    let wrong = Arc::new(AtomicUsize::new(0));
    let device = Stamps {
        device: NullDevice::new(clock.clone()),
        ahead,
        wrong: Arc::clone(&wrong),
    };
    let rendering = scene("wall.toml").rendering(MethodName::Basic).unwrap();
    let control = ControlLoop::new(device, clock, rendering, wide()).unwrap();
    (control, wrong)
}

/// Accepting the stamp would make every later sample outdated: no force until the clock reaches it.
#[test]
fn a_time_stamp_far_ahead_is_no_sample_and_mutes_nothing() {
    for ahead in [
        Duration::from_millis(30),
        Duration::from_secs(3600),
        Duration::MAX,
    ] {
        for times in 1..4 {
            let (control, wrong) = stamps(ahead);
            let (tap, listener) = tap(1000);
            let mut control = control.tapped(tap);
            for _ in 0..5 {
                control.tick();
            }
            wrong.store(times, Ordering::SeqCst);
            let forces: Vec<f64> = (0..times)
                .map(|_| control.tick().contact.force_on_device)
                .collect();
            assert_eq!(forces[0], -2.0, "{ahead:?}: one is bridged");
            assert!(forces[1..].iter().all(|force| *force == 0.0), "{forces:?}");
            let stale = (times > 1).then_some(SafetyStop::StaleSample);
            assert_eq!(control.safety_stop(), stale, "{ahead:?}");
            // The next valid sample counts, and the elapsed time is counted from the last valid one.
            let next = control.tick();
            assert_eq!(next.contact.force_on_device, -2.0, "{ahead:?}");
            let periods = next.tick.period / control.period().as_secs_f64();
            assert!((periods - (times as f64 + 1.0)).abs() < 1e-6, "{periods}");
            let said = listener
                .filter(|messages| {
                    matches!(messages, Message::Note(noted)
                        if matches!(noted.note, Note::Device(error) if error.what.contains("ahead")))
                })
                .count();
            assert_eq!(said, times.min(2), "until it has stopped");
        }
    }
}

/// A clock that is read slightly later than the device's causes no lost sample.
#[test]
fn a_time_stamp_a_little_ahead_is_a_sample() {
    let (mut control, wrong) = stamps(Duration::from_micros(100));
    wrong.store(usize::MAX, Ordering::SeqCst);
    for _ in 0..50 {
        assert_eq!(control.tick().contact.force_on_device, -2.0);
    }
    assert_eq!(control.statistics().without_sample, 0);
}

#[test]
fn a_run_that_misses_deadlines_takes_as_long_as_it_was_to_take() {
    let (mut control, clock) = scripted(vec![at(1.0)], wide());
    clock.oversleep_once(Duration::from_micros(20_500));
    assert_eq!(control.run(&StopFlag::new(), Some(50)), Ending::Complete);
    assert_eq!(clock.now(), Duration::from_millis(49));
    let statistics = control.statistics();
    assert_eq!((statistics.ticks, statistics.missed_deadlines), (30, 20));
    // A stall beyond the end of the run ends it.
    let (mut control, clock) = scripted(vec![at(1.0)], wide());
    clock.oversleep_once(Duration::from_secs(1));
    assert_eq!(control.run(&StopFlag::new(), Some(50)), Ending::Complete);
    assert_eq!(control.statistics().ticks, 1);
}
