//! Whatever ends, stops or hangs a loop on a board that holds its last torque, no torque stays on.
//!
//! Board and arm are emulated in the test's own process, so that what the board does is seen with its
//! time. The limits of time are generous: what is waited for is that the board holds no torque.

#![cfg(target_os = "linux")]
#![allow(clippy::print_stdout)] // tests show what they measured

mod deeds;
mod processes;
mod signals;

use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::common::running::{Running, program};
use crate::common::{Folder, experiment_text, number, parse};
use palpate_haply::two_diy::{Board, Generation};
use palpate_haply_emulator::two_diy::{Did, Emulator, Fault, Hand, PortSettings, Seen, Settings};
use processes::{children, is_held};
use signals::{Does, signals};

/// Nobody has to wait for so long but on a machine that does nothing else.
const PATIENCE: Duration = Duration::from_secs(60);
/// How often a test tries that needs a machine which does not stand still for a moment. Where the machine
/// stands still, a loop takes its force off, or gives its board up, before there is anything to see.
const ATTEMPTS: usize = 6;
/// What a loop says that has given its board up, or has not got it, since the machine stood still. Bytes on
/// a pseudoterminal are passed on by a worker of the kernel, which beside busy loops may have to wait for
/// seconds (both ends then stand in `flush_work`); a byte that comes late is read wrong by the board.
const STOOD_STILL: [&str; 7] = [
    "the device is gone",
    "device-lost",
    "error: no answer",
    "error: what came back is no answer",
    "error: device 5 has answered, but not with one whole answer",
    "error: the first angles",
    "its process has started and does not answer",
];

/// In the middle of the workspace, 7 mm in a wall.
const FLAGS: &str = "--device haply-2diy --start-pose 130,50 --origin 0.019,0.11 --normal 0,1 \
                     --stiffness 300 --method basic --duration inf --soft-start 0";

/// A board that is reached over a socket, whose bytes wait for no worker of the kernel.
fn emulator(folder: &Folder) -> Emulator {
    let path = folder.path("haply");
    emulator_on(PortSettings::Socket { path })
}

/// A board that is reached as a serial port is.
fn emulator_on_a_terminal(_: &Folder) -> Emulator {
    emulator_on(PortSettings::Terminal { link: None })
}

fn emulator_on(port: PortSettings) -> Emulator {
    let settings = Settings {
        angles: Some([130.0, 50.0]),
        hand: Hand::at([0.019, 0.1169]),
        port,
        ..Settings::of(Generation::Three, Board::M0)
    };
    Emulator::start(&settings).unwrap()
}

