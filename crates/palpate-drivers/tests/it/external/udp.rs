//! Packets of a device, with the faults of a network.

use std::net::{SocketAddr, UdpSocket};
use std::thread::{JoinHandle, spawn};
use std::time::Duration;

use palpate_device::clock::MonotonicClock;
use palpate_device::{Device, DeviceErrorKind, Wrench};
use palpate_drivers::external::{External, OpenError, Place};

use super::{TIMES, words};

/// A device that answers each packet by the packets of `answer` and ends with `end`. Returns its address, and the
/// received lines after its end.
fn device(
    mut answer: impl FnMut(&[&str]) -> Vec<String> + Send + 'static,
) -> (SocketAddr, JoinHandle<Vec<String>>) {
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    let address = socket.local_addr().unwrap();
    let thread = spawn(move || {
        let mut heard = Vec::new();
        let mut bytes = [0; 1000];
        loop {
            let (length, from) = socket.recv_from(&mut bytes).unwrap();
            let line = std::str::from_utf8(&bytes[..length])
                .unwrap()
                .trim()
                .to_owned();
            for packet in answer(&words(&line)) {
                // A loop that has ended answers nothing.
                let _ = socket.send_to(packet.as_bytes(), from);
            }
            heard.push(line);
            if heard.last().is_some_and(|line| line == "end") {
                return heard;
            }
        }
    });
    (address, thread)
}

fn opened(address: SocketAddr) -> Result<External<MonotonicClock>, OpenError> {
    External::open(&Place::Udp(address), TIMES, MonotonicClock::new(), |_| {})
}

const INTRODUCTION: &str = "device 1 axes=2 largest_force_n=1.5 name=a plane";

#[test]
fn a_wrench_goes_out_within_the_limits_and_the_session_ends_with_zero() {
    let (address, ended) = device(|words| match words {
        ["hello", "1", ..] => vec![INTRODUCTION.into()],
        ["read", n] => vec![format!("sample {n} {n} {n}e-3 0.01 -0.02\n")],
        _ => vec![],
    });
    let mut device = opened(address).unwrap();
    let can = device.capabilities().clone();
    assert_eq!((can.name.as_str(), can.axes), ("a plane", 2));
    assert!(can.holds_last_force);
    assert_eq!(device.read().unwrap().position, [0.01, -0.02, 0.0]);
    let held = device.write(Wrench::of_force([3.0, 0.0, 9.0])).unwrap();
    assert_eq!(held, Wrench::of_force([1.5, 0.0, 0.0]));
    let refused = device
        .write(Wrench::of_force([f64::NAN, 0.0, 0.0]))
        .unwrap_err();
    assert_eq!(refused.kind, DeviceErrorKind::Refused);
    let found = device.connection().unwrap();
    assert_eq!(
        (found.samples, found.lost + found.late + found.unreadable),
        (1, 0)
    );
    assert!(found.round_trip.is_some());
    drop(device);
    let heard = ended.join().unwrap();
    let force: Vec<&String> = heard
        .iter()
        .filter(|line| line.starts_with("wrench"))
        .collect();
    let values: Vec<_> = force.iter().map(|line| words(line)[2..].to_vec()).collect();
    assert_eq!(values, [["1.5e0", "0e0"], ["0e0", "0e0"], ["0e0", "0e0"]]);
    assert_eq!(heard[heard.len() - 2..], ["zero", "end"]);
}

/// A microcontroller restarts: its system refuses a packet, and the next zero must arrive, as one line.
#[test]
fn a_zero_after_a_refused_packet_arrives_as_one_line() {
    let board = UdpSocket::bind("127.0.0.1:0").unwrap();
    let address = board.local_addr().unwrap();
    let restarts = spawn(move || {
        let mut bytes = [0; 1000];
        loop {
            let (length, from) = board.recv_from(&mut bytes).unwrap();
            let line = std::str::from_utf8(&bytes[..length]).unwrap();
            let answer = match words(line)[..] {
                ["hello", ..] => INTRODUCTION.to_owned(),
                ["read", n] => format!("sample {n} {n} - 0 0"),
                _ => return,
            };
            board.send_to(answer.as_bytes(), from).unwrap();
        }
    });
    let mut device = opened(address).unwrap();
    let force = Wrench::of_force([1.0, 0.0, 0.0]);
    device.write(force).unwrap();
    restarts.join().unwrap();
    let _ = device.write(force);
    let board = UdpSocket::bind(address).unwrap();
    board.set_read_timeout(Some(TIMES.1)).unwrap();
    device.zero_writer().unwrap().write_zero();
    let mut bytes = [0; 1000];
    let length = board.recv(&mut bytes).unwrap();
    assert_eq!(&bytes[..length], b"zero\n");
}

#[test]
fn what_a_network_does_is_counted_and_counts_as_missing() {
    // The answers to the reads of the loop, after those of the opening.
    let mut reads = 0;
    let (address, ended) = device(move |words| match words {
        ["hello", ..] => vec![INTRODUCTION.into()],
        ["read", n] => {
            reads += 1;
            let sample = |number: u64, x: &str| format!("sample {number} {n} - {x} 0");
            match reads {
                // A repetition and an older one arrive before the new one.
                22 => vec![sample(121, "9"), sample(119, "9"), sample(122, "2")],
                23 => vec![
                    "sample".into(),
                    sample(123, "NaN"),
                    "x".repeat(600),
                    sample(124, "3"),
                ],
                24 => vec![format!("sample 125 {} - 9 0", u64::MAX), sample(126, "4")],
                _ => vec![sample(100 + reads, "1")],
            }
        }
        _ => vec![],
    });
    let mut device = opened(address).unwrap();
    let x = [(); 4].map(|()| device.read().unwrap().position[0]);
    assert_eq!(x, [1.0, 2.0, 3.0, 4.0]);
    let found = device.connection().unwrap();
    assert_eq!((found.samples, found.duplicate, found.reordered), (4, 1, 1));
    assert_eq!(found.unreadable, 4);
    drop(device);
    ended.join().unwrap();
}

