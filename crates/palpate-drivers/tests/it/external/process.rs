//! Programs of devices, here of the shell.

use std::process::Command;
use std::sync::mpsc::channel;
use std::time::Duration;

use palpate_device::clock::MonotonicClock;
use palpate_device::{Device, DeviceErrorKind, Wrench};
use palpate_drivers::external::{External, OpenError, Place};

use super::TIMES;

/// Opens a device that the shell runs; `read` is its command for a request of a sample.
fn opened(
    read: &str,
    tell: impl FnOnce(String) + Send + 'static,
) -> Result<External<MonotonicClock>, OpenError> {
    let script = format!(
        "while read -r word n rest; do case $word in \
         hello) echo 'device 1 axes=1 name=shell';; \
         read) {read};; \
         end) exit 3;; esac; done"
    );
    run(&["sh", "-c", &script], tell)
}

fn run(
    words: &[&str],
    tell: impl FnOnce(String) + Send + 'static,
) -> Result<External<MonotonicClock>, OpenError> {
    let words = words.iter().map(|word| (*word).to_owned()).collect();
    External::open(&Place::Process(words), TIMES, MonotonicClock::new(), tell)
}

#[test]
fn a_program_is_a_device_and_ends_with_zero() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("log");
    let script = format!(
        "while read -r word n rest; do echo $word $rest >> '{}'; case $word in \
         hello) echo 'device 1 axes=1 name=shell';; \
         read) echo sample $n $n - 0.02;; esac; done",
        log.display()
    );
    let mut device = run(&["sh", "-c", &script], |_| {}).unwrap();
    assert_eq!(device.capabilities().name, "shell");
    assert_eq!(device.read().unwrap().position, [0.02, 0.0, 0.0]);
    assert_eq!(
        device.write(Wrench::of_force([1.0, 2.0, 0.0])),
        Ok(Wrench::of_force([1.0, 0.0, 0.0]))
    );
    device.zero_writer().unwrap().write_zero();
    // Its end is that of the program.
    drop(device);
    let log = std::fs::read_to_string(log).unwrap();
    let commands: Vec<&str> = log
        .lines()
        .filter(|line| !line.starts_with("read") && !line.is_empty() && !line.starts_with("hello"))
        .map(str::trim)
        .filter(|line| !line.is_empty())
        .collect();
    assert_eq!(
        commands,
        ["wrench 1e0", "zero", "wrench 0e0", "zero", "end"]
    );
}

#[test]
fn a_program_that_ends_is_a_lost_device_and_its_status_is_said() {
    let (told, hears) = channel();
    let tell = move |text| told.send(text).unwrap();
    let read = "if [ $n -gt 20 ]; then exit 7; fi; echo sample $n $n - 0";
    let mut device = opened(read, tell).unwrap();
    let error = device.read().unwrap_err();
    assert_eq!(error.kind, DeviceErrorKind::Disconnected);
    assert_eq!(
        device.write(Wrench::NONE).unwrap_err().kind,
        DeviceErrorKind::Disconnected
    );
    drop(device);
    let said = hears.recv().unwrap();
    assert!(said.contains("has ended: exit status: 7"), "{said}");
}

#[test]
fn the_words_of_a_device_that_refuses_are_said() {
    let (told, hears) = channel();
    let tell = move |text| told.send(text).unwrap();
    let read = "if [ $n = 21 ]; then echo error the motor is hot; fi; echo sample $n $n - 0";
    let mut device = opened(read, tell).unwrap();
    assert_eq!(
        device.read().unwrap_err().kind,
        DeviceErrorKind::Interrupted
    );
    drop(device);
    assert_eq!(
        hears.try_recv().unwrap(),
        "the device reported an error: the motor is hot"
    );
}

/// The program hangs until its pipe is full, then reads and answers again. The device recovers.
#[test]
fn a_program_that_does_not_read_for_a_while_recovers() {
    let folder = tempfile::tempdir().unwrap();
    let gate = folder.path().join("gate");
    let made = Command::new("mkfifo").arg(&gate).status();
    assert!(made.unwrap().success());
    let read = format!(
        "if [ $n = 21 ]; then read line < '{}'; fi; echo sample $n $n - 0",
        gate.display()
    );
    let mut device = opened(&read, |_| {}).unwrap();
    let missing = device.read().unwrap_err();
    assert_eq!(missing.kind, DeviceErrorKind::NothingNew);
    let push = Wrench::of_force([1.0, 0.0, 0.0]);
    let untaken = std::iter::repeat_with(|| device.write(push)).find_map(Result::err);
    assert_eq!(untaken.unwrap().kind, DeviceErrorKind::Interrupted);
    std::fs::write(&gate, "open\n").unwrap();
    // It reads what is in its pipe, and the pipe has room again.
    while let Err(error) = device.write(push) {
        assert_eq!(error.kind, DeviceErrorKind::Interrupted, "{error}");
    }
    while let Err(error) = device.read() {
        assert_eq!(error.kind, DeviceErrorKind::NothingNew, "{error}");
    }
}

#[test]
fn what_a_killed_program_has_started_is_killed_too() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe");
    let made = Command::new("mkfifo").arg(&pipe).status();
    assert!(made.unwrap().success());
    let script = format!(
        "exec 3> '{}'; sleep 60 & echo ready; read line; read line",
        pipe.display()
    );
    let (closes, closed) = channel();
    std::thread::spawn(move || closes.send(std::fs::read(pipe)));
    run(&["sh", "-c", &script], |_| {}).unwrap_err();
    // The last of them has closed the pipe.
    let ended = closed.recv_timeout(Duration::from_secs(20));
    assert!(ended.unwrap().unwrap().is_empty());
}

#[test]
fn lines_that_are_no_samples_are_counted() {
    let long = "x".repeat(5000);
    let read = format!("echo debug; echo {long}; echo; echo sample $n $n - 0");
    let mut device = opened(&read, |_| {}).unwrap();
    device.read().unwrap();
    device.read().unwrap();
    assert_eq!(device.connection().unwrap().unreadable, 4);
}

#[test]
fn a_program_that_is_none_is_named() {
    let error = run(&["/no/such/program"], |_| {}).unwrap_err().to_string();
    assert!(
        error.contains("/no/such/program cannot be started"),
        "{error}"
    );
    let error = run(&["sh", "-c", "exit 9"], |_| {})
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("before it answered `hello`: exit status: 9"),
        "{error}"
    );
    let error = run(&["sh", "-c", "echo ready; read line"], |_| {}).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("answers \"ready\"; needed: device 1"),
        "{error}"
    );
    let read = "echo error no motor";
    let error = opened(read, |_| {}).unwrap_err().to_string();
    assert!(error.contains("reports an error: no motor"), "{error}");
}
