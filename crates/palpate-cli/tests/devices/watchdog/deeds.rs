//! Loops whose own thread hangs, spins or aborts.

use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::Duration;

use palpate_core::{AlongAxis, AnyParams, Contact, LoopParams, ObjectState};
use palpate_device::Device;
use palpate_device::clock::MonotonicClock;
use palpate_drivers::two_diy::{Calibration, Generation, Options, TwoDiy};
use palpate_rt::safety::SafetyParams;
use palpate_rt::{ControlLoop, Rendering};

use super::processes::{children, is_held};
use super::{ATTEMPTS, emulator, folder, is_on, off_since, presses, silence, wait_for};
use crate::common::running::Running;

/// A program whose own loop thread misbehaves: this test program in another process.
const PORT: &str = "PALPATE_TEST_PORT";
const DEED: &str = "PALPATE_TEST_DEED";

/// Does nothing alone; run by [`a_loop_that_hangs_or_aborts_leaves_no_torque`].
#[test]
fn a_program_whose_loop_does_something_bad() {
    let (Ok(port), Ok(deed)) = (std::env::var(PORT), std::env::var(DEED)) else {
        return;
    };
    let clock = MonotonicClock::new();
    let period = Duration::from_millis(2);
    let calibration = Calibration::At([130.0, 50.0]);
    let options = Options::new(Generation::Three, calibration, period).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_palpate"));
    command.arg("watchdog");
    let device = TwoDiy::open(&PathBuf::from(port), &options, clock).unwrap();
    let device = device
        .guarded_by(command, Duration::from_millis(100), Default::default())
        .unwrap();
    let rendering = Rendering {
        contact: Contact::object(300.0, f64::INFINITY),
        loop_params: LoopParams::new(period.as_secs_f64()),
        params: AnyParams::Basic,
        virtual_force: 0.0,
        object: ObjectState::at_rest(0.0),
    };
    let limits = SafetyParams {
        soft_start: 0.0,
        stall_after_periods: 50.0,
        ..SafetyParams::for_device(device.capabilities())
    };
    let axis = AlongAxis::new([0.019, 0.11, 0.0], [0.0, 1.0, 0.0]).unwrap();
    // Without a thread, and therefore without a supervisor.
    let mut control = ControlLoop::new(device, clock, rendering, limits)
        .unwrap()
        .along(axis);
    let mut pressed = 0;
    while pressed < 50 {
        let tick = control.tick();
        pressed = if tick.contact.force_on_device == 0.0 {
            0
        } else {
            pressed + 1
        };
    }
    match deed.as_str() {
        "abort" => std::process::abort(),
        "exit" => std::process::exit(0),
        "hang" => loop {
            std::thread::sleep(Duration::from_secs(1));
        },
        "spin" => loop {
            std::hint::spin_loop();
        },
        other => panic!("{other} is no deed"),
    }
}

#[test]
fn a_loop_that_hangs_or_aborts_leaves_no_torque() {
    for deed in ["abort", "exit"] {
        let silence = silent_after(deed);
        println!("{deed}: no torque {silence:?} after the last packet with one");
    }
    // If the late loop had just disabled its force itself, the watchdog process had nothing to cut.
    for deed in ["hang", "spin"] {
        let silences = (0..ATTEMPTS).map(|_| silent_after(deed));
        let cut = silences
            .inspect(|silence| {
                println!("{deed}: no torque {silence:?} after the last packet with one")
            })
            .find(|silence| *silence >= Duration::from_millis(90));
        assert!(cut.is_some(), "{deed}");
    }
}

/// Returns the time that a torque stayed on, after the last packet with one, when a loop's own thread misbehaved.
fn silent_after(deed: &str) -> Duration {
    let folder = folder();
    let emulator = emulator(&folder);
    let port = emulator.path();
    let start = || {
        let mut bad = Command::new(std::env::current_exe().unwrap());
        bad.args([
            "--exact",
            "watchdog::deeds::a_program_whose_loop_does_something_bad",
        ])
        .env(PORT, &port)
        .env(DEED, deed);
        let mut bad = Running::start(bad.stdout(Stdio::null()).stderr(Stdio::null()));
        // The misbehaviour may come before the first check.
        let is_seen = presses(&mut bad, &emulator) || off_since(&emulator).is_some();
        is_seen.then_some(bad)
    };
    let mut bad = (0..ATTEMPTS)
        .find_map(|_| start())
        .expect("it never pressed");
    let ends = matches!(deed, "abort" | "exit");
    if ends {
        bad.wait().unwrap();
    }
    let quiet = Duration::from_millis(300);
    wait_for(&format!("no torque after {deed}"), || {
        off_since(&emulator).is_some_and(|since| since.elapsed() > quiet)
    });
    assert!(!is_on(&emulator), "{deed}");
    if !ends {
        // Only the watchdog process can have disabled the output; it lives as long as the loop.
        assert!(bad.try_wait().unwrap().is_none());
        assert_eq!(children(bad.id()).len(), 1);
        bad.kill().unwrap();
        bad.wait().unwrap();
    }
    wait_for("the end of the watchdog", || !is_held(&port));
    silence(&emulator.seen())
}
