//! `palpate pipe`: a line in, a force on the device out.

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use crate::common::{Folder, METHODS, default_params, number, parse, taps, unlimited};
use palpate_core::{AnyRenderer, Contact, LoopParams, ObjectState, Renderer, Sample};

const WALL: &str = "pipe --stiffness 1000 --mass inf --period 0.001 --device-mass 0.2";

/// Returns forces and messages of a pipe without limits for a whole input, and its summary. The last line, which sets
/// the force to 0, is not an answer. The device starts inside the object on purpose.
fn answers(arguments: &str, input: impl AsRef<[u8]>) -> (Vec<f64>, Vec<String>, String) {
    let answer = Folder::new().palpate_reading(input, &unlimited(arguments));
    assert_eq!(answer.code, 0, "{answer:?}");
    let mut forces: Vec<f64> = answer
        .stdout
        .lines()
        .map(|line| line.parse().unwrap())
        .collect();
    assert!(matches!(forces.pop(), None | Some(0.0)), "{answer:?}");
    let mut messages: Vec<String> = answer
        .stderr
        .lines()
        .filter(|line| !line.contains("the device starts"))
        .map(str::to_owned)
        .collect();
    let summary = messages.pop().expect("a summary");
    (forces, messages, summary)
}

fn forces(arguments: &str, input: impl AsRef<[u8]>) -> Vec<f64> {
    let (forces, messages, _) = answers(arguments, input);
    assert_eq!(messages, [""; 0]);
    forces
}

/// Returns the forces on the device from the library, for samples of elapsed time and position.
fn by_library(method: &str, mass: f64, samples: &[(Option<f64>, f64)]) -> Vec<f64> {
    let renderer: AnyRenderer<f64> = Renderer::new(
        Contact::object(400.0, mass),
        LoopParams::new(0.01),
        default_params(method, 400.0, 0.01, 0.25),
    )
    .unwrap();
    let mut state = renderer.start(ObjectState::at_rest(0.0)).unwrap();
    samples
        .iter()
        .map(|&(elapsed, device_position)| {
            let sample = Sample {
                device_position,
                elapsed,
                virtual_force: -0.981,
            };
            renderer.step(&mut state, sample).force_on_device
        })
        .collect()
}

/// An interactive pipe.
struct Dialogue {
    child: Child,
    input: Option<ChildStdin>,
    lines: Receiver<String>,
}

impl Dialogue {
    fn start(arguments: &str) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_palpate"))
            .args(unlimited(arguments).split_whitespace())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let output = BufReader::new(child.stdout.take().unwrap());
        let (sender, lines) = channel();
        std::thread::spawn(move || {
            for line in output.lines() {
                if sender.send(line.unwrap()).is_err() {
                    break;
                }
            }
        });
        Self {
            input: child.stdin.take(),
            child,
            lines,
        }
    }

    fn ask(&mut self, line: &str) -> f64 {
        let input = self.input.as_mut().unwrap();
        input.write_all(line.as_bytes()).unwrap();
        input.flush().unwrap();
        let answer = self.lines.recv_timeout(Duration::from_secs(20));
        answer
            .expect("an answer without waiting for more input")
            .parse()
            .unwrap()
    }

    fn end(mut self) -> String {
        drop(self.input.take());
        let output = self.child.wait_with_output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(0), "{stderr}");
        stderr
    }
}

#[test]
fn the_device_is_pushed_back_by_an_object_on_either_side() {
    let first = forces(WALL, "-0.001\n0\n0.001\n");
    assert_eq!(first[0], 0.0);
    assert!(first[2] < -0.9, "{first:?}");
    let negative = forces(&format!("{WALL} --side negative"), "0.001\n0\n-0.001\n");
    assert_eq!(
        negative,
        first.iter().map(|force| -force).collect::<Vec<_>>()
    );
    let basic = forces(&format!("{WALL} --method basic"), "0.001\n0.0025\n");
    assert_eq!(basic, [-1.0, -2.5]);
}

#[test]
fn no_force_is_written_without_a_minus() {
    let answer = Folder::new().palpate_reading("-0.1\n-0.1\n", WALL);
    assert_eq!(answer.stdout, "0\n0\n0\n");
}

