//! Driver with a faulty service.

use std::net::TcpListener;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use palpate_device::clock::MonotonicClock;
use palpate_device::{Device, DeviceErrorKind};
use palpate_drivers::emulator::inverse3::{Emulator, Fault};
use palpate_drivers::inverse3::{Counts, Form, Inverse3, Inverse3Options, Pace};
use serde_json::json;
use tungstenite::Message;

use crate::inverse3::samples::full_3_5;
use crate::inverse3::{ID, emulator, error_under, ms, next, open, options, wait_until};

const FORCE: [f64; 3] = [1.0, 0.0, 0.0];

/// Reads and writes a device `times` times.
fn driven(device: &mut Inverse3<MonotonicClock>, times: u32) {
    for _ in 0..times {
        let _ = device.read();
        let _ = device.write(FORCE.into());
        std::thread::sleep(ms(1));
    }
}

/// Reads and writes a device until its counters satisfy `holds`.
fn driven_until(
    device: &mut Inverse3<MonotonicClock>,
    what: &str,
    holds: impl Fn(&Counts) -> bool,
) -> Counts {
    let inspector = device.inspector();
    wait_until(what, || {
        driven(device, 1);
        holds(&inspector.counts())
    });
    inspector.counts()
}

/// Returns the counters once `fault` has occurred, by `has_come`, and samples arrive again.
fn after(emulator: &Emulator, fault: Fault, has_come: impl Fn(&Counts) -> bool) -> Counts {
    let mut device = open(emulator);
    driven_until(&mut device, "samples", |counts| counts.fresh > 5);
    emulator.inject(fault);
    let before = driven_until(&mut device, "the fault", has_come).fresh;
    let more = |counts: &Counts| counts.fresh > before + 5;
    let counts = driven_until(&mut device, "samples again", more);
    wait_until("the force again", || {
        let _ = device.write(FORCE.into());
        emulator.force(ID) == Some(FORCE)
    });
    println!("{fault:?}: {counts:?}");
    counts
}

#[test]
fn an_answer_that_comes_twice_is_one_sample() {
    let emulator = emulator(Form::V35);
    let mut device = open(&emulator);
    driven_until(&mut device, "samples", |counts| counts.fresh > 5);
    for _ in 0..20 {
        emulator.inject(Fault::Twice);
    }
    let before = emulator.served();
    driven_until(&mut device, "20 answers that come twice", |counts| {
        let served = emulator.served();
        let all = served.messages - before.messages + 20;
        counts.surplus >= 19 && served.replies - before.replies >= all
    });
    let inspector = device.inspector();
    drop(device);
    let (counts, served) = (inspector.counts(), emulator.served());
    println!("{counts:?}");
    assert_eq!(
        served.replies - before.replies,
        served.messages - before.messages + 20
    );
    // 20 frames answered no message; there are at most as many samples as messages.
    assert!(counts.surplus >= 19, "{counts:?}");
    assert!(
        counts.fresh + counts.late + counts.lost <= counts.sent,
        "{counts:?}"
    );
}

#[test]
fn an_answer_that_never_comes_is_written_off() {
    let counts = after(&emulator(Form::V31), Fault::Dropped, |counts| {
        counts.lost >= 1 && counts.stalls >= 1
    });
    assert!(counts.lost >= 1 && counts.stalls >= 1, "{counts:?}");
    assert_eq!(counts.garbage, 0);
}

#[test]
fn an_answer_that_comes_late_is_no_sample() {
    let counts = after(&emulator(Form::V35), Fault::Late, |counts| counts.late >= 1);
    assert!(counts.late >= 1, "{counts:?}");
    assert_eq!(counts.lost, 0, "{counts:?}");
    assert!(counts.longest_round_trip <= ms(10), "{counts:?}");
}

#[test]
fn what_is_no_frame_is_no_sample_and_no_reason_to_end() {
    for fault in [Fault::Garbage, Fault::HalfFrame] {
        let counts = after(&emulator(Form::V35), fault, |counts| counts.garbage >= 1);
        assert_eq!(counts.garbage, 1, "{counts:?}");
    }
}

#[test]
fn frames_that_are_none_for_long_are_somebodys_business() {
    let emulator = emulator(Form::V35);
    let mut device = open(&emulator);
    for _ in 0..150 {
        emulator.inject(Fault::Garbage);
    }
    let error = error_under(&mut device, FORCE);
    assert_eq!(error.kind, DeviceErrorKind::Refused);
    assert!(error.what.contains("invalid frames"), "{error}");
    wait_until("samples again", || device.read().is_ok());
}

