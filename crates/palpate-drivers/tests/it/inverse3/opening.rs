//! Finding the service and the device, and the remedies in the errors.

use std::io::Write;
use std::net::{Ipv6Addr, TcpListener};

use palpate_device::clock::MonotonicClock;
use palpate_drivers::emulator::inverse3::{Body, Emulator, EmulatorOptions};
use palpate_drivers::inverse3::{Form, Found, Inverse3, Inverse3Options, Unfit, devices};

use crate::inverse3::{ID, emulator, ms, options, wait_until};

fn refused(options: &Inverse3Options) -> String {
    Inverse3::open(options, MonotonicClock::new())
        .unwrap_err()
        .to_string()
}

#[test]
fn a_service_that_is_not_there_is_said_to_be_so() {
    let port = {
        let gone = TcpListener::bind("127.0.0.1:0").unwrap();
        gone.local_addr().unwrap().port()
    };
    let said = refused(&Inverse3Options {
        service: format!("ws://127.0.0.1:{port}"),
        ..Inverse3Options::default()
    });
    assert!(
        said.contains("no answer from") && said.contains("palpate devices emulate"),
        "{said}"
    );
}

#[test]
fn somebody_else_who_answers_is_no_service() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let answering = std::thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        stream
            .write_all(b"HTTP/1.1 200 OK\r\nContent-Length: 0\r\n\r\n")
            .unwrap();
        // Until the other end has read enough.
        let _ = std::io::Read::read_to_end(&mut stream, &mut Vec::new());
    });
    let said = refused(&Inverse3Options {
        service: address.to_string(),
        ..Inverse3Options::default()
    });
    assert!(said.contains("is not an Inverse Service"), "{said}");
    answering.join().unwrap();
}

#[test]
fn one_who_says_nothing_is_not_waited_for() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let said = refused(&Inverse3Options {
        service: listener.local_addr().unwrap().to_string(),
        patience: ms(50),
        ..Inverse3Options::default()
    });
    assert!(said.contains("no answer within 0.05 s"), "{said}");
}

#[test]
fn of_several_devices_one_has_to_be_chosen() {
    let emulator = Emulator::start(&EmulatorOptions {
        device_ids: vec!["049D".into(), "04BA".into()],
        ..EmulatorOptions::default()
    })
    .unwrap();
    let mut asked = options(&emulator);
    let said = refused(&asked);
    assert!(
        said.contains("049D, 04BA") && said.contains("--device-id"),
        "{said}"
    );
    asked.device_id = Some("049E".into());
    let said = refused(&asked);
    assert!(
        said.contains("no device 049E") && said.contains("049D, 04BA"),
        "{said}"
    );
    asked.device_id = Some("04BA".into());
    let mut device = Inverse3::open(&asked, MonotonicClock::new()).unwrap();
    palpate_device::Device::write(&mut device, [1.0, 0.0, 0.0].into()).unwrap();
    wait_until("the force", || {
        emulator.force("04BA") == Some([1.0, 0.0, 0.0])
    });
    assert_eq!(emulator.force("049D"), Some([0.0; 3]));
    let found = devices(&emulator.url(), ms(1000)).unwrap();
    let of = |id: &str| Found {
        device_id: id.into(),
        model: "inverse3".into(),
        unfit: None,
    };
    assert_eq!(found, [of("049D"), of("04BA")]);
}

#[test]
fn a_service_without_devices_says_so() {
    let emulator = emulator(Form::V35);
    emulator.set_present(ID, false);
    assert!(refused(&options(&emulator)).contains("has no Inverse3: plug one in"));
    assert_eq!(devices(&emulator.url(), ms(1000)).unwrap(), []);
}

#[test]
fn a_device_that_is_not_ready_is_waited_for_and_then_refused() {
    let emulator = emulator(Form::V31);
    emulator.set_status(ID, |status| status.calibrated = Some(false));
    let asked = Inverse3Options {
        patience: ms(200),
        ..options(&emulator)
    };
    let said = refused(&asked);
    assert!(
        said.contains("device 049D") && said.contains("calibration pose"),
        "{said}"
    );
    let found = devices(&emulator.url(), ms(1000)).unwrap();
    assert_eq!(found[0].unfit, Some(Unfit::NotCalibrated));
    // No device was commanded before.
    assert_eq!(emulator.served().messages, 0);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            std::thread::sleep(ms(100));
            emulator.set_status(ID, |status| status.calibrated = Some(true));
        });
        let patient = Inverse3Options {
            patience: ms(5000),
            ..options(&emulator)
        };
        Inverse3::open(&patient, MonotonicClock::new()).unwrap();
    });
}

#[test]
fn a_name_of_this_machine_will_do() {
    // If the name resolves to ::1 first, no server answers there, and 127.0.0.1 is next.
    let emulator = emulator(Form::V35);
    let port = emulator.address().port();
    let asked = Inverse3Options {
        service: format!("localhost:{port}"),
        ..Inverse3Options::default()
    };
    let device = Inverse3::open(&asked, MonotonicClock::new()).unwrap();
    assert_eq!(device.opened_at(), [0.0; 3]);
}

#[test]
fn an_address_of_ipv6_is_gone_to() {
    let Ok(listener) = TcpListener::bind((Ipv6Addr::LOCALHOST, 0)) else {
        println!("SKIPPED, NOT SHOWN ON THIS MACHINE: it has no IPv6");
        return;
    };
    let asked = Inverse3Options {
        service: format!("ws://{}", listener.local_addr().unwrap()),
        patience: ms(50),
        ..Inverse3Options::default()
    };
    let said = refused(&asked);
    assert!(
        said.contains("ws://[::1]:") && said.contains("no answer within"),
        "{said}"
    );
}

#[test]
fn an_emulator_says_which_port_is_taken_and_which_quantity_is_wrong() {
    let taken = emulator(Form::V35);
    let port = taken.address().port();
    let second = Emulator::start(&EmulatorOptions {
        port,
        ..EmulatorOptions::default()
    });
    assert!(
        second
            .unwrap_err()
            .to_string()
            .starts_with(&format!("port {port}: "))
    );
    let weightless = Emulator::start(&EmulatorOptions {
        body: Body {
            mass: 0.0,
            ..Body::default()
        },
        ..EmulatorOptions::default()
    });
    assert!(weightless.unwrap_err().to_string().contains("mass"));
}