#[test]
fn every_method_gives_the_forces_of_the_library() {
    let positions: Vec<f64> = taps(0.01, 1.5).iter().map(|&(_, x)| x).collect();
    let input: String = positions.iter().map(|x| format!("{x}\n")).collect();
    let samples: Vec<_> = positions.iter().map(|&x| (None, x)).collect();
    for method in METHODS {
        let arguments = format!(
            "pipe --stiffness 400 --mass 0.1 --period 0.01 --force -0.981 --device-mass 0.25 \
             --method {method}"
        );
        let found = forces(&arguments, &input);
        assert_eq!(found, by_library(method, 0.1, &samples), "{method}");
        assert!(found.iter().any(|&force| force < -1.0), "{method}");
    }
}

#[test]
fn measured_times_are_used_as_they_are() {
    let mut t = 5.0;
    let mut input = String::from("t_s,position_m\n");
    let mut samples = Vec::new();
    let mut last = None;
    for (i, (_, x)) in taps(0.01, 1.0).into_iter().enumerate() {
        t += 0.01 + 0.004 * (i as f64).sin();
        input.push_str(&format!("{t}, {x}\n"));
        samples.push((last.map(|last| t - last), x));
        last = Some(t);
    }
    let arguments =
        "pipe --stiffness 400 --mass 0.1 --period 0.01 --force -0.981 --device-mass 0.25";
    let unmeasured: Vec<_> = samples.iter().map(|&(_, x)| (None, x)).collect();
    for (flag, method) in [("", "coupled"), (" --method hfcr", "hfcr")] {
        let found = forces(&format!("{arguments}{flag}"), &input);
        assert_eq!(found, by_library(method, 0.1, &samples), "{method}");
        assert_ne!(found, by_library(method, 0.1, &unmeasured), "{method}");
    }
}

#[test]
fn each_line_is_answered_before_the_next_is_written() {
    let mut pipe = Dialogue::start(WALL);
    for i in 0..50 {
        let force = pipe.ask(&format!("{}\n", f64::from(i) * 1e-4));
        assert!(
            if i == 0 { force == 0.0 } else { force < 0.0 },
            "{i}: {force}"
        );
    }
    assert_eq!(pipe.ask("what\n"), 0.0);
    assert!(pipe.ask("0.005\n") < 0.0);
    assert!(pipe.end().ends_with('\n'));
}

#[test]
fn a_line_that_is_no_sample_gets_no_force_and_the_pipe_lives_on() {
    let long = "1".repeat(10_000_000);
    let cases: [(&[u8], &str); 7] = [
        (b"hello", "\"hello\" is not a number"),
        (b"", "the line is empty"),
        (b"0.001,", "\"\" is not a number"),
        (b"nan", "position is not a finite number"),
        (b"inf", "position is not a finite number"),
        (b"\xff\xfe\x00\x01\x1b[31m", "is not a number"),
        (long.as_bytes(), "longer than 4096 bytes"),
    ];
    for (bad, message) in cases {
        let what = String::from_utf8_lossy(&bad[..bad.len().min(20)]);
        let input = [b"0.001\n0.002\n", bad, b"\n0.002\n0.0025\n"].concat();
        let (forces, messages, summary) = answers(&format!("{WALL} --method basic"), input);
        // The first sample after the gap is used unchanged.
        assert_eq!(forces, [-1.0, -2.0, 0.0, -2.0, -2.5], "{what}");
        assert_eq!(messages.len(), 1, "{what}: {messages:?}");
        assert!(messages[0].starts_with("line 3: "), "{what}: {messages:?}");
        assert!(messages[0].contains(message), "{what}: {messages:?}");
        assert!(messages[0].ends_with("; the force is 0"), "{messages:?}");
        assert!(
            !messages[0].contains('\x1b'),
            "a terminal is not at the input's mercy"
        );
        assert!(summary.starts_with("5 samples, 1 refused"), "{summary}");
    }
}

/// A caller that checks only the exit code has to learn that no force was rendered.
#[test]
fn a_pipe_that_refused_every_line_does_not_end_well() {
    for (input, code) in [("x\nnan\n", 5), ("x\n0.001\n", 0), ("", 0)] {
        let answer = Folder::new().palpate_reading(input, WALL);
        assert_eq!(answer.code, code, "{input:?}: {answer:?}");
        let said = answer.stderr.contains("every line was rejected");
        assert_eq!(said, code == 5, "{answer:?}");
    }
}

