//! `palpate pipe`: limits of the force, and the final line that sets it to 0.

use std::io::{BufRead, BufReader, Write};
use std::process::Stdio;

use crate::common::running::{Running, program};
use crate::common::{Answer, Folder, number, parse, unlimited};

const WALL: &str = "pipe --stiffness 1000 --mass inf --period 0.001 --device-mass 0.2";

fn pipe(arguments: &str, input: &str) -> Answer {
    Folder::new().palpate_reading(input, arguments)
}

/// Returns the numbers of all lines except the last one, which sets the force to 0.
fn forces(answer: &Answer) -> Vec<f64> {
    let mut forces: Vec<f64> = answer
        .stdout
        .lines()
        .map(|line| line.parse().unwrap())
        .collect();
    assert_eq!(forces.pop(), Some(0.0), "{answer:?}");
    forces
}

#[test]
fn forces_are_limited_and_ramped_up_by_default() {
    let deep = "0.05\n".repeat(400);
    let limited = pipe(WALL, &deep);
    assert_eq!(limited.code, 0, "{limited:?}");
    let found = forces(&limited);
    // 0.2 s at 1 kHz, in even steps; the strongest is the limit of `run`.
    for (i, force) in found.iter().enumerate() {
        let expected = -20.0 * (i as f64 / 200.0).min(1.0);
        assert!((force - expected).abs() < 1e-9, "{i}: {force}");
    }
    let said = limited.stderr.matches("forces are limited to 20 N").count();
    assert_eq!(said, 1, "{}", limited.stderr);
    for words in ["over 0.2 s", "--force-limit", "--soft-start"] {
        assert!(limited.stderr.contains(words), "{}", limited.stderr);
    }
    let said = limited.stderr.matches("exceeds the limit of 20 N").count();
    assert_eq!(said, 1, "{}", limited.stderr);

    let neither = pipe(&unlimited(WALL), "5\n");
    assert!((forces(&neither)[0] + 4995.8).abs() < 0.1, "{neither:?}");
    assert!(!neither.stderr.contains("limited to"), "{neither:?}");
    let large = pipe(&format!("{WALL} --force-limit 3000 --soft-start 0"), "5\n");
    assert_eq!(forces(&large), [-3000.0]);
    assert!(!large.stderr.contains("limited to"), "{large:?}");
}

#[test]
fn a_scene_s_own_limits_are_kept() {
    let folder = Folder::new();
    let scene = crate::common::experiment_text("wall");
    assert!(!scene.contains("force_limit_n"));
    let with = |limit: &str| {
        let limits = format!("[render]\n{limit}\n");
        assert!(scene.contains("[render]\n"));
        folder.write("scene.toml", scene.replace("[render]\n", &limits));
        let arguments = "pipe --scene scene.toml --method basic --soft-start 0";
        let answer = folder.palpate_reading("5\n", arguments);
        assert_eq!(answer.code, 0, "{answer:?}");
        forces(&answer)[0].abs()
    };
    assert_eq!(with("force_limit_n = 3"), 3.0);
    assert_eq!(with("force_limit_n = 300"), 300.0);
    assert_eq!(with(""), 20.0);
}

#[test]
fn a_refused_line_brings_the_force_back_softly() {
    let input = "0.001\n".repeat(250) + "what\n" + &"0.001\n".repeat(30);
    let found = forces(&pipe(&format!("{WALL} --method basic"), &input));
    assert_eq!(found[249..251], [-1.0, 0.0]);
    // Ten times as long as the force was off, as in `run`.
    assert_eq!(found[251], 0.0);
    assert!(found[252] < 0.0 && found[252] > -0.2, "{}", found[252]);
    assert_eq!(found[270], -1.0);
}

#[test]
fn ledger_records_the_commanded_force() {
    let positions: Vec<f64> = (0..300).map(|i| 0.05 + 1e-5 * f64::from(i)).collect();
    let input: String = positions.iter().map(|x| format!("{x}\n")).collect();
    let answer = pipe(&format!("{WALL} --method basic --json"), &input);
    let commanded = forces(&answer);
    let summary = parse(answer.stderr.lines().last().unwrap());
    let work: f64 = positions
        .windows(2)
        .zip(&commanded)
        .map(|(x, force)| -force * (x[1] - x[0]))
        .sum();
    // The spring would have done 0.05 m x 1000 N/m x 3 mm.
    assert!(work < 0.05, "{work}");
    assert!(
        (number(&summary, "port_work_j") - work).abs() < 1e-9,
        "{summary}"
    );
    assert_eq!(number(&summary, "softened"), 200.0);
    assert_eq!(number(&summary, "force_limit_n"), 20.0);
}

