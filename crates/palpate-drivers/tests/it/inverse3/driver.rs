//! Driver with an emulated service.

use std::time::Instant;

use palpate_device::clock::MonotonicClock;
use palpate_device::{Device, DeviceErrorKind};
use palpate_drivers::emulator::inverse3::{Emulator, EmulatorOptions, Fault, Latency};
use palpate_drivers::inverse3::{Form, Inverse3, Inverse3Options, Pace};

use crate::inverse3::{ID, emulator, ms, next, open, options, wait_until};

#[test]
fn a_force_moves_the_device_in_both_forms() {
    for form in [Form::V31, Form::V35] {
        let emulator = emulator(form);
        let mut device = open(&emulator);
        assert_eq!((device.form(), device.device_id()), (form, ID));
        assert_eq!(device.capabilities().axes, 3);
        assert_eq!(next(&mut device).position, [0.0; 3]);
        let force = [1.0, 0.0, -2.0];
        let mut last = next(&mut device);
        wait_until("the device to move", || {
            assert_eq!(device.write(force.into()), Ok(force.into()));
            let reading = next(&mut device);
            assert!(reading.time > last.time);
            last = reading;
            // Towards 10 and -20 mm, against a hand of 100 N/m.
            reading.position[0] > 0.008 && reading.position[2] < -0.016
        });
        assert_eq!(last.position[1], 0.0);
        assert_eq!(emulator.force(ID), Some(force));
        let sent = emulator.received();
        assert!(
            sent.iter()
                .all(|message| message.device_id.as_deref() == Some(ID))
        );
        let configured = u64::from(form == Form::V35);
        assert_eq!(emulator.served().configured, configured);
    }
}

#[test]
fn the_last_message_of_a_device_that_goes_commands_no_force() {
    let emulator = emulator(Form::V35);
    let mut device = open(&emulator);
    device.write([0.0, 3.0, 0.0].into()).unwrap();
    wait_until("the force", || emulator.force(ID) == Some([0.0, 3.0, 0.0]));
    drop(device);
    assert_eq!(emulator.received().last().unwrap().force, Some([0.0; 3]));
    assert_eq!(emulator.force(ID), Some([0.0; 3]));
}

#[test]
fn driver_zeroes_force_when_its_thread_panics() {
    let emulator = emulator(Form::V35);
    let mut device = open(&emulator);
    device.write([0.0, 3.0, 0.0].into()).unwrap();
    wait_until("the force", || emulator.force(ID) == Some([0.0, 3.0, 0.0]));
    let panicked = std::thread::spawn(move || {
        let _device = device;
        panic!("so that the device goes in a panic");
    });
    assert!(panicked.join().is_err());
    assert_eq!(emulator.received().last().unwrap().force, Some([0.0; 3]));
}

/// Opens a device that does not command zero force by itself, neither for a late answer nor for a silent loop, however
/// busy the machine is.
fn open_patient(emulator: &Emulator) -> Inverse3<MonotonicClock> {
    let patient = Inverse3Options {
        pace: Pace {
            reply_timeout: ms(20_000),
            hold: ms(60_000),
            ..Pace::default()
        },
        ..options(emulator)
    };
    Inverse3::open(&patient, MonotonicClock::new()).unwrap()
}

#[test]
fn the_supervisors_cut_goes_out_by_itself_and_lasts_until_the_next_order() {
    let emulator = emulator(Form::V35);
    let mut device = open_patient(&emulator);
    let mut zero = device.zero_writer().unwrap();
    let force = [2.0, 0.0, 0.0];
    device.write(force.into()).unwrap();
    wait_until("the force", || emulator.force(ID) == Some(force));
    let cut = Instant::now();
    zero.write_zero();
    let commanded = || emulator.received().last().unwrap().force;
    wait_until("no force", || commanded() == Some([0.0; 3]));
    println!("no force after {:?}", cut.elapsed());
    std::thread::sleep(ms(20));
    assert_eq!(commanded(), Some([0.0; 3]));
    assert_eq!(emulator.force(ID), Some([0.0; 3]));
    device.write(force.into()).unwrap();
    wait_until("the force again", || emulator.force(ID) == Some(force));
}

#[test]
fn no_force_does_not_wait_for_an_answer() {
    let emulator = emulator(Form::V35);
    let mut device = open_patient(&emulator);
    let inspector = device.inspector();
    device.write([1.0, 0.0, 0.0].into()).unwrap();
    wait_until("the force", || emulator.force(ID) == Some([1.0, 0.0, 0.0]));
    emulator.inject(Fault::Stall(ms(1000)));
    std::thread::sleep(ms(50));
    // A non-zero force waits for the answer; zero force does not.
    let (sent, received) = (inspector.counts().sent, emulator.received().len());
    device.write([2.0, 0.0, 0.0].into()).unwrap();
    std::thread::sleep(ms(50));
    assert_eq!(inspector.counts().sent, sent);
    device.write([0.0; 3].into()).unwrap();
    wait_until("it is sent", || inspector.counts().sent > sent);
    assert_eq!(emulator.received().len(), received, "it still stands");
    wait_until("it is back", || emulator.received().len() > received + 1);
    assert_eq!(emulator.received()[received + 1].force, Some([0.0; 3]));
}