#[test]
fn a_dead_sensor_does_not_flood_standard_error() {
    let input = "nan\n".repeat(3000) + "0\n";
    let (forces, messages, summary) = answers(WALL, input);
    assert_eq!(forces.len(), 3001);
    // The first 8, then 16, 32, ... 2048.
    assert_eq!(messages.len(), 8 + 8, "{messages:#?}");
    let last = messages.last().unwrap();
    assert!(last.starts_with("line 2048: "), "{last}");
    assert!(
        last.contains("refused so far: 2048; next message at 4096"),
        "{last}"
    );
    assert!(
        summary.starts_with("3001 samples, 3000 refused"),
        "{summary}"
    );
}

#[test]
fn a_jump_is_refused_and_the_next_line_starts_afresh() {
    let (forces, messages, _) = answers(&format!("{WALL} --method basic"), "0.001\n0.5\n0.5\n");
    assert_eq!(forces, [-1.0, 0.0, -500.0]);
    assert!(messages[0].contains("line 2: ") && messages[0].contains("speed limit"));
}

#[test]
fn a_clock_that_goes_wrong_costs_a_line_or_two_and_no_more() {
    let basic = format!("{WALL} --method basic --time");
    let cases = [
        ("twice the same", "0.002,0.002", 1),
        ("back", "0.0005,0.002", 1),
        ("set to zero", "-1000,0.002", 2),
        ("far ahead", "1e9,0.002", 2),
        ("none", "nan,0.002", 1),
    ];
    for (what, wrong, refused) in cases {
        let input =
            format!("0.001,0.002\n0.002,0.002\n{wrong}\n0.003,0.002\n0.004,0.002\n0.005,0.002\n");
        let (forces, messages, _) = answers(&basic, input);
        let mut expected = vec![-2.0; 6];
        expected[2..2 + refused].fill(0.0);
        assert_eq!(forces, expected, "{what}: {messages:?}");
        assert_eq!(messages.len(), refused, "{what}: {messages:?}");
        assert!(
            messages
                .iter()
                .all(|message| message.contains("time since") || message.contains("the time is")),
            "{messages:?}"
        );
    }
}

#[test]
fn a_header_gets_no_answer() {
    for header in [
        "t_s,position_m\n",
        "position_m\r\n",
        "\u{feff}t_s,position_m\r\n",
    ] {
        let row = if header.contains("t_s") {
            "0,0.001\n"
        } else {
            "0.001\n"
        };
        let found = forces(&format!("{WALL} --method basic"), format!("{header}{row}"));
        assert_eq!(found, [-1.0], "{header:?}");
    }
}

#[test]
fn a_header_of_other_columns_is_not_guessed_at() {
    for header in [
        "position_m,t_s",
        "t_s,position_m,force_n",
        "t_s",
        "position_in",
    ] {
        let answer = Folder::new().palpate_reading(format!("{header}\n0,1\n"), WALL);
        assert_eq!(answer.code, 3, "{header}: {answer:?}");
        assert_eq!(answer.stdout, "", "{header}");
        assert!(
            answer.stderr.contains("unknown columns in the header"),
            "{answer:?}"
        );
    }
    // Blanks around the names are allowed.
    assert_eq!(forces(WALL, "t_s, position_m\n0,0\n"), [0.0]);
}

#[test]
fn lines_may_end_as_on_windows() {
    assert_eq!(
        forces(&format!("{WALL} --method basic"), "0.001\r\n0.002\r\n"),
        [-1.0, -2.0]
    );
    assert_eq!(forces(WALL, ""), [0.0; 0]);
}

/// Returns the end of a pipe to a device of 0.2 kg under 0.5 N that feels each force half a period later than modelled.
fn end_of_a_late_device(flags: &str) -> String {
    const PERIOD: f64 = 1e-3;
    let mut pipe = Dialogue::start(&format!(
        "pipe --stiffness 400 --mass 0.1 --period {PERIOD} --device-mass 0.2 --object-position 0.005 {flags}"
    ));
    let (mut position, mut velocity, mut last) = (0.004, 0.05, 0.0);
    for _ in 0..400 {
        let force = pipe.ask(&format!("{position:.12}\n"));
        for held in [last, force] {
            let acceleration = (held + 0.5) / 0.2;
            let time = 0.5 * PERIOD;
            position += velocity * time + 0.5 * acceleration * time * time;
            velocity += acceleration * time;
        }
        last = force;
    }
    pipe.end()
}

