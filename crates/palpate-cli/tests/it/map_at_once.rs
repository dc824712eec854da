//! Concurrent `palpate map` runs on one file, and killed ones.
#![cfg(unix)]

use std::fs;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::common::Folder;
use rustix::process::{Pid, Signal, kill_process};

const MAP: &str = "map --cells 17 --method hfcr,basic --threads 1";

/// Starts the map in the background, resumed.
fn begin(folder: &Folder, out: &str) -> Child {
    Command::new(assert_cmd::cargo::cargo_bin("palpate"))
        .current_dir(folder.path("."))
        .args(MAP.split(' '))
        .args(["--resume", "--out", out])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

fn send(child: &Child, signal: Signal) {
    let id = Pid::from_raw(child.id().try_into().unwrap()).unwrap();
    kill_process(id, signal).unwrap();
}

/// Waits until a journal has a few cells, and stops the program that writes it.
fn stop_amid(folder: &Folder, child: &Child, journal: &str) -> Vec<u8> {
    let path = folder.path(journal);
    let begun = Instant::now();
    while fs::metadata(&path).map_or(0, |file| file.len()) < 3000 {
        assert!(begun.elapsed() < Duration::from_secs(50), "no journal");
        std::thread::sleep(Duration::from_millis(1));
    }
    send(child, Signal::STOP);
    // A pending write is complete when the process is shown as stopped.
    let state = format!("/proc/{}/stat", child.id());
    let is_stopped = || {
        let stat = fs::read_to_string(&state).unwrap_or_default();
        stat.rsplit(')')
            .next()
            .is_some_and(|rest| rest.trim().starts_with('T'))
    };
    while fs::exists(&state).unwrap() && !is_stopped() {
        std::thread::sleep(Duration::from_millis(1));
    }
    fs::read(&path).expect("stopped before it was done")
}

#[test]
fn second_map_run_names_holder_and_changes_nothing() {
    let folder = Folder::new();
    folder.succeed(&format!("{MAP} --out plain.csv"));
    let plain = folder.read("plain.csv");
    for attempt in 0..5 {
        let out = format!("m{attempt}.csv");
        let journal = format!("{out}.journal");
        let mut first = begin(&folder, &out);
        let before = stop_amid(&folder, &first, &journal);
        for resume in ["--resume", ""] {
            folder.fail(
                &format!("{MAP} {resume} --out {out}"),
                1,
                &[
                    &format!("`{journal}` is held by process {} on ", first.id()),
                    "wait for it",
                    "--resume",
                ],
            );
            assert!(
                fs::read(folder.path(&journal)).unwrap() == before,
                "changed"
            );
        }
        if attempt % 2 == 0 {
            send(&first, Signal::CONT);
        } else {
            // As by kill -9, in the middle of a line; its locks are released.
            first.kill().unwrap();
            first.wait().unwrap();
            let mut torn = before.clone();
            torn.truncate(before.len() - 100);
            fs::write(folder.path(&journal), &torn).unwrap();
            let whole = torn.iter().rposition(|byte| *byte == b'\n').unwrap() + 1;
            first = begin(&folder, &out);
            let after = stop_amid_at_once(&folder, &first, &journal, torn.len() + 500);
            assert!(after.starts_with(&torn[..whole]), "what was whole is kept");
            send(&first, Signal::CONT);
        }
        let done = first.wait_with_output().unwrap();
        assert_eq!(done.status.code(), Some(0), "{done:?}");
        assert!(folder.read(&out) == plain, "{attempt}");
        assert!(!folder.path(&journal).exists());
    }
}

/// As `stop_amid`, once the journal is longer than `length`.
fn stop_amid_at_once(folder: &Folder, child: &Child, journal: &str, length: usize) -> Vec<u8> {
    let path = folder.path(journal);
    let begun = Instant::now();
    while fs::metadata(&path).map_or(0, |file| file.len()) < length as u64 {
        assert!(
            begun.elapsed() < Duration::from_secs(50),
            "not gone on with"
        );
        std::thread::sleep(Duration::from_millis(1));
    }
    stop_amid(folder, child, journal)
}

#[test]
fn maps_that_begin_at_once_make_one_map() {
    let folder = Folder::new();
    folder.succeed(&format!("{MAP} --out plain.csv"));
    let plain = folder.read("plain.csv");
    for attempt in 0..3 {
        let out = format!("m{attempt}.csv");
        let started: Vec<Child> = (0..4).map(|_| begin(&folder, &out)).collect();
        let mut computed = 0;
        for child in started {
            let output = child.wait_with_output().unwrap();
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            let report = String::from_utf8_lossy(&output.stdout).into_owned();
            match output.status.code() {
                // The others may find it complete.
                Some(0) => computed += usize::from(report.contains("ticks/s")),
                Some(1) => assert!(said.contains("is held by "), "{said}"),
                other => panic!("{other:?}: {said}"),
            }
        }
        assert_eq!(computed, 1);
        assert!(folder.read(&out) == plain, "{attempt}");
        assert!(!folder.path(&format!("{out}.journal")).exists());
    }
}

#[test]
fn a_map_that_is_complete_is_not_made_again() {
    let folder = Folder::new();
    let map = "map --cells 2 --method basic";
    folder.succeed(map);
    let (table, figure) = (folder.read("map.csv"), folder.read("map.svg"));
    folder.write("map.svg", "mine");
    let again = folder.succeed(&format!("{map} --resume"));
    assert!(again.contains("kept the existing map.svg"), "{again}");
    assert_eq!(folder.read("map.svg"), "mine");
    // A missing figure is drawn.
    fs::remove_file(folder.path("map.svg")).unwrap();
    folder.succeed(&format!("{map} --resume"));
    assert_eq!(folder.read("map.svg"), figure);
    folder.write("map.svg", "mine");
    folder.succeed(&format!("{map} --resume --overwrite"));
    assert_eq!(folder.read("map.svg"), figure);
    // A different map is not resumed.
    folder.fail(
        "map --cells 3 --method basic --resume",
        3,
        &["map.csv is another, complete map", "--overwrite"],
    );
    folder.write("map.csv", "mine");
    folder.fail(
        &format!("{map} --resume"),
        3,
        &["map.csv:1: this is not a map", "--overwrite"],
    );
    assert_eq!(folder.read("map.csv"), "mine");
    folder.succeed(&format!("{map} --resume --overwrite"));
    assert_eq!(folder.read("map.csv"), table);
    assert_eq!(folder.names(), ["map.csv", "map.svg"]);
}