#[track_caller]
fn wait_for(what: &str, mut is_so: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !is_so() {
        assert!(begun.elapsed() < PATIENCE, "waiting for {what}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

fn is_on(emulator: &Emulator) -> bool {
    emulator.torques() != [0.0; 2]
}

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("wall.toml", experiment_text("wall"));
    folder
}

/// A loop on the emulated board, that presses.
fn pressing(folder: &Folder, emulator: &Emulator, rest: &str) -> Running {
    let port = emulator.path();
    let run = format!("run wall.toml {FLAGS} --port {} {rest}", port.display());
    let words: Vec<&str> = run.split_whitespace().collect();
    let begun = Instant::now();
    while begun.elapsed() < PATIENCE {
        let mut run = program(folder, &words.join(" "));
        let mut run = Running::start(run.stdout(Stdio::piped()).stderr(Stdio::piped()));
        if presses(&mut run, emulator) {
            return run;
        }
        let output = run.output();
        let (said, report) = (output.stderr, output.stdout);
        let ended = String::from_utf8([said, report].concat()).unwrap();
        assert!(
            STOOD_STILL.iter().any(|words| ended.contains(words)),
            "{ended}"
        );
    }
    panic!("each loop lost its board before it pressed");
}

/// Waits for a torque; false if the program has ended without one.
#[track_caller]
fn presses(run: &mut Running, emulator: &Emulator) -> bool {
    let mut ended = false;
    wait_for("a torque", || {
        ended = run.try_wait().unwrap().is_some();
        ended || is_on(emulator)
    });
    !ended
}

/// When the board held no torque from then on.
fn off_since(emulator: &Emulator) -> Option<Instant> {
    let seen = emulator.seen();
    let last_on = seen.iter().rposition(|seen| seen.torques != [0.0; 2])?;
    seen.get(last_on + 1).map(|seen| seen.at)
}

/// From the last torque to the first command of none behind it.
fn silence(seen: &[Seen]) -> Duration {
    let commanded: Vec<_> = seen
        .iter()
        .filter(|seen| matches!(seen.did, Did::Commanded(1..)))
        .collect();
    let last_on = commanded.iter().rposition(|seen| seen.torques != [0.0; 2]);
    let last_on = last_on.expect("it was on");
    commanded[last_on + 1].at - commanded[last_on].at
}

/// The guardian of a loop: the only program that the loop starts.
fn guardian(run: &Running) -> u32 {
    let mut found = None;
    wait_for("a guardian", || {
        found = children(run.id()).pop();
        found.is_some()
    });
    found.unwrap()
}

/// A loop that is killed leaves no torque, and no guardian that holds the port.
#[track_caller]
fn killed_it_leaves_no_torque(mut run: Running, emulator: &Emulator, port: &Path) {
    assert!(signal(9, run.id()));
    run.wait().unwrap();
    wait_for("no torque", || !is_on(emulator));
    wait_for("the end of the guardian", || !is_held(port));
}

fn signal(number: i32, id: u32) -> bool {
    let kill = Command::new("kill")
        .args([format!("-{number}"), id.to_string()])
        .status();
    kill.unwrap().success()
}

/// How long a torque stayed on after a signal, which a command sends that takes its time, and after the
/// last packet with a torque.
fn strikes(
    number: i32,
    does: Does,
    rest: &str,
    board: fn(&Folder) -> Emulator,
) -> (Duration, Duration) {
    let folder = folder();
    let emulator = board(&folder);
    let port = emulator.path();
    let mut run = pressing(&folder, &emulator, rest);
    let guardian = guardian(&run);
    std::thread::sleep(Duration::from_millis(u64::from(run.id() % 20)));
    let struck = Instant::now();
    assert!(signal(number, run.id()), "{number}");
    let what = format!("no torque after signal {number}");
    if does == Does::Stops {
        // The loop may have been in a cut of its supervisor, of a moment.
        wait_for(&what, || {
            off_since(&emulator).is_some_and(|since| since.elapsed() > Duration::from_millis(200))
        });
        assert!(run.try_wait().unwrap().is_none());
        assert!(signal(9, run.id()));
    }
    if matches!(number, 7 | 11) {
        // The first of these the program's run-time library takes for an overflow of the stack.
        wait_for("the end", || {
            let has_ended = run.try_wait().unwrap().is_some();
            has_ended || !signal(number, run.id())
        });
    }
    let ended = run.wait().unwrap();
    match does {
        Does::Ends => assert_eq!(ended.signal(), None, "{number}: {ended:?}"),
        Does::Kills => assert_eq!(ended.signal(), Some(number)),
        Does::Stops => assert_eq!(ended.signal(), Some(9)),
    }
    wait_for(&what, || !is_on(&emulator));
    // The guardian ends as well, and nobody holds the port. Files are closed one after the other.
    wait_for("the end of the guardian", || {
        !is_held(&port) && !Path::new(&format!("/proc/{guardian}/fd/0")).exists()
    });
    assert!(!is_on(&emulator));
    let off = off_since(&emulator).expect("it was on");
    (
        off.saturating_duration_since(struck),
        silence(&emulator.seen()),
    )
}

#[test]
fn no_signal_leaves_a_torque_on() {
    let signals = signals();
    assert_eq!(signals.len(), 56);
    let next = std::sync::atomic::AtomicUsize::new(0);
    let took = std::sync::Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..3 {
            scope.spawn(|| {
                loop {
                    let index = next.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
                    let Some((number, does)) = signals.get(index).copied() else {
                        break;
                    };
                    let after = strikes(number, does, "--priority 0 --stall-after 50", emulator);
                    took.lock().unwrap().push((number, does, after));
                }
            });
        }
    });
    let mut took = took.into_inner().unwrap();
    took.sort_by_key(|(number, ..)| *number);
    assert_eq!(took.len(), signals.len());
    for (number, does, (after, silence)) in took {
        println!(
            "signal {number:>2} ({does:?}): no torque after {after:?}, {silence:?} after the last"
        );
    }
}

/// As measured at 1 kHz with the default limits, over a terminal as over a serial port: printed, and not
/// bounded, for a busy machine bounds nothing.
#[test]
fn how_long_a_torque_stays_on_is_measured() {
    const ROUNDS: usize = 10;
    for (number, does, name) in [(9, Does::Kills, "killed"), (19, Does::Stops, "stopped")] {
        for rest in ["", "--stall-after 1.5"] {
            let mut took: Vec<Duration> = (0..ROUNDS)
                .map(|_| strikes(number, does, rest, emulator_on_a_terminal).1)
                .collect();
            took.sort();
            println!(
                "{name} at 1 kHz {rest}: no torque {:?} after the last packet with one at the median, \
                 {:?} at most, of {ROUNDS}",
                took[ROUNDS / 2],
                took[ROUNDS - 1]
            );
        }
    }
}