#[test]
fn the_end_says_which_lateness_was_learned() {
    let end = end_of_a_late_device("--delay-deviation 0.0003");
    assert!(end.contains("; estimated: commands begin 0.50"), "{end}");
    let json = parse(&end_of_a_late_device("--delay-deviation 0.0003 --json"));
    let learned = number(&json, "learned_lateness_s");
    assert!((learned - 5e-4).abs() < 5e-6, "{learned}");
    let end = end_of_a_late_device("");
    assert!(!end.contains("estimated"), "{end}");
}

#[test]
fn the_end_is_summed_up() {
    let basic = format!("{WALL} --method basic");
    let input = "0.001\n0.002\nx\n0.003\n0.004\n";
    let (_, messages, summary) = answers(&basic, input);
    assert_eq!(messages.len(), 1);
    assert!(
        summary.starts_with("5 samples, 1 refused, 0 forces limited; leak "),
        "{summary}"
    );
    let (_, _, json) = answers(&format!("{basic} --force-limit 2.5 --json"), input);
    let json = parse(&json);
    assert_eq!(json["format"], "palpate pipe 1");
    let counts = ["samples", "refused", "limited"].map(|field| number(&json, field));
    assert_eq!(counts, [5.0, 1.0, 2.0]);
    // A millimetre into a wall leaks K d^2 / 2; at the force limit there is no leak, because the wall yields with that
    // force.
    for field in ["leak_original_j", "leak_held_j"] {
        assert!((number(&json, field) - 0.0005).abs() < 1e-12, "{json}");
    }
    for field in ["stored_energy_j", "port_work_j"] {
        assert!(number(&json, field).is_finite(), "{field}");
    }
}

#[test]
fn an_interval_beyond_the_acceleration_of_the_guard_is_shown_and_counted() {
    let guarded =
        format!("{WALL} --guard report --guard-acceleration 80 --columns device_position,limited");
    // 0.2 mm more within a millisecond is 200 m/s^2.
    let input = "-0.001\n-0.001\n-0.0008\n-0.0006\n";
    let answer = Folder::new().palpate_reading(input, &unlimited(&guarded));
    assert_eq!(answer.code, 0, "{answer:?}");
    let lines: Vec<_> = answer.stdout.lines().take(4).collect();
    let expected = ["-0.001,", "-0.001,", "-0.0008,beyond-guard", "-0.0006,"];
    assert_eq!(lines, expected);
    let told = answer.stderr.matches("the device accelerated beyond");
    assert_eq!(told.count(), 1, "{answer:?}");
    assert!(
        answer.stderr.contains("0 forces limited;")
            && answer
                .stderr
                .contains("; 1 interval beyond the acceleration of the guard"),
        "{answer:?}"
    );
}

#[test]
fn delay_changes_ledger_but_not_forces() {
    let input = "0.001\n0.002\n0.003\n";
    let delayed = format!("{WALL} --method basic --delay-periods 1");
    let now = answers(&format!("{WALL} --method basic --json"), input);
    let late = answers(&format!("{delayed} --json"), input);
    assert_eq!(now.0, late.0);
    let leaks = [now.2, late.2].map(|json| number(&parse(&json), "leak_held_j"));
    // 1 N less over the two millimetres, and K d^2 / 2 for each.
    assert!(
        (leaks[0] - 0.001).abs() < 1e-12 && (leaks[1] - 0.003).abs() < 1e-12,
        "{leaks:?}"
    );
}

#[test]
fn a_hundred_thousand_lines_take_seconds() {
    let input: String = (0..100_000)
        .map(|i| format!("{}\n", 0.01 * (f64::from(i) * 0.01).sin()))
        .collect();
    let begun = Instant::now();
    let forces = forces(
        "pipe --stiffness 400 --mass 0.1 --period 0.001 --device-mass 0.25",
        input,
    );
    assert_eq!(forces.len(), 100_000);
    assert!(
        begun.elapsed() < Duration::from_secs(10),
        "{:?}",
        begun.elapsed()
    );
}

#[test]
fn a_reader_that_leaves_ends_the_pipe_in_peace() {
    let mut pipe = Dialogue::start(WALL);
    pipe.ask("0.001\n");
    let Dialogue {
        mut child,
        input,
        lines,
    } = pipe;
    drop(lines);
    let mut input = input.unwrap();
    // Its thread drops the other end at the next answer.
    while input.write_all(b"0.001\n").is_ok() {
        std::thread::sleep(Duration::from_millis(1));
    }
    drop(input);
    let status = child.wait().unwrap();
    assert_eq!(status.code(), Some(0));
}

