//! `palpate live`, from the command line.

#![cfg(unix)]

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::process::{Command, Stdio};
use std::time::Duration;

use crate::common::running::{Running, program};
use crate::common::{Folder, experiment_text};
use palpate_record::recording::Recording;

#[test]
fn it_says_where_the_page_is_and_ends_with_a_report() {
    let folder = Folder::new();
    // This test is not about a busy machine; a safety stop for a late tick has a separate exit code.
    let live = "live --listen 127.0.0.1:0 --priority 0 --stall-after-periods 1000";
    let mut child = Running::start(program(&folder, live).stdout(Stdio::piped()));
    let mut out = BufReader::new(child.stdout.take().unwrap());
    let mut url = String::new();
    out.read_line(&mut url).unwrap();
    let address = url
        .strip_prefix("http://")
        .and_then(|rest| rest.strip_suffix("/\n"))
        .unwrap_or_else(|| panic!("{url:?}"));
    let mut page = TcpStream::connect(address).unwrap();
    page.set_read_timeout(Some(Duration::from_secs(20)))
        .unwrap();
    let request = format!("GET / HTTP/1.1\r\nHost: {address}\r\n\r\n");
    page.write_all(request.as_bytes()).unwrap();
    let mut answer = String::new();
    page.read_to_string(&mut answer).unwrap();
    assert!(answer.starts_with("HTTP/1.1 200 "), "{answer}");
    assert!(answer.contains("<title>"), "{answer}");
    child.signal("INT");
    let mut report = String::new();
    out.read_to_string(&mut report).unwrap();
    assert!(child.wait().unwrap().success(), "{report}");
    for words in [
        "basic on the device `pointer` at 100 Hz; stopped on request",
        "coupled on the device `pointer` at 100 Hz; stopped on request",
    ] {
        assert!(report.contains(words), "{report}");
    }
    assert!(folder.names().is_empty(), "{:?}", folder.names());
}

#[test]
fn one_that_is_stopped_before_its_time_has_an_exit_code() {
    let folder = Folder::new();
    let live = "live --listen 127.0.0.1:0 --priority 0 --duration 1000";
    let mut live = program(&folder, live);
    let mut child = Running::start(live.stdout(Stdio::piped()).stderr(Stdio::piped()));
    let mut out = BufReader::new(child.stdout.take().unwrap());
    let mut url = String::new();
    out.read_line(&mut url).unwrap();
    child.signal("INT");
    let output = child.output();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{said}");
    assert!(said.contains("stopped before the end of 1000 s"), "{said}");
}

#[test]
fn it_records_every_lane_from_its_first_tick() {
    let folder = Folder::new();
    folder.write("wall.toml", experiment_text("wall"));
    let live = "live wall.toml --listen 127.0.0.1:0 --duration 0.5 --period 0.001";
    let report = folder.palpate(&format!(
        "{live} --method basic,hfcr --device simulated --record wall.mcap"
    ));
    assert_eq!(report.code, 0, "{report:?}");
    assert_eq!(
        folder.names(),
        ["wall-1-basic.mcap", "wall-2-hfcr.mcap", "wall.toml"]
    );
    for file in ["wall-1-basic.mcap", "wall-2-hfcr.mcap"] {
        let recording = Recording::open(&folder.path(file)).unwrap();
        assert!(recording.is_whole(), "{file}");
        // A busy machine misses some of them.
        assert!(
            (100..=500).contains(&recording.ticks),
            "{}",
            recording.ticks
        );
        assert_eq!(recording.lost(), 0, "{file}");
        // The same line as of `run`, size and all.
        assert!(recording.is_complete(), "{file}");
        let line = format!("{file}: complete, {} ticks, 0 lost, 0.", recording.ticks);
        assert!(report.stdout.contains(&line), "{report:?}");
        assert!(!report.stdout.contains(" 0 MB"), "{report:?}");
        assert!(recording.bytes > 10_000, "{}", recording.bytes);
    }
    let replayed = folder.palpate("replay wall-2-hfcr.mcap --method basic");
    assert!(matches!(replayed.code, 0 | 4), "{replayed:?}");
    // Nothing is overwritten.
    let again = folder.palpate(&format!(
        "{live} --method basic,hfcr --device simulated --record wall.mcap"
    ));
    again.failed("again", 1, &["wall-1-basic.mcap", "there is a file"]);
    // With one loop, `--record` names its file.
    let one = folder.palpate(&format!("{live} --method hfcr --record one.mcap"));
    assert_eq!(one.code, 0, "{one:?}");
    assert!(folder.path("one.mcap").exists());
}

