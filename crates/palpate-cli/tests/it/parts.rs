//! Parts of recorded motions: `--from` and `--to`, and motions that are too long without them.

use std::io::Write;
use std::process::{Command, Output, Stdio};

use crate::common::{Folder, experiment, number, of_method, parse, taps, trace_text};

const CONTACT: &str = "--stiffness 400 --mass 0.1 --period 0.01 --force -0.981 --method basic";

#[test]
fn a_part_of_a_trace_is_that_of_a_shorter_trace() {
    let folder = Folder::new();
    let samples = taps(0.001, 3.0);
    folder.write("whole.csv", trace_text(&samples));
    let is_within = |(t, _): &&(f64, f64)| (0.5..=1.5).contains(t);
    let part: Vec<(f64, f64)> = samples.iter().filter(is_within).copied().collect();
    folder.write("part.csv", trace_text(&part));
    for replay in ["", " --replay hand --device-mass 0.25"] {
        folder.succeed(&format!(
            "render whole.csv {CONTACT}{replay} --from 0.5 --to 1.5 --out a.csv --overwrite"
        ));
        folder.succeed(&format!(
            "render part.csv {CONTACT}{replay} --out b.csv --overwrite"
        ));
        let (a, b) = (folder.run_file("a.csv"), folder.run_file("b.csv"));
        for column in ["t_s", "force_on_object_n", "leak_held_j"] {
            assert_eq!(a.numbers(column).unwrap(), b.numbers(column).unwrap());
        }
        assert_eq!(a.len(), 101);
        for entry in [("trace_from_s", "0.5"), ("trace_to_s", "1.5")] {
            let entry = (entry.0.to_owned(), entry.1.to_owned());
            assert!(a.metadata().contains(&entry), "{:?}", a.metadata());
        }
    }
}

#[test]
fn the_force_that_was_held_is_that_of_the_part() {
    let folder = Folder::new();
    let text = |samples: &[(usize, (f64, f64))]| {
        let mut text = String::from("t_s,position_m,force_on_device_n\n");
        for (i, (t, x)) in samples {
            text.push_str(&format!("{t},{x},{}\n", 0.1 * (*i as f64 / 40.0).sin()));
        }
        text
    };
    let samples: Vec<_> = taps(0.001, 2.0).into_iter().enumerate().collect();
    folder.write("whole.csv", text(&samples));
    folder.write("part.csv", text(&samples[400..=1400]));
    let hand = "--replay hand --device-mass 0.25";
    let report = |file: &str, part: &str| {
        let report = folder.json(&format!("render {file} {CONTACT} {hand} {part}"));
        number(of_method(&report, "basic"), "peak_force_n")
    };
    assert_eq!(
        report("whole.csv", "--from 0.3995 --to 1.4005"),
        report("part.csv", "")
    );
}

/// Returns the answer of the program to an endless trace on standard input, at 1 kHz.
fn of_endless_input(arguments: &str) -> Output {
    let mut child = Command::new(assert_cmd::cargo::cargo_bin("palpate"))
        .args(arguments.split_whitespace())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = child.stdin.take().unwrap();
    let writer = std::thread::spawn(move || {
        input.write_all(b"t_s,position_m\n")?;
        let mut lines = String::new();
        for sample in 0_u64.. {
            let phase = (sample % 500) as f64 / 500.0;
            lines.push_str(&format!("{},{}\n", sample as f64 / 1000.0, 0.02 * phase));
            if sample % 1000 == 999 {
                // Until the reader exits.
                input.write_all(lines.as_bytes())?;
                lines.clear();
            }
        }
        Ok::<(), std::io::Error>(())
    });
    let output = child.wait_with_output().unwrap();
    let ended = writer.join().unwrap().unwrap_err();
    assert_eq!(ended.kind(), std::io::ErrorKind::BrokenPipe);
    output
}

