//! The program on an emulated Haply 2DIY.

#![cfg(unix)]

mod common;

use std::io::{BufRead, BufReader, Read, Write};
use std::process::{ChildStderr, Stdio};
use std::time::{Duration, Instant};

use common::running::{Running, program};
use common::{Folder, experiment_text, number, parse};
use palpate_record::recording::{Entry, Recording};

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("wall.toml", experiment_text("wall"));
    folder
}

/// `palpate emulate haply-2diy`, with its port linked as `haply` in the folder.
struct Emulated {
    child: Running,
    said: ChildStderr,
}

fn started(folder: &Folder, arguments: &str) -> Running {
    let mut program = program(folder, arguments);
    Running::start(program.stdout(Stdio::null()).stderr(Stdio::piped()))
}

fn wait_for(what: &str, mut is_so: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !is_so() {
        assert!(begun.elapsed() < Duration::from_secs(20), "{what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Whether a recording that is being made has such an entry among those that were flushed.
fn has_recorded(folder: &Folder, part: &str, is_it: impl Fn(&Entry) -> bool) -> bool {
    Recording::open(&folder.path(part)).is_ok_and(|recording| {
        let mut entries = recording.entries().unwrap();
        entries.any(|entry| entry.is_ok_and(|entry| is_it(&entry)))
    })
}

impl Emulated {
    fn start(folder: &Folder, flags: &str) -> Self {
        let mut child = started(folder, &format!("emulate haply-2diy --link haply{flags}"));
        wait_for("no port", || folder.path("haply").exists());
        let said = child.stderr.take().unwrap();
        Self { child, said }
    }

    /// Ends it; what it said.
    fn end(mut self) -> String {
        self.child.signal("INT");
        assert!(self.child.wait().unwrap().success());
        let mut said = String::new();
        self.said.read_to_string(&mut said).unwrap();
        said
    }
}

const DEVICE: &str = "--device haply-2diy --port haply --start-pose 130,50 --priority 0";
const RECONNECT: &str = "--reconnect --reconnect-in-start-pose";
/// At the middle of the workspace, going into a wall 8 mm before it and out again.
const HAND: &str = " --angles 130,50 --hold 0.019,0.1169 --sway 0,0.012 --sway-period 0.4";
const WALL: &str =
    "--origin 0.019,0.11 --normal 0,1 --stiffness 300 --method basic --stall-after 50";

#[test]
fn a_wall_is_felt_recorded_and_read_back() {
    let folder = folder();
    let emulated = Emulated::start(&folder, HAND);
    let record = format!("record wall.toml tap.mcap {DEVICE} {WALL} --duration 1.5 --json");
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
    // A busy machine misses deadlines, and the run has those periods all the same.
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
            |entry| matches!(entry, Entry::Tick(tick) if tick.force_on_device.abs() > 0.5),
        )
    });
    run.signal("TERM");
    assert!(run.wait().unwrap().success());
    let said = emulated.end();
    assert!(said.contains("in the end 0 and 0"), "{said}");
    assert!(!said.contains("up to 0.000"), "{said}");
}

/// It holds its torque, and nobody else can know.
#[test]
fn a_board_that_has_not_said_that_it_holds_no_torque_is_told_of() {
    let folder = folder();
    let flags = " --angles 130,50 --hold 0.019,0.1169 --fault stall=8@5";
    let mut emulated = Emulated::start(&folder, flags);
    let mut run = program(
        &folder,
        &format!("run wall.toml {DEVICE} {WALL} --duration inf"),
    );
    let run = Running::start(run.stdout(Stdio::null()).stderr(Stdio::piped()));
    let mut said = BufReader::new(&mut emulated.said).lines();
    let stalls = said.find(|line| line.as_ref().unwrap().contains("the board stands still"));
    assert!(stalls.is_some());
    run.signal("INT");
    let said = String::from_utf8(run.output().stderr).unwrap();
    assert!(
        said.contains("warning: the 2DIY could not be let go of")
            && said.contains("last torque")
            && said.contains("switch its motors off"),
        "{said}"
    );
    emulated.end();
}

#[test]
fn a_cable_that_is_pulled_ends_a_run_with_a_word_or_is_waited_for() {
    let folder = folder();
    let flags = " --angles 130,50 --hold 0.019,0.1169 --fault unplug=0.3@1 --fault unplug=0.3@8";
    let emulated = Emulated::start(&folder, flags);
    let run = format!("run wall.toml {DEVICE} {WALL} --json");
    let answer = folder.palpate(&format!("{run} --duration 20"));
    assert_eq!(answer.code, 1, "{answer:?}");
    assert!(answer.stderr.contains("the device was lost"), "{answer:?}");
    assert!(
        answer.stderr.contains("switch its motors off"),
        "{answer:?}"
    );
    let report = parse(&answer.stdout);
    assert_eq!(report["trip"], "device-lost");
    assert!(
        report["events"].to_string().contains("port is gone"),
        "{report}"
    );
    wait_for("no port", || folder.path("haply").exists());
    let answer = folder.palpate(&format!("{run} --duration 14 {RECONNECT}"));
    assert_eq!(answer.code, 0, "{answer:?}");
    assert!(answer.stderr.contains("the device is gone"), "{answer:?}");
    assert!(answer.stderr.contains("the device is back"), "{answer:?}");
    assert!(!answer.stderr.contains("could not be let go"), "{answer:?}");
    let report = parse(&answer.stdout);
    assert_eq!(report["ending"], "its time was over");
    assert!(
        report["events"].to_string().contains("recovered"),
        "{report}"
    );
    emulated.end();
}

