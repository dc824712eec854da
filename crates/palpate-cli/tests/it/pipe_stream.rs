//! `palpate pipe`: input and output, line by line.

use std::io::{BufRead, BufReader, Write};
use std::process::Stdio;

use crate::common::running::{Running, program};
use crate::common::{Answer, Folder, number, parse, unlimited};

const WALL: &str = "pipe --stiffness 1000 --mass inf --period 0.001 --method basic";

fn pipe(arguments: &str, input: &str) -> Answer {
    Folder::new().palpate_reading(input, &unlimited(arguments))
}

/// Rows of numbers, without the last line.
fn rows(answer: &Answer) -> Vec<Vec<f64>> {
    assert_eq!(answer.code, 0, "{answer:?}");
    let mut rows: Vec<Vec<f64>> = answer
        .stdout
        .lines()
        .map(|line| {
            line.split(',')
                .map(|field| field.parse().unwrap())
                .collect()
        })
        .collect();
    assert_eq!(rows.pop().unwrap()[0], 0.0, "{answer:?}");
    rows
}

#[test]
fn columns_come_in_the_order_they_are_asked_for() {
    let arguments = format!("{WALL} --columns time,phase,penetration,force,fault --header");
    let answer = pipe(&arguments, "-0.001\n0.001\nwhat\n");
    assert_eq!(
        answer.stdout,
        "t_s,phase,penetration_m,force_on_device_n,fault\n\
         0,free,-0.001,0,\n\
         0.001,contact,0.001,-1,\n\
         0.002,waiting,0,0,unreadable\n\
         0.002,ended,0,0,\n"
    );
    // With a unit or without, it is the same column.
    let by_unit =
        format!("{WALL} --columns t_s,phase,penetration_m,force_on_device_n,fault --header");
    let by_unit = pipe(&by_unit, "-0.001\n0.001\nwhat\n");
    assert_eq!(by_unit.stdout, answer.stdout);
}

#[test]
fn every_column_has_a_name_with_its_unit_and_a_value() {
    let all = "force,force_on_object,time,device_position,object_position,object_velocity,\
               penetration,proxy_shift,phase,stored_energy,port_work,virtual_force_work,\
               outside_work,leak_original,leak_held,limited,fault";
    let answer = pipe(
        &format!(
            "pipe --stiffness 400 --mass 0.1 --period 0.01 --method hfcr --force -0.5 \
                  --columns {all} --header --force-limit 0.1"
        ),
        "0.001\n0.002\n0.003\n",
    );
    let mut lines = answer.stdout.lines();
    let header = lines.next().unwrap();
    assert_eq!(
        header,
        "force_on_device_n,force_on_object_n,t_s,device_position_m,object_position_m,\
         object_velocity_m_per_s,penetration_m,proxy_shift_m,phase,stored_energy_j,\
         port_work_j,virtual_force_work_j,outside_work_j,leak_original_j,leak_held_j,limited,fault"
    );
    let lines: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert_eq!(lines.len(), 4);
    assert_eq!(lines[1][0], "-0.1");
    assert_eq!(lines[1][3], "0.002");
    assert_eq!(lines[1][15], "force");
    let last: Vec<f64> = [9, 10, 11, 12, 14]
        .map(|column| lines[2][column].parse().unwrap())
        .to_vec();
    let stored: f64 = lines[0][9].parse().unwrap();
    // The energy ledger balances.
    assert!((last[0] - stored - last[1..].iter().sum::<f64>()).abs() < 1e-12);
}

#[test]
fn a_column_that_is_not_there_is_answered_by_those_that_are() {
    let folder = Folder::new();
    for (columns, words) in [
        (
            "force,colour",
            &["\"colour\"", "force, force_on_object, time"][..],
        ),
        (
            "force,penetratoin",
            &[
                "did you mean \"penetration\"?",
                "leak_held, slope, limited, fault",
            ],
        ),
        ("force,force_on_device_n", &["force is named twice"]),
        ("", &["columns are"]),
    ] {
        let arguments = format!("{WALL} --columns={columns}");
        folder.fail(&arguments, 2, &[words, &["--columns"]].concat());
    }
}

#[test]
fn a_change_comes_in_over_a_tenth_of_a_second_and_is_booked() {
    let hold = |count: usize| "0.001\n".repeat(count);
    let input = hold(10) + "set stiffness_n_per_m=10000\n" + &hold(150);
    let answer = pipe(
        &format!("{WALL} --stiffness 100 --columns force,outside_work,port_work")
            .replace("--stiffness 1000 ", ""),
        &input,
    );
    let rows = rows(&answer);
    assert_eq!(rows.len(), 160, "a change is no sample");
    assert_eq!(rows[9][0], -0.1);
    // In equal ratios: the midpoint from 100 to 10000 is 1000, after half of the 100 samples.
    let force = |at: usize| -rows[9 + at][0];
    assert!((force(50) - 1.0).abs() < 1e-9, "{}", force(50));
    assert!((force(100) - 10.0).abs() < 1e-9, "{}", force(100));
    let largest = (1..150)
        .map(|at| force(at) / force(at - 1))
        .fold(0.0, f64::max);
    assert!(largest < 1.05, "no step: {largest}");
    // K d^2 / 2 more, without motion.
    let (outside, port) = (rows[159][1], rows[159][2]);
    assert!((outside - 0.00495).abs() < 1e-9, "{outside}");
    assert_eq!(port, 0.0);
    assert!(
        answer
            .stderr
            .contains("line 11: set stiffness_n_per_m=10000, reached over 0.1 s"),
        "{answer:?}"
    );
    assert!(answer.stderr.contains("1 change made"), "{answer:?}");
}