#[test]
fn nothing_is_read_after_the_part() {
    let output = of_endless_input(&format!("render - {CONTACT} --from 1 --to 2 --json"));
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let report = parse(std::str::from_utf8(&output.stdout).unwrap());
    assert_eq!(report["format"], "palpate report 1");
}

#[test]
fn a_trace_that_is_too_long_is_refused_as_soon_as_that_shows() {
    for (part, first) in [("", "0 s"), ("--from 1.5", "1.5 s")] {
        let output = of_endless_input(&format!(
            "render - --stiffness 400 --mass 0.1 --period 1e-6 --method basic {part}"
        ));
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(3), "{said}");
        assert!(said.len() < 500, "{said}");
        for words in [
            "standard input: the trace continues for more than 2000000 periods (2.00 s)",
            &format!("after its first sample at {first}; at most 2000000 are allowed"),
            "--from and --to",
            "longer period",
        ] {
            assert!(said.contains(words), "no {words:?} in {said}");
        }
    }
}

#[test]
fn a_part_is_one_of_a_motion_that_is_there() {
    let folder = Folder::new();
    folder.write("tap.csv", trace_text(&taps(0.001, 1.0)));
    for (part, code, words) in [
        (
            "--from 1 --to 0.5",
            2,
            "--from 1 --to 0.5: the part must begin before it ends",
        ),
        ("--from 0.5 --to 0.5", 2, "must begin before it ends"),
        ("--from x", 2, "--from"),
        ("--from nan", 2, "--from"),
        (
            "--from 7",
            3,
            "0 of at least 2 required samples lie from 7 s on; the times of the trace begin \
             at 0 s and end at 1 s",
        ),
        (
            "--to -1",
            3,
            "lie up to -1 s; the times of the trace begin at 0 s",
        ),
    ] {
        folder.fail(&format!("render tap.csv {CONTACT} {part}"), code, &[words]);
    }
    let wall = experiment("wall").display().to_string();
    folder.fail(
        &format!("run {wall} --from 1"),
        2,
        &["--from and --to", "--motion"],
    );
}

#[test]
fn a_recording_and_a_motion_of_a_device_have_parts_too() {
    let folder = Folder::new();
    folder.write("tap.csv", trace_text(&taps(0.001, 1.0)));
    let wall = experiment("wall").display().to_string();
    let replayed = |motion: &str| {
        let arguments =
            format!("run {wall} --fast --device replay --motion {motion} --period 0.001");
        number(&folder.json(&arguments)["timing"], "ticks")
    };
    let whole = replayed("tap.csv");
    let part = replayed("tap.csv --from 0.25 --to 0.5");
    assert!(
        (whole - 1001.0).abs() < 2.0 && (part - 251.0).abs() < 2.0,
        "{whole} {part}"
    );

    crate::recordings::record(&folder.path("tap.mcap"));
    folder.succeed("replay tap.mcap --method basic --out whole.csv");
    folder.succeed("replay tap.mcap --method basic --out part.csv --from 0.2 --to 0.4");
    let times = folder.run_file("whole.csv").numbers("t_s").unwrap();
    let within: Vec<f64> = times
        .into_iter()
        .filter(|time| (0.2..=0.4).contains(time))
        .collect();
    assert!(within.len() > 2);
    assert_eq!(folder.run_file("part.csv").numbers("t_s").unwrap(), within);
    folder.fail(
        "replay tap.mcap --method basic --from 1e6",
        3,
        &["--from and --to", "0 ticks", "begin at"],
    );
}

#[test]
fn an_open_quote_is_shown_where_it_opens() {
    let folder = Folder::new();
    folder.write("q.csv", "t_s,position_m\n0,0.01\n0.01,0.02\n0.02,\"0.03\n");
    folder.fail(
        &format!("render q.csv {CONTACT}"),
        3,
        &["q.csv:4:6: the quote that opens here is not closed", "here"],
    );
}
