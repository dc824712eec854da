//! No torque stays on after the end, stop or hang of a loop on a board that holds its last torque.
//!
//! Board and arm are emulated in the test's own process, so that the board's behaviour is observed with its timing. The
//! time limits are generous: the tests wait until the board holds no torque.

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
use palpate_drivers::emulator::port::PortSettings;
use palpate_drivers::emulator::two_diy::{Did, Emulator, Fault, Hand, Seen, Settings};
use palpate_drivers::two_diy::{Board, Generation};
use processes::{children, is_held};
use signals::{Does, signals};

/// Longest wait; only a fully loaded machine needs that long.
const PATIENCE: Duration = Duration::from_secs(60);
/// Attempts of tests that fail if the machine stalls. On a stalled machine a loop disables its force or gives up its
/// board before the effect under test occurs.
const ATTEMPTS: usize = 6;
/// Messages of a loop that gave up its board, or did not get it, because the machine stalled. A kernel worker forwards
/// bytes on a pseudoterminal. Beside busy loops it may wait for seconds (both ends are then in `flush_work`), and the
/// board misreads late bytes.
const STOOD_STILL: [&str; 7] = [
    "the device is gone",
    "device-lost",
    "error: no answer",
    "error: invalid answer",
    "error: device 5 sent no complete answer",
    "error: the first angles",
    "its process has started but does not answer",
];

/// In the middle of the workspace, 7 mm in a wall.
const FLAGS: &str = "--device haply-2diy --start-pose 130,50 --origin 0.019,0.11 --normal 0,1 \
                     --stiffness 300 --method basic --duration inf --soft-start 0";

/// A board behind a socket, whose bytes wait for no kernel worker.
fn emulator(folder: &Folder) -> Emulator {
    let path = folder.path("haply");
    emulator_on(PortSettings::Socket { path })
}

/// A board behind a terminal, like a serial port.
fn emulator_on_a_terminal(_: &Folder) -> Emulator {
    emulator_on(PortSettings::Terminal { link: None })
}

