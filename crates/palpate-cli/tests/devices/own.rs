//! User-defined devices: programs in any language.

#![cfg(unix)]

use std::net::UdpSocket;
use std::path::{Path, PathBuf};
use std::process::{Output, Stdio};
use std::time::{Duration, Instant};

use crate::common::running::{Running, program};
use crate::common::{Folder, experiment_text, number, parse};

/// Longest wait; only a fully loaded machine needs that long.
const PATIENCE: Duration = Duration::from_secs(60);

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("wall.toml", experiment_text("wall"));
    folder
}

fn run(folder: &Folder, device: &str, rest: &str) -> Output {
    let words: Vec<&str> = rest.split_whitespace().collect();
    let mut command = program(folder, "run wall.toml --json --method basic");
    command
        .args(words)
        .args(["--device", device])
        .output()
        .unwrap()
}

/// Returns the command of a device of the shell, 5 mm in the wall, that appends its lines to a file.
fn logging(log: &Path) -> String {
    let script = log.with_extension("sh");
    let text = format!(
        "while read -r word n force; do echo $word $force >> '{log}'; case $word in \
         hello) echo 'device 1 axes=1 largest_force_n=3 name=shell';; \
         read) echo sample $n $n - 0.005;; esac; done; echo gone >> '{log}'",
        log = log.display()
    );
    std::fs::write(&script, text).unwrap();
    format!("process:sh '{}'", script.display())
}