#[test]
fn a_soft_start_has_bounds() {
    let folder = Folder::new();
    for wrong in ["-1", "61", "nan"] {
        folder.fail(
            &format!("{WALL} --soft-start {wrong}"),
            2,
            &["--soft-start", "0 to 60"],
        );
    }
}

#[test]
fn initial_penetration_is_reported_with_remedies() {
    let deep = pipe(WALL, "5\n5\n");
    for words in [
        "line 1: the device starts 5.00 m inside the object, whose surface is at 0 m",
        "--object-position",
        "5 m or more",
        "--unit mm",
        "over 0.2 s",
    ] {
        assert!(
            deep.stderr.contains(words),
            "no {words:?} in {}",
            deep.stderr
        );
    }
    let other_side = pipe(&format!("{WALL} --side negative"), "-0.002\n");
    assert!(
        other_side.stderr.contains("-0.002 m or less"),
        "{other_side:?}"
    );
    assert!(!other_side.stderr.contains("--unit"), "{other_side:?}");
    for (arguments, input) in [("", "-0.001\n0.002\n"), (" --object-position 5", "5\n")] {
        let outside = pipe(&format!("{WALL}{arguments}"), input);
        assert!(!outside.stderr.contains("inside"), "{outside:?}");
    }
}

#[test]
fn what_is_refused_ends_with_the_force_off() {
    let basic = format!("{} --method basic", unlimited(WALL));
    // A decimal comma is not a time and a position.
    let comma = pipe(&basic, "0,001\n");
    assert_eq!((comma.code, comma.stdout.as_str()), (3, ""), "{comma:?}");
    for word in ["error: ", "line 1", "`0,001`", "a point", "--time"] {
        assert!(comma.stderr.contains(word), "no {word:?}: {comma:?}");
    }
    let cases = [
        (
            "",
            "0.001\n0.002\n0,003\n0.004\n",
            "line 3: `0,003` has 2 columns",
        ),
        (
            " --time",
            "0,0.001\n0.001,0.002\n0.002\n",
            "line 3: `0.002` has 1 column",
        ),
        (
            " --time",
            "0,0.001\n0.001,0.002\n0,002,0,003\n",
            "line 3: `0,002,0,003` has 4 columns",
        ),
        ("", "0.001\n0.002\n1,2,3\n", "line 3: `1,2,3` has 3 columns"),
    ];
    for (flags, input, message) in cases {
        let answer = pipe(&format!("{basic}{flags}"), input);
        assert_eq!(answer.code, 3, "{answer:?}");
        assert_eq!(answer.stdout, "-1\n-2\n0\n", "{message}: {answer:?}");
        assert!(answer.stderr.contains(message), "{message}: {answer:?}");
        assert!(answer.stderr.contains("2 samples"), "{answer:?}");
    }
}

#[test]
fn the_end_of_the_input_takes_the_force_off_once() {
    let basic = format!("{} --method basic", unlimited(WALL));
    assert_eq!(pipe(&basic, "0.001\n0.002\n").stdout, "-1\n-2\n0\n");
    // Without an answer there is no force to set to 0.
    assert_eq!(pipe(&basic, "").stdout, "");
    assert_eq!(pipe(&basic, "position_m\n").stdout, "");
}

#[cfg(unix)]
mod signals {
    use super::*;

    #[test]
    fn signals_take_the_force_off_and_end_the_pipe() {
        for name in ["TERM", "INT", "HUP"] {
            let folder = Folder::new();
            let arguments = format!("{} --method basic --columns force,phase", unlimited(WALL));
            let mut child = Running::start(
                program(&folder, &arguments)
                    .stdin(Stdio::piped())
                    .stdout(Stdio::piped())
                    .stderr(Stdio::piped()),
            );
            let mut input = child.stdin.take().unwrap();
            let mut output = BufReader::new(child.stdout.take().unwrap());
            let mut line = String::new();
            input.write_all(b"0.001\n").unwrap();
            output.read_line(&mut line).unwrap();
            assert_eq!(line, "-1,contact\n");
            // The input stays open, as with a stopped device or a waiting person.
            child.signal(name);
            let rest: Vec<String> = output.lines().map(Result::unwrap).collect();
            assert_eq!(rest, ["0,ended"], "{name}");
            let end = child.output();
            let stderr = String::from_utf8(end.stderr).unwrap();
            assert_eq!(end.status.code(), Some(130), "{name}: {stderr}");
            assert!(stderr.contains("1 sample, 0 refused"), "{name}: {stderr}");
            drop(input);
        }
    }