#[test]
fn a_service_that_stands_still_is_commanded_no_force_when_it_comes_back() {
    let emulator = emulator(Form::V35);
    let mut device = open(&emulator);
    wait_until("the force", || {
        device.write(FORCE.into()).unwrap();
        emulator.force(ID) == Some(FORCE)
    });
    emulator.inject(Fault::Stall(ms(500)));
    let before = emulator.received().len();
    let stalls = device.inspector().counts().stalls;
    driven_until(&mut device, "a stall", |counts| counts.stalls > stalls);
    assert_eq!(emulator.received().len(), before, "it stands still");
    wait_until("it is back", || emulator.received().len() > before + 5);
    // The message in flight at the stall, then one with zero force. Forces follow only after the answers to both.
    let received = emulator.received();
    assert_eq!(received[before + 1].force, Some([0.0; 3]));
    wait_until("the force again", || {
        device.write(FORCE.into()).unwrap();
        emulator.force(ID) == Some(FORCE)
    });
    assert!(device.inspector().counts().late >= 1);
}

#[test]
fn a_service_that_stands_still_for_long_is_gone() {
    let emulator = emulator(Form::V35);
    let mut device = Inverse3::open(
        &Inverse3Options {
            pace: Pace {
                give_up_after: ms(100),
                ..Pace::default()
            },
            ..options(&emulator)
        },
        MonotonicClock::new(),
    )
    .unwrap();
    emulator.inject(Fault::Stall(ms(500)));
    let error = error_under(&mut device, FORCE);
    assert_eq!(error.kind, DeviceErrorKind::Disconnected);
    assert!(error.what.contains("does not answer"), "{error}");
    wait_until("no force", || emulator.force(ID) == Some([0.0; 3]));
}

#[test]
fn lost_connection_is_reported_and_device_can_be_reopened() {
    let emulator = emulator(Form::V35);
    for (fault, words) in [
        (Fault::Disconnect, "connection"),
        (Fault::HalfBytes, "connection"),
        (Fault::Close, "has closed the connection"),
    ] {
        let mut device = open(&emulator);
        wait_until("the force", || {
            device.write(FORCE.into()).unwrap();
            emulator.force(ID) == Some(FORCE)
        });
        emulator.inject(fault);
        let error = error_under(&mut device, FORCE);
        assert_eq!(error.kind, DeviceErrorKind::Disconnected, "{fault:?}");
        assert!(error.what.contains(words), "{fault:?}: {error}");
        // The error persists, and forces are refused.
        assert_eq!(device.read().unwrap_err(), error);
        assert_eq!(device.write(FORCE.into()).unwrap_err(), error);
        wait_until("the service to idle it", || {
            emulator.force(ID) == Some([0.0; 3])
        });
        drop(device);
        next(&mut open(&emulator));
    }
}

#[test]
fn a_device_that_is_unplugged_is_gone() {
    let emulator = emulator(Form::V35);
    let mut device = open(&emulator);
    wait_until("the force", || {
        device.write(FORCE.into()).unwrap();
        emulator.force(ID) == Some(FORCE)
    });
    emulator.set_present(ID, false);
    let error = error_under(&mut device, FORCE);
    assert_eq!(error.kind, DeviceErrorKind::Disconnected);
    assert!(error.what.contains("no longer lists the device"), "{error}");
    drop(device);
    emulator.set_present(ID, true);
    next(&mut open(&emulator));
}

#[test]
fn events_channel_reports_safety_stop_and_disconnection() {
    let emulator = emulator(Form::V35);
    let listening = Inverse3Options {
        events: Some(emulator.events_url()),
        ..options(&emulator)
    };
    let open = || Inverse3::open(&listening, MonotonicClock::new()).unwrap();
    let mut device = open();
    emulator.trigger_safety("04BA", "ebrake_triggered");
    driven(&mut device, 50);
    emulator.trigger_safety(ID, "ebrake_triggered");
    let error = error_under(&mut device, FORCE);
    assert_eq!(error.kind, DeviceErrorKind::Refused);
    assert!(error.what.contains("reports a safety stop"), "{error}");
    // The error is reported once; a loop's safety layer stays stopped.
    next(&mut device);
    emulator.set_present(ID, false);
    let error = error_under(&mut device, FORCE);
    assert_eq!(error.kind, DeviceErrorKind::Disconnected);
    println!("{error}");
    drop(device);
    emulator.set_present(ID, true);
    next(&mut open());
    let nobody = Inverse3Options {
        events: Some("ws://127.0.0.1:1".into()),
        ..options(&emulator)
    };
    let said = Inverse3::open(&nobody, MonotonicClock::new()).unwrap_err();
    assert!(
        said.to_string()
            .contains("no answer from ws://127.0.0.1:1/")
    );
}