#[track_caller]
fn wait_for(log: &Path, what: &str, is_so: impl Fn(&str) -> bool) -> String {
    let begun = Instant::now();
    loop {
        let text = std::fs::read_to_string(log).unwrap_or_default();
        if is_so(&text) {
            return text;
        }
        assert!(begun.elapsed() < PATIENCE, "waiting for {what}:\n{text}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// The example of the documentation.
#[test]
fn a_python_program_is_a_device_of_a_run() {
    let folder = folder();
    let mine = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/own_device/my_device.py");
    let device = format!(
        "process:python3 '{}'",
        mine.canonicalize().unwrap().display()
    );
    let ran = run(
        &folder,
        &device,
        "--period 0.01 --duration 2 --record own.mcap",
    );
    let said = String::from_utf8(ran.stderr).unwrap();
    assert!(said.contains("my device: the round trip takes"), "{said}");
    let report = parse(&String::from_utf8(ran.stdout).unwrap());
    crate::common::schema::check(&report);
    assert_eq!(report["device"], "my device");
    assert!(number(&report, "peak_force_n") > 0.1);
    let connection = &report["connections"][0];
    assert_eq!(connection["device"], "my device");
    assert!(number(connection, "samples") > 100.0, "{report}");
    assert!(number(&connection["round_trip_s"], "median") > 0.0);
    assert_eq!(report["watchdog"]["on"], true);
    let recorded = folder.json_of_a_loop("info own.mcap");
    assert!(number(&recorded, "ticks") > 100.0);
}

/// A program whose words would control the terminal, with an error that lasts, after more events than are shown.
#[test]
fn the_cause_of_no_force_is_said_without_control_characters() {
    let folder = folder();
    let script = "while read -r word n rest; do case $word in \
         hello) printf 'device 1 axes=1 mass_kg=20 name=\\033[31mred\\n';; \
         read) if [ $n -gt 60 ]; then printf 'error hot\\033[2J\\n'; else echo sample $n $n - 0.005; fi;; \
         esac; done";
    std::fs::write(folder.path("hot.sh"), script).unwrap();
    let mut command = program(&folder, "run wall.toml --method basic --period 0.01");
    let ran = command
        .args(["--duration", "1", "--device", "process:sh hot.sh"])
        .output()
        .unwrap();
    let said = String::from_utf8(ran.stderr).unwrap();
    assert_eq!(ran.status.code(), Some(5), "{said}");
    assert!(
        said.contains("states a mass of 20 kg, but the renderer's model has 0.25 kg"),
        "{said}"
    );
    assert!(
        said.contains("when it ended: the device delivered no new sample, since 0."),
        "{said}"
    );
    assert!(said.contains("s: the device reports an error"), "{said}");
    assert!(said.contains("reported an error: hot\u{fffd}[2J"), "{said}");
    let report = String::from_utf8(ran.stdout).unwrap();
    assert!(!(said + &report).contains('\u{1b}'), "{report}");
    assert!(report.contains("`\u{fffd}[31mred`"), "{report}");
}

/// A device that is silent to the end keeps the time of its last sample: the rate is not that of a shorter run.
#[test]
fn a_recording_that_ends_without_samples_has_the_rate_of_its_loop() {
    let folder = folder();
    let script = "while read -r word n rest; do case $word in \
         hello) echo 'device 1 axes=1 name=silent';; \
         read) if [ $n -le 120 ]; then echo sample $n $n - -0.005; fi;; esac; done";
    std::fs::write(folder.path("silent.sh"), script).unwrap();
    let rest = "--period 0.01 --duration 1.2 --record own.mcap";
    let _ = run(&folder, "process:sh silent.sh", rest);
    let info = folder.json_of_a_loop("info own.mcap");
    let (lasted, duration) = (number(&info, "lasted_s"), number(&info, "duration_s"));
    assert!(lasted > 1.0, "{info}");
    assert!(
        (duration / lasted - 1.0).abs() < 0.05,
        "{duration} s of {lasted} s"
    );
    assert!(
        (number(&info, "rate_hz") / 100.0 - 1.0).abs() < 0.05,
        "{info}"
    );
}

/// The watchdog process has a second handle of the program's input: the program reads zero before its input ends.
#[test]
fn a_killed_or_stopped_run_leaves_no_force() {
    for signal in ["KILL", "STOP"] {
        let folder = folder();
        let log = folder.path("log");
        let device = logging(&log);
        let mut command = program(
            &folder,
            "run wall.toml --method basic --duration inf --period 0.01",
        );
        command.args(["--soft-start", "0", "--device", &device]);
        let mut running = Running::start(command.stdout(Stdio::null()).stderr(Stdio::null()));
        let is_on = |line: &str| line.starts_with("wrench ") && !line.ends_with(" 0e0");
        wait_for(&log, "a force", |text| text.lines().any(is_on));
        running.signal(signal);
        let text = wait_for(&log, "zero", |text| {
            let last_on = text.lines().collect::<Vec<_>>();
            let last_on = last_on.iter().rposition(|line| is_on(line));
            text.lines()
                .skip(last_on.unwrap_or(0))
                .any(|line| line.trim() == "zero")
        });
        assert!(!text.contains("\nend"), "{text}");
        if signal == "STOP" {
            running.signal("KILL");
        }
        running.wait().unwrap();
        wait_for(&log, "the end of its input", |text| {
            text.ends_with("gone\n")
        });
    }
}

/// The watchdog process sends from a socket of its own.
#[test]
fn a_killed_run_sends_zero_to_a_board() {
    let board = UdpSocket::bind("127.0.0.1:0").unwrap();
    board.set_read_timeout(Some(PATIENCE)).unwrap();
    let folder = folder();
    let mut command = program(
        &folder,
        "run wall.toml --method basic --duration inf --period 0.01 --soft-start 0 --device",
    );
    command.arg(format!("udp:{}", board.local_addr().unwrap()));
    let mut running = Running::start(command.stdout(Stdio::null()).stderr(Stdio::null()));
    let mut packet = [0; 256];
    let mut is_on = false;
    loop {
        let (length, from) = match board.recv_from(&mut packet) {
            // A signal: another test's child has ended.
            Err(error) if error.kind() == std::io::ErrorKind::Interrupted => continue,
            received => received.expect("a packet"),
        };
        let line = std::str::from_utf8(&packet[..length]).unwrap().trim();
        let mut words = line.split(' ');
        let answer = match (words.next().unwrap(), words.next()) {
            ("hello", _) => "device 1 axes=1 largest_force_n=3 name=board".to_owned(),
            ("read", Some(number)) => format!("sample {number} {number} - 0.005"),
            ("wrench", _) if !is_on && words.next() == Some("-3e0") => {
                is_on = true;
                running.signal("KILL");
                continue;
            }
            ("zero", _) if is_on => break,
            _ => continue,
        };
        board.send_to(answer.as_bytes(), from).unwrap();
    }
    running.wait().unwrap();
}

#[test]
fn the_session_ends_with_zero_and_the_program() {
    let folder = folder();
    let log = folder.path("log");
    let ran = run(
        &folder,
        &logging(&log),
        "--period 0.01 --duration 0.3 --soft-start 0",
    );
    assert!(!ran.stdout.is_empty());
    let text = std::fs::read_to_string(log).unwrap();
    let lines: Vec<&str> = text
        .lines()
        .map(str::trim)
        .filter(|line| !line.is_empty())
        .collect();
    assert_eq!(
        lines[lines.len() - 4..],
        ["wrench 0e0", "zero", "end", "gone"]
    );
    // 5 mm in a wall, within the device's limit.
    assert!(lines.contains(&"wrench -3e0"), "{text}");
}

#[test]
fn a_program_that_dies_is_a_lost_device() {
    let folder = folder();
    let script = "n=0; while read -r word n rest; do case $word in \
                  hello) echo 'device 1 axes=1';; \
                  read) if [ $n -gt 60 ]; then exit 7; fi; echo sample $n $n - 0;; esac; done";
    folder.write("dies.sh", script);
    let ran = run(&folder, "process:sh dies.sh", "--period 0.01 --duration 20");
    let said = String::from_utf8(ran.stderr).unwrap();
    assert_eq!(ran.status.code(), Some(1), "{said}");
    assert!(
        said.contains("the program of the device has ended: exit status: 7"),
        "{said}"
    );
}

#[test]
fn wrong_devices_are_named() {
    let folder = folder();
    for (device, rest, code, words) in [
        ("process:", "", 2, "process:\"python my_device.py\""),
        ("process:'a b", "", 2, "the quote ' is not closed"),
        (
            "process:/no/such/program",
            "",
            1,
            "/no/such/program cannot be started",
        ),
        (
            "process:false",
            "",
            1,
            "has ended before it answered `hello`: exit status: 1",
        ),
        (
            "left=process:sh dies.sh",
            "",
            2,
            "--device 'left=process:\"COMMAND\" FLAGS'",
        ),
        (
            "left=process:\"sh dies.sh\" --normal 1,0",
            "",
            2,
            "this command takes one device",
        ),
        ("udp:nowhere", "", 2, "udp:127.0.0.1:5005"),
        ("udp:192.0.2.1:5005", "", 2, "--allow-remote permits it"),
        (
            "null",
            "--allow-remote",
            2,
            "--allow-remote is for --device udp",
        ),
        ("plugin:", "", 2, "plugin:./libmine.so"),
        (
            "plugin:no/such.so",
            "",
            1,
            "the plug-in no/such.so: no/such.so: cannot open",
        ),
        ("plugin:x", "--reconnect", 2, "devices that can be lost"),
        (
            "process:true",
            "--fast",
            2,
            "--fast is for devices without a motor",
        ),
        (
            "process:true",
            "--port /dev/ttyACM0",
            2,
            "--port is for --device haply-2diy",
        ),
        (
            "simulated",
            "--watchdog off",
            2,
            "haply-2diy, process and udp",
        ),
    ] {
        let ran = run(&folder, device, rest);
        let said = String::from_utf8(ran.stderr).unwrap();
        assert_eq!(ran.status.code(), Some(code), "{device}: {said}");
        assert!(said.contains(words), "{device}: {said}");
    }
}

/// The example in C of the documentation.
#[test]
fn a_shared_library_is_a_device_of_a_run() {
    let folder = folder();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let made = std::process::Command::new("cc")
        .args(["-shared", "-fPIC", "-o", "libmine.so", "-I"])
        .arg(root.canonicalize().unwrap().join("bindings/c/include"))
        .arg(
            root.canonicalize()
                .unwrap()
                .join("examples/own_device/my_device.c"),
        )
        .current_dir(folder.path("."))
        .status();
    assert!(made.unwrap().success());
    let ran = run(
        &folder,
        "plugin:libmine.so",
        "--duration 1 --record own.mcap",
    );
    let said = String::from_utf8(ran.stderr).unwrap();
    let report = parse(&String::from_utf8(ran.stdout).unwrap());
    crate::common::schema::check(&report);
    assert_eq!(report["device"], "my device", "{said}");
    // 5 mm in a wall of 1 N/mm, against a spring of 0.5 N/mm.
    assert!(number(&report, "peak_force_n") > 1.0);
    assert!(number(&folder.json_of_a_loop("info own.mcap"), "ticks") > 100.0);
}

/// A device of a world takes its command in the quotes of its name.
#[test]
fn a_device_of_a_world_may_be_a_program() {
    let folder = Folder::new();
    let world = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("experiments/worlds/paddle.toml");
    folder.write("paddle.toml", std::fs::read_to_string(world).unwrap());
    let script = "while read -r word n rest; do case $word in \
                  hello) echo 'device 1 axes=3 name=shell';; \
                  read) echo sample $n $n - 0 0 0.02;; esac; done";
    folder.write("my device.sh", script);
    let mut command = program(&folder, "run paddle.toml --json --duration 0.3");
    let ran = command
        .args(["--device", "process:sh 'my device.sh'"])
        .output()
        .unwrap();
    let report = String::from_utf8(ran.stdout).unwrap();
    assert!(
        !report.is_empty(),
        "{}",
        String::from_utf8_lossy(&ran.stderr)
    );
    let report = parse(&report);
    assert_eq!(report["device"], "shell");
    assert!(number(&report["connections"][0], "samples") > 0.0);
}