fn emulator_on(port: PortSettings) -> Emulator {
    let settings = Settings {
        angles: Some([130.0, 50.0]),
        hand: Hand::at([0.019, 0.1169]),
        port,
        ..Settings::new(Generation::Three, Board::M0)
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

/// Starts a loop on the emulated board that presses into a wall.
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

/// Waits for a torque. Returns false if the program has ended without one.
#[track_caller]
fn presses(run: &mut Running, emulator: &Emulator) -> bool {
    let mut ended = false;
    wait_for("a torque", || {
        ended = run.try_wait().unwrap().is_some();
        ended || is_on(emulator)
    });
    !ended
}

/// Returns the time since which the board has held no torque.
fn off_since(emulator: &Emulator) -> Option<Instant> {
    let seen = emulator.seen();
    let last_on = seen.iter().rposition(|seen| seen.torques != [0.0; 2])?;
    seen.get(last_on + 1).map(|seen| seen.at)
}

/// Returns the time from the last torque to the following zero command.
fn silence(seen: &[Seen]) -> Duration {
    let commanded: Vec<_> = seen
        .iter()
        .filter(|seen| matches!(seen.did, Did::Commanded(1..)))
        .collect();
    let last_on = commanded.iter().rposition(|seen| seen.torques != [0.0; 2]);
    let last_on = last_on.expect("it was on");
    commanded[last_on + 1].at - commanded[last_on].at
}

/// Returns the watchdog process of a loop: the only program that the loop starts.
fn watchdog(run: &Running) -> u32 {
    let mut found = None;
    wait_for("a watchdog", || {
        found = children(run.id()).pop();
        found.is_some()
    });
    found.unwrap()
}

/// Checks that a killed loop leaves no torque, and no watchdog process that holds the port.
#[track_caller]
fn killed_it_leaves_no_torque(mut run: Running, emulator: &Emulator, port: &Path) {
    assert!(signal(9, run.id()));
    run.wait().unwrap();
    wait_for("no torque", || !is_on(emulator));
    wait_for("the end of the watchdog", || !is_held(port));
}

fn signal(number: i32, id: u32) -> bool {
    let kill = Command::new("kill")
        .args([format!("-{number}"), id.to_string()])
        .status();
    kill.unwrap().success()
}

/// Returns the time that a torque stayed on after a signal, which is sent by a slow command, and after the last packet
/// with a torque.
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
    let watchdog = watchdog(&run);
    std::thread::sleep(Duration::from_millis(u64::from(run.id() % 20)));
    let struck = Instant::now();
    assert!(signal(number, run.id()), "{number}");
    let what = format!("no torque after signal {number}");
    if does == Does::Stops {
        // The supervisor may have cut the loop's force for a moment.
        wait_for(&what, || {
            off_since(&emulator).is_some_and(|since| since.elapsed() > Duration::from_millis(200))
        });
        assert!(run.try_wait().unwrap().is_none());
        assert!(signal(9, run.id()));
    }
    if matches!(number, 7 | 11) {
        // The program's run-time library takes the first of these signals for a stack overflow.
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
    // The watchdog process ends as well and releases the port. Files are closed one after the other.
    wait_for("the end of the watchdog", || {
        !is_held(&port) && !Path::new(&format!("/proc/{watchdog}/fd/0")).exists()
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
                    let after = strikes(
                        number,
                        does,
                        "--priority 0 --stall-after-periods 50",
                        emulator,
                    );
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

/// Measured at 1 kHz with the default limits, over a terminal as over a serial port. The result is printed without a
/// bound, because a busy machine can exceed any bound.
#[test]
fn how_long_a_torque_stays_on_is_measured() {
    const ROUNDS: usize = 10;
    for (number, does, name) in [(9, Does::Kills, "killed"), (19, Does::Stops, "stopped")] {
        for rest in ["", "--stall-after-periods 1.5"] {
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

/// A loop that was only late recovers its force. The missed periods count by their time, because its ticks do not
/// record them.
#[test]
fn a_loop_that_was_stopped_for_a_while_comes_back() {
    let came_back = (0..ATTEMPTS).any(|_| stopped_for_a_while_it_comes_back());
    assert!(came_back, "each loop lost its board");
}

/// Returns whether the loop recovered, which fails if it lost its board before it was stopped.
fn stopped_for_a_while_it_comes_back() -> bool {
    let folder = folder();
    let emulator = emulator(&folder);
    let port = emulator.path();
    let begun = Instant::now();
    let mut run = pressing(
        &folder,
        &emulator,
        "--json --priority 0 --stall-after-periods 50",
    );
    // More ticks than a recovery takes.
    wait_for("ticks", || {
        emulator.seen().len() > 1000 || run.try_wait().unwrap().is_some()
    });
    // Most of the loop's time.
    let quiet = (3 * begun.elapsed()).min(PATIENCE / 2);
    loop {
        wait_for("a torque", || {
            is_on(&emulator) || run.try_wait().unwrap().is_some()
        });
        if run.try_wait().unwrap().is_some() {
            let report = parse(&String::from_utf8(run.output().stdout).unwrap());
            assert_eq!(report["safety_stop"], "device-lost", "{report}");
            return false;
        }
        assert!(signal(19, run.id()));
        wait_for("no torque", || {
            off_since(&emulator).is_some_and(|since| since.elapsed() > quiet)
        });
        // If the late loop had just disabled its force itself, the watchdog process had nothing to cut.
        if silence(&emulator.seen()) >= Duration::from_millis(50) {
            break;
        }
        assert!(signal(18, run.id()));
    }
    let stood_still = off_since(&emulator).unwrap().elapsed();
    assert!(signal(18, run.id()));
    if !presses(&mut run, &emulator) {
        let report = parse(&String::from_utf8(run.output().stdout).unwrap());
        assert_eq!(report["safety_stop"], "device-lost", "{report}");
        return false;
    }
    run.signal("TERM");
    let output = run.output();
    assert!(!is_on(&emulator));
    let report = parse(&String::from_utf8(output.stdout).unwrap());
    assert_eq!(report["watchdog"]["on"], true, "{report}");
    assert!(report["watchdog"]["cuts"].as_u64() >= Some(1), "{report}");
    assert_eq!(report["watchdog"]["gone"], false, "{report}");
    assert_eq!(report["watchdog"]["silence_s"], 0.05, "{report}");
    wait_for("the end of the watchdog", || !is_held(&port));
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
fn a_loop_that_has_lost_its_watchdog_gives_no_force_and_says_how() {
    for (number, lost, warning, event) in [
        (9, "ended", "the watchdog ended", "the watchdog has ended"),
        (
            19,
            "not-listening",
            "the watchdog does not respond",
            "the watchdog does not respond",
        ),
    ] {
        // If the machine stalls for a second, the loop gives up the board before it misses the watchdog process. A
        // killed process ends only once the machine schedules it; until then it exists without listening.
        let (said, report) = (0..ATTEMPTS)
            .map(|_| without_its_watchdog(number))
            .find(|(_, report)| {
                report["safety_stop"] != "device-lost" && report["watchdog"]["lost"] == lost
            })
            .expect("each loop lost its board, or saw its watchdog otherwise");
        assert!(said.contains(&format!("warning: {warning}")), "{said}");
        assert_eq!(report["watchdog"]["gone"], true, "{report}");
        assert_eq!(report["watchdog"]["lost"], lost, "{report}");
        assert_eq!(report["safety_stop"], "device-refused", "{report}");
        assert!(report["events"].to_string().contains(event), "{report}");
    }
}

/// Returns the warnings and the report of a loop whose watchdog process got a signal; checks that no torque stayed on.
fn without_its_watchdog(number: i32) -> (String, serde_json::Value) {
    let folder = folder();
    let emulator = emulator(&folder);
    let port = emulator.path();
    let run = pressing(
        &folder,
        &emulator,
        "--json --priority 0 --stall-after-periods 50",
    );
    assert!(signal(number, watchdog(&run)));
    wait_for("no torque", || {
        off_since(&emulator).is_some_and(|since| since.elapsed() > Duration::from_millis(300))
    });
    run.signal("TERM");
    let output = run.output();
    wait_for("the end of the watchdog", || !is_held(&port));
    let report = parse(&String::from_utf8(output.stdout).unwrap());
    (String::from_utf8(output.stderr).unwrap(), report)
}

/// A removed port is not held open, and the returned device gets a new watchdog process.
#[test]
fn a_device_that_comes_back_has_a_watchdog_of_its_own() {
    let folder = folder();
    let settings = Settings {
        angles: Some([130.0, 50.0]),
        hand: Hand::at([0.019, 0.1169]),
        hand_waits: true,
        port: PortSettings::Socket {
            path: folder.path("haply"),
        },
        ..Settings::new(Generation::Three, Board::M0)
    };
    let emulator = Emulator::start(&settings).unwrap();
    let port = emulator.path();
    let rest = "--priority 0 --stall-after-periods 50 --reconnect --reconnect-in-start-pose";
    let mut run = pressing(&folder, &emulator, rest);
    let first = watchdog(&run);
    emulator.inject_faults(Fault::Unplug(Duration::from_secs(1)));
    wait_for("the end of the first watchdog", || {
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
    assert_ne!(watchdog(&run), first);
    killed_it_leaves_no_torque(run, &emulator, &port);
}

/// The watchdog process ignores terminal input of the loop and all signals that can be caught.
#[test]
fn a_watchdog_heeds_no_signal_and_is_in_no_session_of_the_loop() {
    let folder = folder();
    let emulator = emulator(&folder);
    let port = emulator.path();
    let run = pressing(&folder, &emulator, "--priority 0 --stall-after-periods 50");
    let watchdog = watchdog(&run);
    let session = |id: u32| -> i32 {
        let stat = std::fs::read_to_string(format!("/proc/{id}/stat")).unwrap();
        let (_, rest) = stat.rsplit_once(") ").unwrap();
        rest.split(' ').nth(3).unwrap().parse().unwrap()
    };
    assert_ne!(session(watchdog), session(run.id()));
    for (number, does) in signals() {
        if does == Does::Ends {
            assert!(signal(number, watchdog), "{number}");
        }
    }
    killed_it_leaves_no_torque(run, &emulator, &port);
}

#[test]
fn without_a_watchdog_it_is_said_that_the_board_holds_its_torque() {
    let folder = folder();
    let emulator = emulator(&folder);
    let run = pressing(&folder, &emulator, "--watchdog off --priority 0");
    assert_eq!(children(run.id()), [0; 0]);
    run.signal("TERM");
    let output = run.output();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("warning: --watchdog off"), "{said}");
    let report = String::from_utf8(output.stdout).unwrap();
    assert!(report.contains("watchdog: off"), "{report}");
    // Negative control: without a watchdog process the torque stays on. A loop that had just disabled its force itself
    // leaves no torque.
    let stays_on = (0..ATTEMPTS).any(|_| {
        let mut run = pressing(&folder, &emulator, "--watchdog off --priority 0");
        assert!(signal(9, run.id()));
        run.wait().unwrap();
        std::thread::sleep(Duration::from_millis(500));
        is_on(&emulator)
    });
    assert!(stays_on, "who took it off?");
}

#[test]
fn a_watchdog_is_for_devices_that_hold_their_force_and_no_command_of_a_user() {
    let folder = folder();
    folder.fail(
        "run wall.toml --fast --watchdog on",
        2,
        &["--watchdog", "haply-2diy, process and udp"],
    );
    folder.fail("watchdog", 1, &["socket of a loop", "palpate run"]);
    let doctor = parse(&folder.succeed("doctor --priority 0 --json"));
    assert_eq!(doctor["watchdog"]["starts"], true, "{doctor}");
    assert!(doctor["watchdog"]["late_median_s"].is_number(), "{doctor}");
    let text = folder.succeed("doctor --priority 0");
    assert!(text.contains("20 silences of 4"), "{text}");
}