/// It was only late: nothing is wrong with it, and its force comes back. What it missed counts by its
/// time, of which its ticks know nothing.
#[test]
fn a_loop_that_was_stopped_for_a_while_comes_back() {
    let came_back = (0..ATTEMPTS).any(|_| stopped_for_a_while_it_comes_back());
    assert!(came_back, "each loop lost its board");
}

/// Whether the loop could be seen to come back: not where it lost its board before it was stopped.
fn stopped_for_a_while_it_comes_back() -> bool {
    let folder = folder();
    let emulator = emulator(&folder);
    let port = emulator.path();
    let begun = Instant::now();
    let mut run = pressing(&folder, &emulator, "--json --priority 0 --stall-after 50");
    // More ticks than it takes to come back.
    wait_for("ticks", || {
        emulator.seen().len() > 1000 || run.try_wait().unwrap().is_some()
    });
    // For most of its time.
    let quiet = (3 * begun.elapsed()).min(PATIENCE / 2);
    loop {
        wait_for("a torque", || {
            is_on(&emulator) || run.try_wait().unwrap().is_some()
        });
        if run.try_wait().unwrap().is_some() {
            let report = parse(&String::from_utf8(run.output().stdout).unwrap());
            assert_eq!(report["trip"], "device-lost", "{report}");
            return false;
        }
        assert!(signal(19, run.id()));
        wait_for("no torque", || {
            off_since(&emulator).is_some_and(|since| since.elapsed() > quiet)
        });
        // A loop that had just taken its force off by itself, since the machine was late, left nothing to cut.
        if silence(&emulator.seen()) >= Duration::from_millis(50) {
            break;
        }
        assert!(signal(18, run.id()));
    }
    let stood_still = off_since(&emulator).unwrap().elapsed();
    assert!(signal(18, run.id()));
    if !presses(&mut run, &emulator) {
        let report = parse(&String::from_utf8(run.output().stdout).unwrap());
        assert_eq!(report["trip"], "device-lost", "{report}");
        return false;
    }
    run.signal("TERM");
    let output = run.output();
    assert!(!is_on(&emulator));
    let report = parse(&String::from_utf8(output.stdout).unwrap());
    assert_eq!(report["guardian"]["on"], true, "{report}");
    assert!(report["guardian"]["cuts"].as_u64() >= Some(1), "{report}");
    assert_eq!(report["guardian"]["gone"], false, "{report}");
    assert_eq!(report["guardian"]["silence_s"], 0.05, "{report}");
    wait_for("the end of the guardian", || !is_held(&port));
    let (off, lasted) = (number(&report, "motors_off_s"), number(&report, "lasted_s"));
    println!(
        "no force for {off} s of {lasted} s, {}",
        report["motors_off_ticks"]
    );
    assert!(
        off >= stood_still.as_secs_f64(),
        "{stood_still:?}: {report}"
    );
    assert!(off < lasted, "{report}");
    let code = if off > lasted / 2.0 { 5 } else { 0 };
    assert_eq!(output.status.code(), Some(code), "{report}");
    true
}

#[test]
fn a_loop_that_has_lost_its_guardian_gives_no_force_and_says_how() {
    for (number, lost, warning, event) in [
        (9, "ended", "the guardian ended", "the guardian has ended"),
        (
            19,
            "not-listening",
            "the guardian is there and does not listen",
            "the guardian is there and does not listen",
        ),
    ] {
        // Where the machine stands still for a second, the board is given up before the guardian is missed. A process that
        // was killed ends once the machine runs it: until then it is there and does not listen.
        let (said, report) = (0..ATTEMPTS)
            .map(|_| without_its_guardian(number))
            .find(|(_, report)| {
                report["trip"] != "device-lost" && report["guardian"]["lost"] == lost
            })
            .expect("each loop lost its board, or saw its guardian otherwise");
        assert!(said.contains(&format!("warning: {warning}")), "{said}");
        assert_eq!(report["guardian"]["gone"], true, "{report}");
        assert_eq!(report["guardian"]["lost"], lost, "{report}");
        assert_eq!(report["trip"], "device-refused", "{report}");
        assert!(report["events"].to_string().contains(event), "{report}");
    }
}

