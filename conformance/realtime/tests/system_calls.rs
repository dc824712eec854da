//! A tick makes no system call except the sleep, as observed by strace.

use std::collections::BTreeMap;
use std::process::Command;

use palpate_conformance_realtime::misdeeds::Misdeed;

/// System calls within ticks, by name.
#[derive(Debug, Default)]
struct Within {
    ticks: usize,
    calls: BTreeMap<String, usize>,
}

/// Runs the program `marked` under strace and collects the calls between its marks.
fn within_ticks(what: &str) -> Within {
    let folder = tempfile::tempdir().unwrap();
    let run = Command::new("strace")
        .args(["-ff", "--signal=none", "-o"])
        .arg(folder.path().join("thread"))
        .arg(env!("CARGO_BIN_EXE_marked"))
        .arg(what)
        .output()
        .expect("this test needs strace (apt-get install strace)");
    let said = String::from_utf8_lossy(&run.stderr);
    assert!(run.status.success(), "{what}: {said}");
    let mut within = Within::default();
    // One file for each thread.
    for file in std::fs::read_dir(folder.path()).unwrap() {
        let trace = std::fs::read_to_string(file.unwrap().path()).unwrap();
        let mut is_inside = false;
        for line in trace.lines() {
            let name = line.split('(').next().unwrap_or(line);
            if name == "getppid" {
                within.ticks += usize::from(is_inside);
                is_inside = !is_inside;
            } else if is_inside {
                *within.calls.entry(name.to_owned()).or_default() += 1;
            }
        }
        assert!(!is_inside, "{what}: a tick did not end");
    }
    println!("{what}: {within:?}");
    within
}

#[test]
fn a_tick_makes_no_system_call() {
    let within = within_ticks("stepped");
    assert!(within.ticks > 100_000, "{} ticks", within.ticks);
    assert!(within.calls.is_empty(), "{:?}", within.calls);
}

/// On most kernels the clock is read without a system call. On others that call is not a fault of the loop.
#[test]
fn in_real_time_it_makes_none_but_the_sleep() {
    let mut within = within_ticks("monotonic");
    within.calls.remove("clock_gettime");
    let calls: Vec<&str> = within.calls.keys().map(String::as_str).collect();
    assert_eq!(calls, ["clock_nanosleep"], "{:?}", within.calls);
}

#[test]
fn calls_that_are_put_there_are_found() {
    let calls = |misdeed: Misdeed| within_ticks(&format!("{misdeed:?}")).calls;
    assert!(calls(Misdeed::Nothing).is_empty());
    let found = |misdeed, name| {
        let calls = calls(misdeed);
        assert!(calls.get(name).is_some_and(|n| *n >= 10), "{calls:?}");
    };
    found(Misdeed::Print, "write");
    found(Misdeed::LockHeld, "futex");
    found(Misdeed::Sleep, "clock_nanosleep");
    found(Misdeed::SleepRaw, "nanosleep");
    found(Misdeed::Open, "openat");
}