    #[test]
    fn a_signal_ends_a_pipe_whose_answers_nobody_reads() {
        // A full pipe buffer of the system.
        let (unread, mut full) = std::io::pipe().unwrap();
        full.write_all(&vec![b'\n'; 1 << 16]).unwrap();
        let folder = Folder::new();
        let mut child = Running::start(
            program(&folder, WALL)
                .stdin(Stdio::piped())
                .stdout(full)
                .stderr(Stdio::piped()),
        );
        let mut input = child.stdin.take().unwrap();
        input.write_all(b"0.001\n").unwrap();
        let mut said = BufReader::new(child.stderr.take().unwrap()).lines();
        // This message precedes the answer, which cannot be written.
        let rendered = said.find(|line| line.as_ref().unwrap().contains("inside the object"));
        assert!(rendered.is_some());
        child.signal("TERM");
        let rest: Vec<String> = said.map(Result::unwrap).collect();
        let status = child.wait().unwrap();
        assert_eq!(status.code(), Some(1), "{rest:?}");
        assert!(rest.last().unwrap().contains("was not read"), "{rest:?}");
        drop(unread);
    }
}

#[test]
fn created_energy_stops_a_pipe_as_it_stops_run() {
    // Held while the device leaves by 2 mm, 2 N generate 4 mJ in every second period.
    let shaken = "0.002\n0\n".repeat(50);
    let answer = pipe(&format!("{WALL} --method basic --soft-start 0"), &shaken);
    assert_eq!(answer.code, 5, "{answer:?}");
    let found = forces(&answer);
    let pushed = found.iter().filter(|force| **force < -1.0).count();
    assert!((10..20).contains(&pushed), "{found:?}");
    assert!(found[40..].iter().all(|force| *force == 0.0), "{found:?}");
    for words in [
        "safety stop: held forces created more than 50.0 mJ",
        "if the loop is as modelled, which is not checked",
    ] {
        assert!(answer.stderr.contains(words), "{}", answer.stderr);
    }
}

#[test]
fn a_device_at_rest_inside_a_wall_feels_its_depth_after_a_soft_start() {
    let arguments = "pipe --stiffness 400 --mass inf --period 0.04 --device-mass 0.2";
    let found = forces(&pipe(arguments, &"0.005\n".repeat(100)));
    assert!((found[99] + 2.0).abs() < 0.1, "{}", found[99]);
}

#[test]
fn a_period_too_long_for_the_contact_is_said_once() {
    let at = |stiffness: &str| {
        let arguments =
            format!("pipe --stiffness {stiffness} --mass inf --period 0.04 --device-mass 0.2");
        pipe(&arguments, "0\n0\n").stderr
    };
    let said = at("8000");
    let words = "warning: the period is too long: at 8000 N/m (kappa 64.0, Kc 0) no force held for 0.04 s is within 20 %";
    assert_eq!(said.matches(words).count(), 1, "{said}");
    assert!(!at("400").contains("warning"));
}

#[test]
fn bounds_are_those_of_simulate() {
    let folder = Folder::new();
    let arguments = "pipe --stiffness 1e308 --mass inf --period 0.001 --device-mass 0.2";
    folder.fail(arguments, 2, &["--stiffness", "at most 1e12"]);
    let far = pipe(WALL, "1e300\n0\n").stderr;
    let said =
        "line 1: the position is 1e300 m, but must be between -1e12 and 1e12 m; the force is 0";
    assert!(far.contains(said), "{far}");
    let stiff = pipe(WALL, "0\nset stiffness_n_per_m=1e13\n").stderr;
    assert!(
        stiff.contains("line 2: set is refused") && stiff.contains("at most 1e12"),
        "{stiff}"
    );
}

#[test]
fn a_word_in_the_first_line_is_a_header() {
    let answer = pipe(&format!("{WALL} --json"), "position\n0\n");
    assert_eq!(answer.stdout.lines().count(), 2, "{answer:?}");
    let said =
        "line 1: \"position\" is taken as a header and gets no answer; expected `position_m`";
    assert!(answer.stderr.contains(said), "{answer:?}");
    let summary = parse(answer.stderr.lines().last().unwrap());
    assert_eq!(
        (number(&summary, "samples"), number(&summary, "refused")),
        (1.0, 0.0)
    );
}