#[test]
fn a_loop_that_says_nothing_any_more_holds_no_force() {
    // The service does not idle during the test and does not count as stalled.
    let emulator = Emulator::start(&EmulatorOptions {
        idle_after: ms(60_000),
        ..EmulatorOptions::default()
    })
    .unwrap();
    let patient = Inverse3Options {
        pace: Pace {
            reply_timeout: ms(5000),
            ..Pace::default()
        },
        ..options(&emulator)
    };
    let mut device = Inverse3::open(&patient, MonotonicClock::new()).unwrap();
    let ordered = Instant::now();
    device.write([2.0, 0.0, 0.0].into()).unwrap();
    wait_until("the force", || emulator.force(ID) == Some([2.0, 0.0, 0.0]));
    wait_until("no force", || emulator.force(ID) == Some([0.0; 3]));
    assert!(ordered.elapsed() >= Pace::default().hold);
    assert_eq!(emulator.received().last().unwrap().force, Some([0.0; 3]));
}

#[test]
fn the_service_idles_a_device_whose_program_was_killed() {
    // A silent connection is the state after all senders have failed.
    let emulator = emulator(Form::V35);
    let (mut socket, _) = tungstenite::connect(emulator.url()).unwrap();
    let force = r#"{"inverse3":[{"device_id":"049D","commands":{"set_cursor_force":{"vector":{"x":1,"y":0,"z":0}}}}]}"#;
    socket.send(tungstenite::Message::text(force)).unwrap();
    wait_until("the force", || emulator.force(ID) == Some([1.0, 0.0, 0.0]));
    wait_until("idling", || emulator.force(ID) == Some([0.0; 3]));
    assert_eq!(emulator.served().messages, 1);
}

#[test]
fn each_message_has_one_answer_and_one_answer_is_one_sample() {
    let emulator = emulator(Form::V35);
    let mut device = open(&emulator);
    let before = emulator.served();
    let inspector = device.inspector();
    let (mut fresh, mut nothing) = (0, 0);
    let until = Instant::now() + ms(300);
    while Instant::now() < until {
        match device.read() {
            Ok(_) => fresh += 1,
            Err(error) => {
                assert_eq!(error.kind, DeviceErrorKind::NothingNew);
                nothing += 1;
            }
        }
        device.write([0.0; 3].into()).unwrap();
        std::thread::sleep(ms(1));
    }
    drop(device);
    let (counts, served) = (inspector.counts(), emulator.served());
    println!("{counts:?}\n{served:?}\nfresh {fresh}, nothing new {nothing}");
    assert_eq!(
        served.replies - before.replies,
        served.messages - before.messages
    );
    assert_eq!(counts.sent, served.messages - before.messages);
    assert_eq!((counts.surplus, counts.garbage, counts.lost), (0, 0, 0));
    // No sample was read twice, and samples that arrived between two reads were skipped.
    assert!(0 < fresh && fresh <= counts.fresh);
}

#[test]
fn a_loop_that_reads_faster_than_the_service_answers_finds_nothing_new() {
    let emulator = Emulator::start(&EmulatorOptions {
        latency: Latency {
            least: ms(4),
            ..Latency::NONE
        },
        ..EmulatorOptions::default()
    })
    .unwrap();
    let mut device = open(&emulator);
    println!("round safety stop {:?}", device.round_trip());
    assert!(device.round_trip() >= ms(4));
    let mut last = next(&mut device).time;
    for _ in 0..5 {
        let reading = next(&mut device);
        assert!(reading.time > last);
        assert_eq!(device.read().unwrap_err().kind, DeviceErrorKind::NothingNew);
        last = reading.time;
    }
}

#[test]
fn a_slow_loop_keeps_its_force() {
    // The service would idle after 0.3 s; the loop's orders are 0.4 s apart.
    let emulator = Emulator::start(&EmulatorOptions {
        idle_after: ms(300),
        ..EmulatorOptions::default()
    })
    .unwrap();
    let mut device = Inverse3::open(
        &Inverse3Options {
            pace: Pace {
                hold: ms(2000),
                ..Pace::default()
            },
            ..options(&emulator)
        },
        MonotonicClock::new(),
    )
    .unwrap();
    device.write([1.0, 0.0, 0.0].into()).unwrap();
    wait_until("the force", || emulator.force(ID) == Some([1.0, 0.0, 0.0]));
    for _ in 0..2 {
        std::thread::sleep(ms(400));
        // A busy machine may release the device briefly; an idle service releases it for good.
        wait_until("the force", || emulator.force(ID) == Some([1.0, 0.0, 0.0]));
        next(&mut device);
        device.write([1.0, 0.0, 0.0].into()).unwrap();
    }
}

#[test]
fn a_force_beyond_the_largest_is_shortened_and_one_that_is_none_is_refused() {
    let emulator = emulator(Form::V35);
    let mut device = open(&emulator);
    let given = device.write([0.0, 30.0, -40.0].into()).unwrap().force;
    assert!((given[1] - 6.0).abs() < 1e-12 && (given[2] + 8.0).abs() < 1e-12);
    wait_until("the force", || emulator.force(ID) == Some(given));
    let error = device.write([f64::NAN, 0.0, 0.0].into()).unwrap_err();
    assert_eq!(error.kind, DeviceErrorKind::Refused);
    wait_until("no force", || emulator.force(ID) == Some([0.0; 3]));
}
