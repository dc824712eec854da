//! The program on an emulated Haply 2DIY.
//!
//! Its port is a Unix socket: a kernel worker forwards the bytes of a terminal, and beside busy loops that worker may
//! be a second late (`docs/realtime.md`). The driver's own tests use a terminal.

#![cfg(unix)]

use std::io::{BufRead, BufReader, Read, Write};
use std::process::{ChildStderr, ChildStdout, Stdio};
use std::time::{Duration, Instant};

use crate::common::running::{Running, program};
use crate::common::{Answer, Folder, experiment_text, number, parse};
use palpate_drivers::emulator::port::PortSettings;
use palpate_drivers::emulator::two_diy::{Emulator, Fault, Hand, Settings};
use palpate_drivers::two_diy::{Board, Generation};
use palpate_record::recording::{Entry, Recording};

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("wall.toml", experiment_text("wall"));
    folder
}

/// `palpate devices emulate haply-2diy`, with its port as `haply` in the folder.
struct Emulated {
    child: Running,
    said: ChildStderr,
}

fn started(folder: &Folder, arguments: &str) -> Running {
    let mut program = program(folder, arguments);
    Running::start(program.stdout(Stdio::null()).stderr(Stdio::piped()))
}

/// Longer than any wait here, on a busy machine too.
const PATIENCE: Duration = Duration::from_secs(120);