/// A loop's warnings and report, whose guardian got a signal; no torque stayed on.
fn without_its_guardian(number: i32) -> (String, serde_json::Value) {
    let folder = folder();
    let emulator = emulator(&folder);
    let port = emulator.path();
    let run = pressing(&folder, &emulator, "--json --priority 0 --stall-after 50");
    assert!(signal(number, guardian(&run)));
    wait_for("no torque", || {
        off_since(&emulator).is_some_and(|since| since.elapsed() > Duration::from_millis(300))
    });
    run.signal("TERM");
    let output = run.output();
    wait_for("the end of the guardian", || !is_held(&port));
    let report = parse(&String::from_utf8(output.stdout).unwrap());
    (String::from_utf8(output.stderr).unwrap(), report)
}

/// A port that is pulled out is held open by nobody, and the device that comes back is guarded anew.
#[test]
fn a_device_that_comes_back_has_a_guardian_of_its_own() {
    let folder = folder();
    let settings = Settings {
        angles: Some([130.0, 50.0]),
        hand: Hand::at([0.019, 0.1169]),
        hand_waits: true,
        port: PortSettings::Socket {
            path: folder.path("haply"),
        },
        ..Settings::of(Generation::Three, Board::M0)
    };
    let emulator = Emulator::start(&settings).unwrap();
    let port = emulator.path();
    let rest = "--priority 0 --stall-after 50 --reconnect --reconnect-in-start-pose";
    let mut run = pressing(&folder, &emulator, rest);
    let first = guardian(&run);
    emulator.suffer(Fault::Unplug(Duration::from_secs(1)));
    wait_for("the end of the first guardian", || {
        !Path::new(&format!("/proc/{first}/fd/0")).exists()
    });
    assert!(run.try_wait().unwrap().is_none());
    let begun = Instant::now();
    while !is_on(&emulator) {
        if begun.elapsed() > PATIENCE {
            run.signal("TERM");
            let (angles, output) = (emulator.angles(), run.output());
            let said = String::from_utf8([output.stderr, output.stdout].concat()).unwrap();
            panic!("no torque again, the arm at {angles:?} degrees: {said}");
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    assert_ne!(guardian(&run), first);
    killed_it_leaves_no_torque(run, &emulator, &port);
}

/// Neither what a terminal sends to a loop, nor any signal that can be caught.
#[test]
fn a_guardian_heeds_no_signal_and_is_in_no_session_of_the_loop() {
    let folder = folder();
    let emulator = emulator(&folder);
    let port = emulator.path();
    let run = pressing(&folder, &emulator, "--priority 0 --stall-after 50");
    let guardian = guardian(&run);
    let session = |id: u32| -> i32 {
        let stat = std::fs::read_to_string(format!("/proc/{id}/stat")).unwrap();
        let (_, rest) = stat.rsplit_once(") ").unwrap();
        rest.split(' ').nth(3).unwrap().parse().unwrap()
    };
    assert_ne!(session(guardian), session(run.id()));
    for (number, does) in signals() {
        if does == Does::Ends {
            assert!(signal(number, guardian), "{number}");
        }
    }
    killed_it_leaves_no_torque(run, &emulator, &port);
}

#[test]
fn without_a_guardian_it_is_said_that_the_board_holds_its_torque() {
    let folder = folder();
    let emulator = emulator(&folder);
    let run = pressing(&folder, &emulator, "--guardian off --priority 0");
    assert_eq!(children(run.id()), [0; 0]);
    run.signal("TERM");
    let output = run.output();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("warning: --guardian off"), "{said}");
    let report = String::from_utf8(output.stdout).unwrap();
    assert!(report.contains("guardian: off"), "{report}");
    // For this is what a guardian is for: the negative control.
    // A loop that had just taken its force off by itself left nothing to hold.
    let stays_on = (0..ATTEMPTS).any(|_| {
        let mut run = pressing(&folder, &emulator, "--guardian off --priority 0");
        assert!(signal(9, run.id()));
        run.wait().unwrap();
        std::thread::sleep(Duration::from_millis(500));
        is_on(&emulator)
    });
    assert!(stays_on, "who took it off?");
}

#[test]
fn a_guardian_is_for_devices_that_hold_their_force_and_no_command_of_a_user() {
    let folder = folder();
    folder.fail(
        "run wall.toml --fast --guardian on",
        2,
        &["--guardian", "--device haply-2diy"],
    );
    folder.fail("guardian", 1, &["socket of a loop", "palpate run"]);
    let doctor = parse(&folder.succeed("doctor --priority 0 --json"));
    assert_eq!(doctor["guardian"]["starts"], true, "{doctor}");
    assert!(doctor["guardian"]["late_median_s"].is_number(), "{doctor}");
    let text = folder.succeed("doctor --priority 0");
    assert!(text.contains("20 silences of 4"), "{text}");
}
