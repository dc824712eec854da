//! Inverse3: messages, driver and emulator.

#![allow(clippy::print_stdout)] // tests show what they measured

mod believed;
mod commands;
mod driver;
mod faults;
mod frames;
mod garbage;
mod opening;
mod samples;
mod wall;

use std::time::{Duration, Instant};

use palpate_device::clock::MonotonicClock;
use palpate_device::{Device, DeviceError, DeviceErrorKind, Pose};
use palpate_drivers::emulator::inverse3::{Emulator, EmulatorOptions};
use palpate_drivers::inverse3::{Form, Inverse3, Inverse3Options};

/// The only device of most emulators.
pub(crate) const ID: &str = "049D";

pub(crate) fn emulator(form: Form) -> Emulator {
    Emulator::start(&EmulatorOptions {
        form,
        ..EmulatorOptions::default()
    })
    .unwrap()
}

pub(crate) fn options(emulator: &Emulator) -> Inverse3Options {
    Inverse3Options {
        service: emulator.url(),
        ..Inverse3Options::default()
    }
}

pub(crate) fn open(emulator: &Emulator) -> Inverse3<MonotonicClock> {
    Inverse3::open(&options(emulator), MonotonicClock::new()).unwrap()
}

pub(crate) fn ms(milliseconds: u64) -> Duration {
    Duration::from_millis(milliseconds)
}

/// Waits until `holds` returns true, for at most 10 s on a busy machine.
#[track_caller]
pub(crate) fn wait_until(what: &str, mut holds: impl FnMut() -> bool) {
    let deadline = Instant::now() + Duration::from_secs(10);
    while !holds() {
        assert!(Instant::now() < deadline, "never: {what}");
        std::thread::sleep(ms(1));
    }
}

/// Returns the next sample.
#[track_caller]
pub(crate) fn next(device: &mut Inverse3<MonotonicClock>) -> Pose {
    let mut found = None;
    wait_until("a sample", || match device.read() {
        Ok(reading) => {
            found = Some(reading);
            true
        }
        Err(error) => {
            assert_eq!(error.kind, DeviceErrorKind::NothingNew, "{error}");
            false
        }
    });
    found.unwrap()
}

/// Returns the first error other than a missing sample, while `force` is commanded.
#[track_caller]
pub(crate) fn error_under(device: &mut Inverse3<MonotonicClock>, force: [f64; 3]) -> DeviceError {
    let mut found = None;
    wait_until("an error", || {
        found = device
            .read()
            .err()
            .filter(|error| error.kind != DeviceErrorKind::NothingNew);
        let _ = device.write(force.into());
        found.is_some()
    });
    found.unwrap()
}