/// How many descriptors of a program are those of a port, though it is gone.
#[cfg(target_os = "linux")]
fn descriptors(child: &Running, port: &std::path::Path) -> usize {
    let gone = format!("{} (deleted)", port.display());
    std::fs::read_dir(format!("/proc/{}/fd", child.id()))
        .unwrap()
        .filter_map(|entry| std::fs::read_link(entry.ok()?.path()).ok())
        .filter(|to| to == port || to.as_os_str() == gone.as_str())
        .count()
}

#[cfg(target_os = "linux")]
#[test]
fn a_port_that_is_gone_is_not_held_open_while_it_is_waited_for() {
    // Pulled out, or there and silent: then it can be opened only after it was closed.
    for (fault, is_there) in [("unplug=60@2", false), ("stall=2@2", true)] {
        let folder = folder();
        let flags = format!(" --angles 130,50 --hold 0.019,0.1169 --fault {fault}");
        let emulated = Emulated::start(&folder, &flags);
        let port = std::fs::read_link(folder.path("haply")).unwrap();
        let mut run = started(
            &folder,
            &format!("run wall.toml {DEVICE} {WALL} --duration inf {RECONNECT}"),
        );
        wait_for("it is not opened", || descriptors(&run, &port) > 0);
        wait_for("it is held open", || descriptors(&run, &port) == 0);
        assert_eq!(folder.path("haply").exists(), is_there);
        if is_there {
            wait_for("it is not opened anew", || descriptors(&run, &port) > 0);
        }
        run.signal("TERM");
        // 5 where the motors were off for most of the ticks, which hangs on how long was waited here.
        let code = run.wait().unwrap().code();
        assert!(matches!(code, Some(0 | 5)), "{code:?}");
        emulated.end();
    }
}

/// A terminal as a program's input, and where it is typed.
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
    let flags = " --angles 130,50 --hold 0.019,0.1169 --fault unplug=0.3@2";
    let emulated = Emulated::start(&folder, flags);
    let (mut keys, input) = terminal();
    let run =
        format!("record wall.toml back.mcap {DEVICE} {WALL} --duration inf --reconnect --json");
    let mut run = program(&folder, &run);
    let run = run.stdin(input).stdout(Stdio::piped());
    let mut run = Running::start(run.stderr(Stdio::piped()));
    // What is typed before says nothing.
    keys.write_all(b"\n").unwrap();
    let mut said = BufReader::new(run.stderr.take().unwrap()).lines();
    let back = "the device is back";
    let mut hear = |words: &str| loop {
        let line = said.next().expect("the run has ended").unwrap();
        if line.contains(words) {
            break;
        }
        assert!(!line.contains(back), "nobody was asked to {words}");
    };
    hear("press enter");
    let asked = Instant::now();
    let typing = std::thread::spawn(move || {
        std::thread::sleep(Duration::from_secs(5));
        keys.write_all(b"\n").unwrap();
        keys
    });
    hear(back);
    assert!(
        asked.elapsed() > Duration::from_secs(5),
        "nobody was waited for"
    );
    let keys = typing.join().unwrap();
    wait_for("it does not recover", || {
        has_recorded(
            &folder,
            "back.mcap.part",
            |entry| matches!(entry, Entry::Event(event) if event.kind.contains("recovered")),
        )
    });
    run.signal("TERM");
    let output = run.output();
    drop(keys);
    let report = parse(&String::from_utf8(output.stdout).unwrap());
    assert!(
        report["events"].to_string().contains("recovered"),
        "{report}"
    );
    emulated.end();
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
    assert_eq!(report["motors"][0]["verdict"], "fine");
    assert_eq!(report["motors"][1]["verdict"], "reversed");
    emulated.end();
}

#[test]
fn a_check_that_is_terminated_leaves_no_torque() {
    // Rests of 250 ms and pulses of 80 ms take turns, and nobody tells which is on: later and later
    // until a signal has struck in a pulse or after one.
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
            "emulate haply-2diy --fault stall",
            2,
            ["--fault", "stall=0.05@3"],
        ),
        (
            "emulate haply-2diy --hold 1 --duration 0",
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