#[test]
fn a_device_that_sends_by_itself_is_not_asked() {
    let mut number = 0;
    let (address, ended) = device(move |words| match words {
        ["hello", ..] => {
            let mut packets = vec![format!("{INTRODUCTION} two")];
            packets[0] = packets[0].replace("name", "rate_hz=1000 name");
            // Its first samples, of which one is lost.
            packets.extend(
                (1..25)
                    .filter(|n| *n != 7)
                    .map(|n| format!("sample {n} 0 - 0 0")),
            );
            number = 24;
            packets
        }
        ["wrench", n, ..] => {
            number += 2;
            vec![format!("sample {number} {n} - 0.5 0")]
        }
        _ => vec![],
    });
    let mut device = opened(address).unwrap();
    // Of the opening; nothing is new.
    let _ = device.read();
    let mut found = None;
    for _ in 0..3 {
        device.write(Wrench::of_force([0.5, 0.0, 0.0])).unwrap();
        while found.is_none() {
            found = match device.read() {
                Err(error) if error.kind == DeviceErrorKind::NothingNew => None,
                read => Some(read.unwrap()),
            };
            std::thread::yield_now();
        }
        assert_eq!(found.take().unwrap().position[0], 0.5);
    }
    let connection = device.connection().unwrap();
    assert_eq!((connection.samples, connection.lost), (3, 2));
    drop(device);
    let heard = ended.join().unwrap();
    assert!(
        heard.iter().all(|line| !line.starts_with("read")),
        "{heard:?}"
    );
}

#[test]
fn a_device_refuses_with_its_own_words() {
    let mut reads = 0;
    let (address, ended) = device(move |words| match words {
        ["hello", ..] => vec![INTRODUCTION.into()],
        ["read", n] => {
            reads += 1;
            let sample = format!("sample {n} {n} - 0 0");
            if reads == 21 {
                vec!["error the motor is hot".into(), sample]
            } else {
                vec![sample]
            }
        }
        _ => vec![],
    });
    let mut device = opened(address).unwrap();
    assert_eq!(
        device.read().unwrap_err().kind,
        DeviceErrorKind::Interrupted
    );
    assert_eq!(device.reason(), Some("the motor is hot"));
    // It works again.
    while device
        .read()
        .is_err_and(|error| error.kind == DeviceErrorKind::NothingNew)
    {}
    assert!(device.read().is_ok());
    drop(device);
    ended.join().unwrap();
}

/// It waits a second: the time after which a device counts as gone.
#[test]
fn a_silent_device_is_gone() {
    let mut reads = 0;
    let (address, ended) = device(move |words| match words {
        ["hello", ..] => vec![INTRODUCTION.into()],
        ["read", n] => {
            reads += 1;
            if reads > 20 {
                vec![]
            } else {
                vec![format!("sample {n} {n} - 0 0")]
            }
        }
        _ => vec![],
    });
    let ms = Duration::from_millis;
    let place = Place::Udp(address);
    let mut device = External::open(&place, (ms(1), ms(5)), MonotonicClock::new(), |_| {}).unwrap();
    let error = loop {
        match device.read() {
            Ok(_) => panic!("a sample"),
            Err(error) if error.kind == DeviceErrorKind::NothingNew => {}
            Err(error) => break error,
        }
    };
    assert_eq!(error.kind, DeviceErrorKind::Disconnected);
    assert!(device.connection().unwrap().lost > 10);
    drop(device);
    ended.join().unwrap();
}

/// It waits a second: a program that is starting.
#[test]
fn a_port_without_a_program_and_a_wrong_address_are_named() {
    let address = UdpSocket::bind("127.0.0.1:0")
        .unwrap()
        .local_addr()
        .unwrap();
    let error = opened(address).unwrap_err().to_string();
    assert_eq!(
        error,
        format!("udp:{address} refuses packets: no program listens there; start it first")
    );
    let error = Place::udp("127.0.0.1:0").unwrap_err().to_string();
    assert!(error.contains("the port is 0"), "{error}");
    assert!(Place::udp("no.such.host.invalid:5005").is_err());
}

/// It waits two seconds for a first sample.
#[test]
fn the_first_unreadable_line_is_quoted() {
    let (address, _ended) = device(|words| match words {
        ["hello", ..] => vec![INTRODUCTION.into()],
        ["read", n] => vec![format!("sample {n} {n} - 0,01 0")],
        _ => vec![],
    });
    let error = opened(address).unwrap_err().to_string();
    assert!(
        error.contains("- 0,01 0\", but needed is: sample NUMBER N TIME X Y, with finite"),
        "{error}"
    );
}

#[test]
fn a_wrong_answer_is_named() {
    let (address, _ended) = device(|_| vec!["device 7 axes=1".into()]);
    let error = opened(address).unwrap_err().to_string();
    assert!(
        error.contains("version 7 of the protocol; allowed: 1"),
        "{error}"
    );
}
