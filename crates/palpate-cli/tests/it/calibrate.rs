//! `palpate calibrate`: positions in, forces out, and a device file at the end.

use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, Command, Stdio};

use crate::common::{Folder, parse, schema};

/// Half a period of delay `[s]`, and the mass `[kg]`, of an ideal device.
const DELAY: f64 = 0.5e-3;
const PERIOD: f64 = 1e-3;
const MASS: f64 = 0.2;

fn child(folder: &Folder, arguments: &str) -> Child {
    Command::new(env!("CARGO_BIN_EXE_palpate"))
        .args("calibrate --pipe --period 0.001".split_whitespace())
        .args(arguments.split_whitespace())
        .current_dir(folder.path(""))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Moves a device by the answers of `child`, for at most `most` samples. Returns the answers.
fn moved(child: &mut Child, most: usize) -> Vec<f64> {
    let mut input = child.stdin.take().unwrap();
    let mut output = BufReader::new(child.stdout.take().unwrap());
    let (mut x, mut v, mut acting) = (0.0, 0.0, 0.0);
    let mut forces = Vec::new();
    while forces.len() < most {
        let seen = (x / 1e-6_f64).round() * 1e-6;
        if writeln!(input, "{seen:.7}").is_err() {
            break;
        }
        let mut line = String::new();
        if output.read_line(&mut line).unwrap() == 0 {
            break;
        }
        let force: f64 = line.trim().parse().unwrap();
        forces.push(force);
        for (of, duration) in [(acting, DELAY), (force, PERIOD - DELAY)] {
            x += v * duration + 0.5 * of / MASS * duration * duration;
            v += of / MASS * duration;
        }
        acting = force;
    }
    drop(input);
    let mut rest = String::new();
    output.read_to_string(&mut rest).unwrap();
    forces.extend(rest.lines().map(|line| line.parse::<f64>().unwrap()));
    forces
}

fn end(mut child: Child) -> (Option<i32>, String) {
    let mut said = String::new();
    child
        .stderr
        .take()
        .unwrap()
        .read_to_string(&mut said)
        .unwrap();
    (child.wait().unwrap().code(), said)
}

#[test]
fn a_pipe_ends_by_itself_with_no_force_and_writes_what_it_found() {
    let folder = Folder::new();
    let mut child = child(
        &folder,
        "--seconds 3 --out device.toml --plot device.svg --json",
    );
    let forces = moved(&mut child, 10_000);
    let (code, said) = end(child);
    assert_eq!(code, Some(0), "{said}");
    assert_eq!(forces.len(), 3000);
    assert_eq!(forces[2999], 0.0);
    assert!(forces.iter().all(|force| force.abs() <= 0.5));
    let report = parse(&said);
    schema::check(&report);
    let text = std::fs::read_to_string(folder.path("device.toml")).unwrap();
    let value = |key: &str| -> f64 {
        let line = text
            .lines()
            .find(|line| line.starts_with(&format!("{key} = ")));
        let value = line.unwrap_or_else(|| panic!("no {key} in {text}"));
        value.split(" = ").nth(1).unwrap().parse().unwrap()
    };
    assert!(
        (value("device_mass_kg") / MASS - 1.0).abs() < 0.01,
        "{text}"
    );
    assert!(
        (value("delay_plus_lag_s") - DELAY).abs() < 0.01 * PERIOD,
        "{text}"
    );
    assert_eq!(
        report["found"]["device_mass_kg"]["value"],
        value("device_mass_kg")
    );
    let figure = std::fs::read_to_string(folder.path("device.svg")).unwrap();
    assert!(figure.contains("measured") && figure.contains("fitted"));
}

/// The mass follows from the square of the period, which only the times of the samples could confirm.
#[test]
fn without_times_it_is_said_that_the_period_is_not_checked() {
    let folder = Folder::new();
    let mut child = child(&folder, "--seconds 3");
    moved(&mut child, 10_000);
    let (code, said) = end(child);
    assert_eq!(code, Some(0), "{said}");
    let what = "Not checked: the sampling period of 0.001 s (--period)";
    assert!(said.contains(what), "{said}");
}

#[test]
fn an_input_that_ends_early_takes_the_force_off_and_writes_nothing() {
    let folder = Folder::new();
    let mut child = child(&folder, "--seconds 3 --out device.toml");
    let forces = moved(&mut child, 1200);
    let (code, said) = end(child);
    assert_eq!(code, Some(6), "{said}");
    assert!(said.contains("after 1200 of 3000 samples"), "{said}");
    assert_eq!(forces.len(), 1201);
    assert!(forces[1199] != 0.0);
    assert_eq!(forces[1200], 0.0);
    assert!(!folder.path("device.toml").exists());
}

#[test]
fn a_line_that_is_no_position_ends_it_without_a_force() {
    let folder = Folder::new();
    let answer = folder.palpate_reading("0\nwhat\n0\n", "calibrate --pipe --out device.toml");
    assert_eq!(answer.code, 3, "{answer:?}");
    assert!(answer.stderr.contains("line 2"), "{answer:?}");
    assert_eq!(answer.stdout, "0\n");
    let decimal = folder.palpate_reading("0,001\n", "calibrate --pipe");
    assert_eq!(
        (decimal.code, decimal.stdout.as_str()),
        (3, ""),
        "{decimal:?}"
    );
    assert!(!folder.path("device.toml").exists());
}

#[test]
fn a_device_that_leaves_the_box_stops_it() {
    let folder = Folder::new();
    let answer = folder.palpate_reading("0\n0.02\n0\n", "calibrate --pipe");
    assert_eq!(answer.code, 6, "{answer:?}");
    assert!(
        answer.stderr.contains("20.0 mm from where it started"),
        "{answer:?}"
    );
    assert_eq!(answer.stdout, "0\n0\n");
}

#[cfg(unix)]
#[test]
fn a_signal_takes_the_force_off() {
    use rustix::process::{Pid, Signal, kill_process};
    let folder = Folder::new();
    let mut child = child(&folder, "--seconds 8");
    let mut input = child.stdin.take().unwrap();
    let mut output = BufReader::new(child.stdout.take().unwrap());
    let mut line = String::new();
    for sample in 0.. {
        writeln!(input, "0").unwrap();
        line.clear();
        output.read_line(&mut line).unwrap();
        if line.trim() != "0" {
            assert!(sample >= 500, "{sample}");
            break;
        }
    }
    let id = i32::try_from(child.id()).unwrap();
    kill_process(Pid::from_raw(id).unwrap(), Signal::TERM).unwrap();
    line.clear();
    output.read_line(&mut line).unwrap();
    assert_eq!(line, "0\n");
    let (code, said) = end(child);
    assert_eq!(code, Some(130), "{said}");
}

#[test]
fn a_file_that_is_there_is_kept_and_flags_that_cannot_be_are_named() {
    let folder = Folder::new();
    folder.write("device.toml", "mine");
    for (arguments, code, said) in [
        ("--pipe --out device.toml", 1, "--overwrite"),
        ("--pipe --device null", 2, "cannot be used with"),
        ("--period 0.001", 2, "--pipe|--device"),
        (
            "--pipe --period 1",
            2,
            "the period is 1 s, but must be 0.0001 to 0.02 s",
        ),
        ("--pipe --gain 0", 2, "--gain is 0"),
        ("--pipe --plot device.txt", 2, ".svg"),
        ("--device null --fast", 6, "did not follow the commands"),
    ] {
        let answer = folder.palpate(&format!("calibrate {arguments}"));
        assert_eq!(answer.code, code, "{arguments}: {answer:?}");
        assert!(answer.stderr.contains(said), "{arguments}: {answer:?}");
        assert_eq!(answer.stdout, "", "{arguments}");
    }
    let kept = std::fs::read_to_string(folder.path("device.toml")).unwrap();
    assert_eq!(kept, "mine");
}

#[test]
fn a_simulated_device_is_found_as_its_scene_has_it() {
    let folder = Folder::new();
    let answer = folder.palpate("calibrate --device simulated --fast --seconds 3 --json");
    assert_eq!(answer.code, 0, "{answer:?}");
    let report = parse(&answer.stdout);
    schema::check(&report);
    let mass = report["found"]["device_mass_kg"]["value"].as_f64().unwrap();
    assert!((mass / 0.25 - 1.0).abs() < 0.01, "{mass}");
    let delay = report["found"]["delay_plus_lag_s"]["value"]
        .as_f64()
        .unwrap();
    assert!(delay < 0.03e-3, "{delay}");
}

#[test]
fn a_last_line_without_a_newline_is_no_sample_of_a_calibration() {
    let folder = Folder::new();
    let mut child = child(&folder, "--gain 1");
    // The rest of 0.0123.
    child.stdin.take().unwrap().write_all(b"0\n0.01").unwrap();
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{said}");
    assert!(
        said.contains("line 2: the input ends within the line"),
        "{said}"
    );
}