#[test]
fn what_cannot_be_is_said_at_once() {
    let folder = Folder::new();
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap();
    folder.fail(
        &format!("live --listen {address}"),
        1,
        &[&address.to_string(), "is in use", "--listen 127.0.0.1:0"],
    );
    let free = "live --listen 127.0.0.1:0";
    folder.fail(
        &format!("{free} --method basic,seh,hfcr"),
        2,
        &["--method: 3 methods", "one, or two side by side"],
    );
    folder.fail(
        &format!("{free} --safe-force 0"),
        2,
        &["largest force is 0", "above 0"],
    );
    folder.fail(
        &format!("{free} --device replay --motion none.csv"),
        1,
        &["none.csv"],
    );
    folder.fail("live --listen somewhere", 2, &["127.0.0.1:7777"]);
    folder.fail(
        "live missing.toml --listen 127.0.0.1:0",
        1,
        &["missing.toml"],
    );
    folder.fail(&format!("{free} --device-mass -1"), 2, &["-1"]);
}

/// A run whose report cannot be written ends normally.
#[test]
#[cfg(target_os = "linux")]
fn a_standard_output_that_is_full_leaves_no_recording_half_written() {
    let folder = Folder::new();
    folder.write("wall.toml", experiment_text("wall"));
    let full = std::fs::File::options()
        .write(true)
        .open("/dev/full")
        .unwrap();
    let live = "live wall.toml --listen 127.0.0.1:0 --priority 0 --record wall.mcap";
    let mut live = program(&folder, live);
    let ended = Running::start(live.stdout(full).stderr(Stdio::null()))
        .wait()
        .unwrap();
    assert_eq!(ended.code(), Some(1));
    assert_eq!(folder.names(), ["wall.mcap", "wall.toml"]);
    assert!(
        Recording::open(&folder.path("wall.mcap"))
            .unwrap()
            .is_whole()
    );
}

/// A full disk, emulated by a limit on the size of the program's files.
#[test]
#[cfg(target_os = "linux")]
fn a_recording_that_cannot_be_written_is_said_at_the_end() {
    let folder = Folder::new();
    folder.write("wall.toml", experiment_text("wall"));
    let live = "live wall.toml --listen 127.0.0.1:0 --priority 0 --period 0.001 --duration 2";
    let script = format!(
        "trap '' XFSZ; ulimit -f 16; exec {} {live} --record wall.mcap",
        env!("CARGO_BIN_EXE_palpate")
    );
    let ended = Command::new("sh")
        .args(["-c", &script])
        .current_dir(folder.path("."))
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(1), "{said}");
    assert!(said.contains("wall.mcap"), "{said}");
}

/// A page on all addresses is announced by real addresses: a browser cannot open 0.0.0.0.
#[test]
fn a_page_on_every_address_is_said_by_addresses_that_can_be_opened() {
    let folder = Folder::new();
    let mut live = program(&folder, "live --listen 0.0.0.0:0 --priority 0");
    let mut child = Running::start(live.stdout(Stdio::piped()));
    let mut out = BufReader::new(child.stdout.take().unwrap());
    let mut lines = [String::new(), String::new()];
    for line in &mut lines {
        out.read_line(line).unwrap();
    }
    let [here, there] = &lines;
    assert!(
        !here.contains("0.0.0.0") && !there.contains("0.0.0.0"),
        "{lines:?}"
    );
    assert!(here.starts_with("http://127.0.0.1:"), "{lines:?}");
    assert!(there.starts_with("from another machine: "), "{lines:?}");
    let mut urls = vec![here.trim()];
    urls.extend(
        there
            .split(' ')
            .map(str::trim)
            .filter(|word| word.starts_with("http://")),
    );
    for url in urls {
        let (address, path) = url
            .strip_prefix("http://")
            .unwrap()
            .split_once('/')
            .unwrap();
        assert!(path.starts_with("?token="), "{url}");
        let mut page = TcpStream::connect(address).unwrap();
        page.set_read_timeout(Some(Duration::from_secs(20)))
            .unwrap();
        let request = format!("GET /{path} HTTP/1.1\r\nHost: {address}\r\n\r\n");
        page.write_all(request.as_bytes()).unwrap();
        let mut answer = String::new();
        page.read_to_string(&mut answer).unwrap();
        assert!(answer.starts_with("HTTP/1.1 200 "), "{url}: {answer}");
    }
    child.signal("INT");
    let mut report = String::new();
    out.read_to_string(&mut report).unwrap();
    assert!(child.wait().unwrap().success(), "{report}");
}