#[test]
fn a_device_that_loses_its_power_takes_no_force_until_it_has_it_again() {
    let emulator = emulator(Form::V35);
    let mut device = open(&emulator);
    wait_until("the force", || {
        device.write(FORCE.into()).unwrap();
        emulator.force(ID) == Some(FORCE)
    });
    emulator.set_status(ID, |status| status.power_supply = Some(false));
    let error = error_under(&mut device, FORCE);
    assert_eq!(error.kind, DeviceErrorKind::Refused);
    assert!(error.what.contains("lost the power"), "{error}");
    assert_eq!(device.write(FORCE.into()).unwrap_err(), error);
    wait_until("no force", || emulator.force(ID) == Some([0.0; 3]));
    // However often a force is written.
    driven(&mut device, 50);
    assert_eq!(emulator.force(ID), Some([0.0; 3]));
    assert_eq!(device.write([0.0; 3].into()), Ok([0.0; 3].into()));
    emulator.set_status(ID, |status| status.power_supply = Some(true));
    wait_until("the force again", || {
        let _ = device.write(FORCE.into());
        emulator.force(ID) == Some(FORCE)
    });
}

/// The loop does not read in between: the force must not return before the loop has seen the error.
#[test]
fn power_that_comes_back_between_two_looks_gives_no_force_before_the_loop_knows() {
    let emulator = emulator(Form::V35);
    let patient = Inverse3Options {
        pace: Pace {
            hold: ms(60_000),
            ..Pace::default()
        },
        ..options(&emulator)
    };
    let mut device = Inverse3::open(&patient, MonotonicClock::new()).unwrap();
    device.write(FORCE.into()).unwrap();
    wait_until("the force", || emulator.force(ID) == Some(FORCE));
    emulator.set_status(ID, |status| status.power_supply = Some(false));
    wait_until("no force", || emulator.force(ID) == Some([0.0; 3]));
    // A device without power applies no force in any case. The driver knows once it has answered a frame that shows it.
    let messages = emulator.served().messages;
    wait_until("frames that say so", || {
        emulator.served().messages > messages + 3
    });
    emulator.set_status(ID, |status| status.power_supply = Some(true));
    let fresh = device.inspector().counts().fresh;
    let exchanged = |by| device.inspector().counts().fresh > fresh + by;
    wait_until("exchanges", || exchanged(20));
    assert_eq!(emulator.force(ID), Some([0.0; 3]));
    let error = device.read().unwrap_err();
    assert_eq!(error.kind, DeviceErrorKind::Refused);
    assert!(error.what.contains("lost the power"), "{error}");
    // The order from before the report is no longer valid.
    let fresh = device.inspector().counts().fresh;
    let exchanged = |by| device.inspector().counts().fresh > fresh + by;
    wait_until("exchanges", || exchanged(20));
    assert_eq!(emulator.force(ID), Some([0.0; 3]));
    next(&mut device);
    device.write(FORCE.into()).unwrap();
    wait_until("the force again", || emulator.force(ID) == Some(FORCE));
}

/// Starts a service whose device is uncalibrated, without a position, in as many frames as the returned counter says.
fn service_without_a_position() -> (String, Arc<AtomicU32>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let url = format!("ws://{}", listener.local_addr().unwrap());
    let left = Arc::new(AtomicU32::new(0));
    let theirs = Arc::clone(&left);
    std::thread::spawn(move || {
        let (stream, _) = listener.accept().unwrap();
        let mut socket = tungstenite::accept(stream).unwrap();
        let good = full_3_5();
        let mut lost = good.clone();
        lost["inverse3"][0]["state"]["cursor_position"] = json!(null);
        lost["inverse3"][0]["status"]["calibrated"] = json!(false);
        let mut frame = &good;
        while socket.send(Message::text(frame.to_string())).is_ok() && socket.read().is_ok() {
            let lasts = theirs.load(Ordering::SeqCst);
            frame = if lasts > 0 { &lost } else { &good };
            theirs.store(lasts.saturating_sub(1), Ordering::SeqCst);
        }
    });
    (url, left)
}

/// An uncalibrated device has no position; the missing position must not hide the missing calibration.
#[test]
fn missing_calibration_is_reported_despite_missing_position() {
    let (url, left) = service_without_a_position();
    let options = Inverse3Options {
        service: url,
        ..Inverse3Options::default()
    };
    let mut device = Inverse3::open(&options, MonotonicClock::new()).unwrap();
    next(&mut device);
    left.store(5, Ordering::SeqCst);
    let error = error_under(&mut device, FORCE);
    assert_eq!(error.kind, DeviceErrorKind::Refused);
    assert!(error.what.contains("no longer calibrated"), "{error}");
}