fn wait_for(what: &str, mut is_so: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !is_so() {
        assert!(begun.elapsed() < PATIENCE, "{what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Whether a running recording has flushed such an entry.
fn has_recorded(folder: &Folder, part: &str, is_it: impl Fn(&Entry) -> bool) -> bool {
    Recording::open(&folder.path(part)).is_ok_and(|recording| {
        let mut entries = recording.entries().unwrap();
        entries.any(|entry| entry.is_ok_and(|entry| is_it(&entry)))
    })
}

impl Emulated {
    fn start(folder: &Folder, flags: &str) -> Self {
        let mut child = started(
            folder,
            &format!("devices emulate haply-2diy --socket haply{flags}"),
        );
        wait_for("no port", || folder.path("haply").exists());
        let said = child.stderr.take().unwrap();
        Self { child, said }
    }

    /// Ends the emulator. Returns its output.
    fn end(mut self) -> String {
        self.child.signal("INT");
        assert!(self.child.wait().unwrap().success());
        let mut said = String::new();
        self.said.read_to_string(&mut said).unwrap();
        said
    }
}

/// An emulator in this program, for injecting faults.
fn emulator(folder: &Folder) -> Emulator {
    let settings = Settings {
        angles: Some([130.0, 50.0]),
        hand: Hand::at([0.019, 0.1169]),
        hand_waits: true,
        port: PortSettings::Socket {
            path: folder.path("haply"),
        },
        ..Settings::new(Generation::Three, Board::M0)
    };
    Emulator::start(&settings).unwrap()
}

fn presses(emulator: &Emulator) {
    wait_for("no torque", || emulator.torques() != [0.0; 2]);
}

/// A program whose messages are read as they appear.
struct Message {
    child: Running,
    lines: std::io::Lines<BufReader<ChildStderr>>,
    /// Its messages so far.
    said: String,
}

impl Message {
    fn start(program: &mut std::process::Command) -> Self {
        let program = program.stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = Running::start(program);
        let lines = BufReader::new(child.stderr.take().unwrap()).lines();
        Self {
            child,
            lines,
            said: String::new(),
        }
    }

    /// Waits for the message `words`.
    fn hear(&mut self, words: &str) {
        self.hear_before(words, None);
    }

    /// Waits for the message `words`, which has to precede `later`.
    fn hear_before(&mut self, words: &str, later: Option<&str>) {
        loop {
            let line = self.lines.next();
            let line = line.unwrap_or_else(|| panic!("it ended without {words}: {}", self.said));
            let line = line.unwrap();
            self.said += &(line.clone() + "\n");
            if line.contains(words) {
                return;
            }
            let is_late = later.is_some_and(|later| line.contains(later));
            assert!(!is_late, "not a word of {words}: {}", self.said);
        }
    }

    /// Waits for its end. Returns code, standard output, and all messages.
    fn end(mut self) -> (Option<i32>, String, String) {
        // Read standard output concurrently: the report of a loop that was often late exceeds the buffer of a pipe, and
        // the program would block.
        let mut stdout: ChildStdout = self.child.stdout.take().unwrap();
        let report = std::thread::spawn(move || {
            let mut output = String::new();
            stdout.read_to_string(&mut output).unwrap();
            output
        });
        for line in &mut self.lines {
            self.said += &(line.unwrap() + "\n");
        }
        let output = report.join().unwrap();
        (self.child.wait().unwrap().code(), output, self.said)
    }
}

const DEVICE: &str = "--device haply-2diy --port haply --start-pose 130,50 --priority 0";
const RECONNECT: &str = "--reconnect --reconnect-in-start-pose";
/// At the middle of the workspace; moves into a wall 8 mm away and out again.
const HAND: &str = " --angles 130,50 --hold 0.019,0.1169 --sway 0,0.012 --sway-period 0.4";
const WALL: &str =
    "--origin 0.019,0.11 --normal 0,1 --stiffness 300 --method basic --stall-after-periods 50";

#[test]
fn a_wall_is_felt_recorded_and_read_back() {
    let folder = folder();
    let emulated = Emulated::start(&folder, HAND);
    let record = format!("run wall.toml --record tap.mcap {DEVICE} {WALL} --duration 1.5 --json");
    let answer = folder.palpate(&record);
    assert_eq!(answer.code, 0, "{answer:?}");
    let report = parse(&answer.stdout);
    assert_eq!(report["device"], "Haply 2DIY, generation 3, board m0");
    assert!(number(&report, "peak_force_n") > 0.3, "{report}");
    assert!(number(&report, "deepest_penetration_m") > 0.001, "{report}");
    let said = emulated.end();
    assert!(said.contains("in the end 0 and 0"), "{said}");
    folder.succeed("convert tap.mcap");
    let table = folder.read("tap.csv");
    let info = parse(&folder.succeed("info tap.mcap --json"));
    let rows = table.lines().count() - 1;
    assert!(rows > 0 && number(&info, "ticks") == rows as f64, "{info}");
    // A busy machine misses deadlines, and the run includes those periods.
    let periods = |name: &str| number(&report["timing"], name);
    let whole = periods("ticks") + periods("missed_deadlines");
    assert!(whole >= 1500.0, "{report}");
    assert_eq!(info["events"]["ended"], 1);
}

#[test]
fn a_run_that_is_terminated_leaves_no_torque() {
    let folder = folder();
    let emulated = Emulated::start(&folder, " --angles 130,50 --hold 0.019,0.1169");
    let mut run = started(
        &folder,
        &format!("run wall.toml {DEVICE} {WALL} --duration inf --record run.mcap"),
    );
    wait_for("no force", || {
        has_recorded(
            &folder,
            "run.mcap.part",
            |entry| matches!(entry, Entry::Tick(_, contacts, _, _) if contacts[0].force_on_device.abs() > 0.5),
        )
    });
    run.signal("TERM");
    assert!(run.wait().unwrap().success());
    let said = emulated.end();
    assert!(said.contains("in the end 0 and 0"), "{said}");
    assert!(!said.contains("up to 0.000"), "{said}");
}

/// The board holds its torque, which only this warning reveals.
#[test]
fn output_that_could_not_be_disabled_causes_warning() {
    let folder = folder();
    let emulator = emulator(&folder);
    let run = format!("run wall.toml {DEVICE} {WALL} --duration inf");
    let run = Message::start(&mut program(&folder, &run));
    presses(&emulator);
    emulator.inject_faults(Fault::Stall(Duration::from_secs(60)));
    wait_for("it does not stand still", || emulator.has_injected_fault());
    run.child.signal("INT");
    let (_, _, said) = run.end();
    assert!(
        said.contains("warning: the output of the 2DIY could not be disabled")
            && said.contains("last torque")
            && said.contains("switch its motors off"),
        "{said}"
    );
}

#[test]
fn a_cable_that_is_pulled_ends_a_run_with_a_word() {
    let folder = folder();
    let emulator = emulator(&folder);
    let run = format!("run wall.toml {DEVICE} {WALL} --json --duration inf");
    let run = Message::start(&mut program(&folder, &run));
    presses(&emulator);
    emulator.inject_faults(Fault::Unplug(Duration::from_secs(60)));
    let (code, output, said) = run.end();
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("the device was lost"), "{said}");
    assert!(said.contains("switch its motors off"), "{said}");
    let report = parse(&output);
    assert_eq!(report["safety_stop"], "device-lost");
    assert!(
        report["events"].to_string().contains("port is gone"),
        "{report}"
    );
}

#[test]
fn a_cable_that_is_pulled_is_waited_for() {
    let folder = folder();
    let emulator = emulator(&folder);
    let run = format!(
        "run wall.toml --record back.mcap {DEVICE} {WALL} --json --duration inf {RECONNECT}"
    );
    let mut run = Message::start(&mut program(&folder, &run));
    presses(&emulator);
    emulator.inject_faults(Fault::Unplug(Duration::from_millis(300)));
    run.hear("the device is gone");
    run.hear("the device is back");
    wait_for("it does not recover", || has_recovered(&folder));
    run.child.signal("TERM");
    let (code, output, said) = run.end();
    // 5 if the motors were off for most of the time, which depends on the wait here.
    assert!(matches!(code, Some(0 | 5)), "{code:?}: {said}");
    assert!(!said.contains("could not be disabled"), "{said}");
    let report = parse(&output);
    assert!(
        report["events"].to_string().contains("recovered"),
        "{report}"
    );
}

/// A board that is silent for less than half of a run, but at its end: a self-clearing safety stop that has not
/// cleared.
///
/// Such a stop lasts for a second at most: then the board is lost, which ends a run differently. A run that was ended
/// too early or too late is repeated.
#[test]
fn a_run_that_ends_beside_a_silent_board_has_the_exit_code_of_motors_that_are_off() {
    let begun = Instant::now();
    let mut codes = Vec::new();
    while !codes.ends_with(&[Some(5)]) {
        assert!(begun.elapsed() < PATIENCE, "{codes:?}");
        codes.push(ends_beside_a_silent_board());
    }
}

/// Returns the exit code of a run that is ended when its board has been silent for half a second or longer.
fn ends_beside_a_silent_board() -> Option<i32> {
    let folder = folder();
    let emulator = emulator(&folder);
    let run = format!("run wall.toml --record silent.mcap {DEVICE} {WALL} --json --duration inf");
    let run = Message::start(&mut program(&folder, &run));
    presses(&emulator);
    wait_for("it does not run", || {
        Recording::open(&folder.path("silent.mcap.part")).is_ok_and(|recording| {
            let mut rows = recording.rows().unwrap();
            rows.any(|row| row.is_ok_and(|row| row.tick.time > 2.0))
        })
    });
    emulator.inject_faults(Fault::Stall(Duration::from_secs(60)));
    std::thread::sleep(Duration::from_millis(500));
    run.child.signal("TERM");
    let (code, output, said) = run.end();
    let report = parse(&output);
    if code == Some(5) {
        assert_eq!(report["safety_stop"], "stale-sample", "{said}");
        assert!(said.contains("when it ended: "), "{said}");
        let [off, all] = ["motors_off_s", "lasted_s"].map(|key| number(&report, key));
        assert!(off > 0.1 && off < 0.5 * all, "{off} of {all} s");
    } else if code == Some(1) {
        assert_eq!(report["safety_stop"], "device-lost", "{said}");
    } else {
        assert_eq!(code, Some(0), "{said}");
        assert!(!said.contains("when it ended: "), "{said}");
    }
    code
}

/// Whether the running recording `back.mcap` has the event.
fn has_recovered(folder: &Folder) -> bool {
    has_recorded(
        folder,
        "back.mcap.part",
        |entry| matches!(entry, Entry::Event(event) if event.kind.contains("recovered")),
    )
}

/// Returns the number of open sockets of a program: its port and that of its watchdog process, and none without a
/// device.
#[cfg(target_os = "linux")]
fn sockets(child: &Running) -> usize {
    std::fs::read_dir(format!("/proc/{}/fd", child.id()))
        .unwrap()
        .filter_map(|entry| std::fs::read_link(entry.ok()?.path()).ok())
        .filter(|to| to.to_string_lossy().starts_with("socket:"))
        .count()
}

#[cfg(target_os = "linux")]
#[test]
fn a_port_that_is_gone_is_not_held_open_while_it_is_waited_for() {
    // Unplugged, or silent: a silent board can be opened only after it was closed. It stays silent as long as it is
    // probed, so the expected state recurs.
    let long = Duration::from_secs(600);
    for (fault, is_there) in [(Fault::Unplug(long), false), (Fault::Stall(long), true)] {
        let folder = folder();
        let emulator = emulator(&folder);
        let mut run = started(
            &folder,
            &format!("run wall.toml {DEVICE} {WALL} --duration inf {RECONNECT}"),
        );
        presses(&emulator);
        emulator.inject_faults(fault);
        let begun = Instant::now();
        while sockets(&run) > 0 {
            if begun.elapsed() > PATIENCE {
                run.signal("KILL");
                let mut said = String::new();
                run.stderr
                    .take()
                    .unwrap()
                    .read_to_string(&mut said)
                    .unwrap();
                panic!("the port is there: {is_there}, and held open: {said}");
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        assert_eq!(folder.path("haply").exists(), is_there);
        if is_there {
            wait_for("it is not opened anew", || sockets(&run) > 0);
        }
        run.signal("TERM");
        // 5 if the motors were off for most of the ticks, which depends on the wait here.
        let code = run.wait().unwrap().code();
        assert!(matches!(code, Some(0 | 5)), "{code:?}");
    }
}

/// Returns a terminal as a program's input, and its keyboard end.
fn terminal() -> (std::fs::File, std::os::fd::OwnedFd) {
    use rustix::fs::{Mode, OFlags};
    use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
    let keys = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
    grantpt(&keys).unwrap();
    unlockpt(&keys).unwrap();
    let name = ptsname(&keys, Vec::new()).unwrap();
    let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
    let input = rustix::fs::open(name, flags, Mode::empty()).unwrap();
    (std::fs::File::from(keys), input)
}

#[test]
fn no_force_comes_back_before_enter_has_said_that_the_arm_is_in_its_start_pose() {
    let folder = folder();
    let emulator = emulator(&folder);
    let (mut keys, input) = terminal();
    let run = format!(
        "run wall.toml --record back.mcap {DEVICE} {WALL} --duration inf --reconnect --json"
    );
    let mut run = Message::start(program(&folder, &run).stdin(input));
    presses(&emulator);
    // Earlier input is ignored.
    keys.write_all(b"\n").unwrap();
    emulator.inject_faults(Fault::Unplug(Duration::from_millis(300)));
    let back = "the device is back";
    run.hear_before("press enter", Some(back));
    let asked = Instant::now();
    let typing = std::thread::spawn(move || {
        std::thread::sleep(Duration::from_secs(5));
        keys.write_all(b"\n").unwrap();
        keys
    });
    run.hear(back);
    assert!(
        asked.elapsed() > Duration::from_secs(5),
        "nobody was waited for"
    );
    let keys = typing.join().unwrap();
    wait_for("it does not recover", || has_recovered(&folder));
    run.child.signal("TERM");
    let (_, output, _) = run.end();
    drop(keys);
    let report = parse(&output);
    assert!(
        report["events"].to_string().contains("recovered"),
        "{report}"
    );
}

#[test]
fn motors_are_checked_when_the_arm_may_move() {
    let folder = folder();
    let check = "devices check haply-2diy --port haply";
    let emulated = Emulated::start(&folder, "");
    folder.fail(check, 2, &["moves the arm", "--move"]);
    let text = folder.succeed(&format!("{check} --move"));
    assert_eq!(text.matches("the right way").count(), 2, "{text}");
    emulated.end();
    let emulated = Emulated::start(&folder, " --wiring reversed-2");
    let answer = folder.palpate(&format!("{check} --move --json"));
    assert_eq!(answer.code, 1, "{answer:?}");
    let report = parse(&answer.stdout);
    crate::common::schema::check(&report);
    assert_eq!(report["motors"][0]["verdict"], "fine");
    assert_eq!(report["motors"][1]["verdict"], "reversed");
    emulated.end();
}

#[test]
fn a_check_that_is_terminated_leaves_no_torque() {
    // Rests of 250 ms and pulses of 80 ms alternate, without a visible sign. The signal comes later in each try until
    // it has hit a pulse or its end.
    let names = ["TERM", "HUP", "INT"];
    for (tries, name) in names.iter().cycle().enumerate() {
        assert!(tries < 60, "every signal came before the first pulse");
        let after = 500 + 80 * tries as u64;
        let folder = folder();
        let flags = " --angles 130,50 --hold 0.019,0.1169 --hand-stiffness 2000";
        let emulated = Emulated::start(&folder, flags);
        let mut check = started(
            &folder,
            "devices check haply-2diy --port haply --start-pose 130,50 --move",
        );
        std::thread::sleep(Duration::from_millis(after));
        check.signal(name);
        let code = check.wait().unwrap().code();
        assert_eq!(code, Some(130), "{name} after {after} ms");
        let said = emulated.end();
        assert!(
            said.contains("in the end 0 and 0"),
            "after {after} ms: {said}"
        );
        if tries >= 3 && !said.contains("up to 0.000") {
            break;
        }
    }
}

#[test]
fn what_does_not_belong_to_the_2diy_or_to_another_device_is_named() {
    let folder = folder();
    let device = "run wall.toml --device haply-2diy";
    for (run, code, words) in [
        (
            "run wall.toml --port haply",
            2,
            ["--port", "--device haply-2diy"],
        ),
        (
            "run wall.toml --reconnect",
            2,
            ["--reconnect", "haply-2diy"],
        ),
        (
            &format!("{device} --port no-such --reconnect"),
            2,
            ["enter", "--reconnect-in-start-pose"],
        ),
        (
            &format!("{device} --port no-such --reconnect-in-start-pose"),
            2,
            ["--reconnect", "required"],
        ),
        (
            "run wall.toml --device inverse3 --reconnect --reconnect-in-start-pose",
            2,
            ["--reconnect-in-start-pose", "--device haply-2diy"],
        ),
        (
            &format!("{device} --port no-such"),
            1,
            ["no-such", "no such port"],
        ),
        (
            &format!("{device} --port wall.toml"),
            1,
            ["wall.toml", "not a serial port"],
        ),
        (
            &format!("{device} --port haply --fast"),
            2,
            ["--fast", "motor"],
        ),
        (
            &format!("{device} --generation 4"),
            2,
            ["--generation", "4"],
        ),
        (
            &format!("{device} --start-pose up"),
            2,
            ["--start-pose", "168,12"],
        ),
        (
            &format!("{device} --generation 2 --start-pose extended --port x"),
            2,
            ["--start-pose", "generation 3"],
        ),
        (
            "devices emulate haply-2diy --fault stall",
            2,
            ["--fault", "stall=0.05@3"],
        ),
        (
            "devices emulate haply-2diy --hold 1 --duration 0",
            2,
            ["--hold", "two numbers"],
        ),
    ] {
        folder.fail(run, code, &words);
    }
    let devices = parse(&folder.succeed("devices --json"));
    assert_eq!(devices["built_in"][0]["device"], "simulated");
    assert!(devices["serial_ports"].is_array());
}

/// Driver, port, watchdog process and emulator in real time. On a machine that is too busy the command declines with a
/// reason. Tests in simulated time check the results.
#[test]
fn a_calibration_goes_the_whole_way_or_says_what_was_missing() {
    // A pause of the emulator that costs no sample can spoil a fit, but hardly three in a row.
    for _ in 0..3 {
        let folder = folder();
        let emulated = Emulated::start(&folder, " --hold 0.019,0.1169 --gain 0.9 --lag 0.0002");
        let answer = folder.palpate(
            "calibrate --device haply-2diy --port haply --wait 0 --seconds 3 --out device.toml --json",
        );
        let said = emulated.end();
        // In any case no torque is left.
        assert!(said.contains("in the end 0 and 0"), "{said}");
        assert!(answer.stderr.contains("move the device"), "{answer:?}");
        let is_there = folder.path("device.toml").exists();
        if answer.code == 0 {
            assert!(is_there);
            finds_the_mass(&answer, &said);
            return;
        }
        assert!(!is_there);
        // The emulator had no processor for a second.
        if answer.code == 1 && answer.stderr.contains("has not answered for a second") {
            return;
        }
        assert_eq!(answer.code, 6, "{answer:?}");
        let named = ["samples are missing", "times between samples vary"];
        if named.iter().any(|words| answer.stderr.contains(words)) {
            return;
        }
    }
    panic!("three calibrations were declined although no sample was missing");
}

fn finds_the_mass(answer: &Answer, said: &str) {
    let found = parse(&answer.stdout)["found"]["device_mass_kg"]["value"].clone();
    let along_y = said.rsplit(" kg along y").nth(1).unwrap();
    let put_in: f64 = along_y.rsplit(' ').next().unwrap().parse().unwrap();
    let found = found.as_f64().unwrap();
    assert!(
        (found / (put_in / 0.9) - 1.0).abs() < 0.1,
        "{found} {put_in}"
    );
}