#[test]
fn mass_and_virtual_force_can_be_changed_too() {
    let block = "pipe --stiffness 400 --mass 0.1 --period 0.01 --method hfcr --object-position 0.01 \
                 --columns force,object_position";
    let still = "0\n".repeat(60);
    let input = format!("0\nset virtual_force_n=-0.5 mass_kg=0.2\n{still}");
    let rows = rows(&pipe(block, &input));
    assert_eq!(rows[1][1], 0.01, "it rests until it is pushed");
    assert!(rows[60][1] < 0.009, "it falls towards the device: {rows:?}");
    let wall = format!("0\nset mass_kg=inf\n{still}");
    assert_eq!(pipe(block, &wall).code, 0);
}

/// The virtual force of a sample acts on the object over the interval that it begins: 0.2 N on 0.1 kg for 10 ms move it
/// by 0.1 mm.
#[test]
fn each_sample_may_have_a_virtual_force() {
    let block = "pipe --stiffness 400 --mass 0.1 --period 0.01 --method hfcr --object-position 0.01 \
                 --columns force,object_position";
    let rows = rows(&pipe(
        block,
        "position_m,virtual_force_n\n0,0\n0,0.2\n0,-0.4\n0,0\n",
    ));
    let expected = [0.01, 0.01, 0.0101, 0.0101];
    let positions: Vec<f64> = rows.iter().map(|row| row[1]).collect();
    assert_eq!(positions.len(), expected.len(), "{rows:?}");
    for (found, expected) in positions.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-12, "{positions:?}");
    }
}

#[test]
fn a_damping_can_be_changed_too() {
    let damped = "pipe --stiffness 400 --mass inf --period 0.001 --method virtual-damper --damping 0 \
                  --columns force";
    let moving: String = (0..300)
        .map(|i| format!("{}\n", 1e-5 * f64::from(i)))
        .collect();
    let constant = rows(&pipe(damped, &moving));
    let changed = rows(&pipe(
        damped,
        &format!("0\nset damping_n_s_per_m=2\n{moving}"),
    ));
    // 0.01 m/s against 2 N s/m, long after the change.
    let added = changed[290][0] - constant[289][0];
    assert!((added + 0.02).abs() < 1e-9, "{added}");
    let negative = pipe(damped, "0\nset damping_n_s_per_m=-1\n0\n");
    assert!(
        negative
            .stderr
            .contains("damping_n_s_per_m is -1 N s/m, but must be finite and not below 0"),
        "{negative:?}"
    );
}

#[test]
fn a_change_that_cannot_be_made_changes_nothing() {
    let cases = [
        (
            "set stiffness_n_per_m=-4",
            "stiffness_n_per_m is -4 N/m, but must be finite and greater",
        ),
        (
            "set stiffness_n_per_m=800 mass_kg=0",
            "mass_kg is 0 kg, but must be finite and greater",
        ),
        (
            "set virtual_force_n=inf",
            "virtual_force_n is inf N, but must be finite",
        ),
        ("set stiffness=800", "did you mean stiffness_n_per_m?"),
        (
            "set damping_n_s_per_m=1",
            "damping_n_s_per_m is for virtual-damper, energy-tank, virtual-coupling, hfcr, not for",
        ),
        ("set stiffness_n_per_m=0,8", "must be a number"),
        ("set", "`set` has no values"),
    ];
    for (line, why) in cases {
        let answer = pipe(WALL, &format!("0.001\n{line}\n{}", "0.001\n".repeat(150)));
        let rows = rows(&answer);
        assert_eq!(rows.len(), 151, "{line}");
        assert!(rows.iter().all(|row| row[0] == -1.0), "{line}");
        let said = "line 2: set is refused and has no effect: ";
        assert!(answer.stderr.contains(said), "{line}: {answer:?}");
        assert!(answer.stderr.contains(why), "{line}: {answer:?}");
    }
}

#[test]
fn a_standard_error_that_nobody_reads_does_not_stop_the_forces() {
    let folder = Folder::new();
    let mut child = Running::start(
        program(&folder, &unlimited(WALL))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped()),
    );
    let mut input = child.stdin.take().unwrap();
    let output = BufReader::new(child.stdout.take().unwrap());
    let (sender, answers) = std::sync::mpsc::channel();
    let reader = std::thread::spawn(move || {
        for line in output.lines() {
            // The last line may have no receiver.
            let _ = sender.send(line.unwrap());
        }
    });
    // The pipe buffer of the system is 64 KiB; this output is some 300 KiB.
    for _ in 0..5000 {
        input.write_all(b"set virtual_force_n=1\n0.001\n").unwrap();
        let answer = answers.recv_timeout(std::time::Duration::from_secs(20));
        assert_eq!(answer.as_deref(), Ok("-1"));
    }
    drop(input);
    let end = child.output();
    assert_eq!(end.status.code(), Some(0));
    drop(answers);
    reader.join().unwrap();
}