#[cfg(target_os = "linux")]
#[test]
fn a_standard_error_that_is_full_does_not_stop_the_pipe() {
    let full = std::fs::OpenOptions::new()
        .write(true)
        .open("/dev/full")
        .unwrap();
    let mut child = Command::new(env!("CARGO_BIN_EXE_palpate"))
        .args(WALL.split_whitespace())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(full)
        .spawn()
        .unwrap();
    child
        .stdin
        .take()
        .unwrap()
        .write_all(b"0.001\nbad\nbad\n0.001\n")
        .unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(String::from_utf8(output.stdout).unwrap().lines().count(), 5);
}

#[test]
fn one_method_and_the_contact_are_needed() {
    let folder = Folder::new();
    folder.fail(
        &format!("{WALL} --method all"),
        2,
        &["one method", "--method"],
    );
    folder.fail(
        "pipe --mass inf --period 0.001",
        2,
        &["pipe needs --stiffness <N/m>"],
    );
    folder.fail(
        "pipe --stiffness 1 --period 0.001",
        2,
        &["pipe needs --mass <kg|inf>"],
    );
    folder.fail(
        "pipe --stiffness 1 --mass inf",
        2,
        &["pipe needs --period <s>"],
    );
}

#[test]
fn coupled_asks_for_the_mass_it_needs() {
    let contact = "pipe --stiffness 1000 --mass inf --period 0.001";
    let folder = Folder::new();
    folder.fail(
        contact,
        2,
        &[
            "coupled needs --device-mass <kg>",
            "above 0 and accurate within a factor of 2",
            "--scene <SCENE.toml>",
            "--method hfcr, which needs none",
        ],
    );
    folder.fail(
        &format!("{contact} --method hfcr --prediction observer"),
        2,
        &["hfcr needs --device-mass", "--prediction last-step"],
    );
    folder.fail(
        &format!("{contact} --device-mass 0"),
        2,
        &["--device-mass is 0 kg", "finite and greater than 0"],
    );
    assert_eq!(forces(&format!("{contact} --method hfcr"), "0\n"), [0.0]);
}

#[test]
fn a_scene_says_what_flags_would() {
    let positions: Vec<f64> = taps(0.01, 1.0).iter().map(|&(_, x)| x).collect();
    let input: String = positions.iter().map(|x| format!("{x}\n")).collect();
    let folder = Folder::new();
    let scene = r#"format = 2
title = "A block"
loop = { period_s = 0.01, delay_samples = 1 }
measure = { duration_s = 1 }

[[device]]
name = "device"
axes = ["x"]
mass_kg = 0.25
quantum_m = 1e-5

[[body]]
name = "block"
axes = ["x"]
mass_kg = 0.1
position_m = [0.001, 0, 0]
force_n = [-0.981, 0, 0]
shape = { half_space = { normal = [-1, 0, 0] } }

[[contact]]
between = ["device", "block"]
stiffness_n_per_m = 400
"#;
    folder.write("block.toml", scene);
    folder.write(
        "model.toml",
        format!("{scene}\n[render]\nmethod = \"hfcr\"\n\n[model]\ndevice_mass_kg = 0.3\n"),
    );
    let flags = "pipe --stiffness 400 --mass 0.1 --object-position 0.001 --force -0.981 \
                 --encoder-quantum 1e-5 --period 0.01 --delay-periods 1";
    let same = |by_scene: &str, by_flags: &str| {
        let by_scene = folder.palpate_reading(&input, by_scene);
        let by_flags = folder.palpate_reading(&input, &format!("{flags} {by_flags}"));
        assert_eq!(by_scene.code, 0, "{by_scene:?}");
        assert_eq!(
            (&by_scene.stdout, &by_scene.stderr),
            (&by_flags.stdout, &by_flags.stderr)
        );
        by_scene.stdout
    };
    let block = same("pipe --scene block.toml", "--device-mass 0.25");
    let model = same(
        "pipe --scene model.toml --method coupled",
        "--device-mass 0.3",
    );
    assert_ne!(block, model);
    same("pipe --scene model.toml", "--device-mass 0.3 --method hfcr");
    // Flags override the scene.
    same(
        "pipe --scene model.toml --method coupled --device-mass 0.2",
        "--device-mass 0.2",
    );
}