#[test]
fn positions_come_in_the_unit_that_is_said() {
    let millimetres = pipe(&format!("{WALL} --unit mm"), "1\n2.5\n");
    assert_eq!(millimetres.stdout, "-1\n-2.5\n0\n");
    assert_eq!(
        pipe(WALL, "position_mm\n1\n2.5\n").stdout,
        millimetres.stdout
    );
    let timed = pipe(&format!("{WALL} --unit cm --time"), "0,0.1\n0.001,0.25\n");
    assert_eq!(timed.stdout, millimetres.stdout);
    let folder = Folder::new();
    folder.fail(
        &format!("{WALL} --unit inch"),
        2,
        &["--unit", "m, cm, mm, um"],
    );
    let both = pipe(&format!("{WALL} --unit mm"), "position_cm\n1\n");
    assert_eq!(both.code, 3, "{both:?}");
    assert!(
        both.stderr.contains("the unit cm") && both.stderr.contains("--unit is mm"),
        "{both:?}"
    );
}

#[test]
fn a_motion_that_no_hand_makes_ends_the_pipe_unless_it_is_meant() {
    // 3 mm to and fro in half a second, taken as metres.
    let input: String = (0..3000)
        .map(|i| format!("{}\n", 3.0 * (f64::from(i) * 0.0126).sin()))
        .collect();
    let limited = WALL.to_owned() + " --force-limit 20";
    let refused = pipe(&limited, &input);
    assert_eq!(refused.code, 3, "{refused:?}");
    assert!(refused.stdout.ends_with("\n0\n"), "{}", refused.stdout);
    for words in [
        "m path in",
        "is the unit mm?",
        "--unit mm",
        "in metres, pass --unit m",
    ] {
        assert!(refused.stderr.contains(words), "{}", refused.stderr);
    }
    let answered = |arguments: &str| {
        let answer = pipe(arguments, &input);
        assert_eq!(answer.code, 0, "{answer:?}");
        answer.stdout.lines().count()
    };
    assert_eq!(answered(&format!("{limited} --unit mm")), 3001);
    // Out of reach of the wall: the energy check stops a contact at 38 m/s.
    let out_of_reach = format!("{limited} --unit m --object-position 4");
    assert_eq!(answered(&out_of_reach), 3001);
}

#[test]
fn the_example_in_python_does_what_it_says() {
    let docs = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/reference/pipe.md");
    let docs = std::fs::read_to_string(docs).unwrap();
    let example = docs.split("```python\n").nth(1).unwrap();
    let example = example.split("```").next().unwrap();
    let folder = Folder::new();
    folder.write(
        "example.py",
        format!("{example}print(object_position > 0.005)\n"),
    );
    let program = std::path::Path::new(env!("CARGO_BIN_EXE_palpate"));
    let path = std::env::var_os("PATH").unwrap_or_default();
    let mut folders = vec![program.parent().unwrap().to_owned()];
    folders.extend(std::env::split_paths(&path));
    let ran = std::process::Command::new("python3")
        .arg(folder.path("example.py"))
        .env("PATH", std::env::join_paths(folders).unwrap())
        .output();
    let Ok(ran) = ran else {
        eprintln!("skipped: there is no python3");
        return;
    };
    let stderr = String::from_utf8_lossy(&ran.stderr);
    assert!(ran.status.success(), "{stderr}");
    assert_eq!(
        String::from_utf8_lossy(&ran.stdout).trim(),
        "True",
        "{stderr}"
    );
    let taken = "set stiffness_n_per_m=800, reached over 0.1 s";
    assert!(stderr.contains(taken), "{stderr}");
}

#[test]
fn the_summary_counts_changes() {
    let answer = pipe(&format!("{WALL} --json"), "0\nset mass_kg=1\n0\n");
    let summary = parse(answer.stderr.lines().last().unwrap());
    assert_eq!(summary["format"], "palpate pipe 1");
    assert_eq!(number(&summary, "changes"), 1.0);
    assert_eq!(number(&summary, "samples"), 2.0);
    assert!(summary["force_limit_n"].is_null(), "{summary}");
}

#[test]
fn a_last_line_without_a_newline_is_no_sample() {
    // The rest of 0.0015 would command another force.
    let answer = pipe(&format!("{WALL} --columns force,fault"), "0.001\n0.001");
    assert_eq!(answer.code, 0, "{answer:?}");
    assert_eq!(answer.stdout, "-1,\n0,unreadable\n0,\n", "{answer:?}");
    assert!(
        answer
            .stderr
            .contains("line 2: the input ends within the line"),
        "{answer:?}"
    );
    // With its newline the same line is a sample.
    let whole = pipe(&format!("{WALL} --columns force,fault"), "0.001\n0.001\n");
    assert_eq!(whole.stdout, "-1,\n-1,\n0,\n", "{whole:?}");
}
