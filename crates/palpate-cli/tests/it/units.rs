//! Units of recorded positions: from the column or a flag, with a plausibility check of the motion.

use crate::common::{Folder, number, of_method, taps};

const CONTACT: &str = "--stiffness 400 --mass 0.1 --period 0.01 --force -0.981 --method basic";

/// Taps of 20 mm, as a trace with a column called `name`, which holds `factor` times metres.
fn trace(name: &str, factor: f64) -> String {
    let lines: String = taps(0.01, 3.0)
        .iter()
        .map(|(t, x)| format!("{t},{}\n", x * factor))
        .collect();
    format!("t_s,{name}\n{lines}")
}

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("metres.csv", trace("position_m", 1.0));
    folder.write("wrong.csv", trace("position_m", 1000.0));
    folder.write("named.csv", trace("position_mm", 1000.0));
    folder
}

#[test]
fn millimetres_in_a_column_of_metres_are_refused_with_the_flag_that_reads_them() {
    let folder = folder();
    folder.fail(
        &format!("render wrong.csv {CONTACT}"),
        3,
        &[
            "wrong.csv",
            "m path in 3 s",
            "is the unit mm?",
            "--unit mm",
            "in metres, pass --unit m",
        ],
    );
    // An explicit unit is accepted.
    let meant = folder.palpate(&format!("render wrong.csv {CONTACT} --unit m"));
    assert_eq!(meant.code, 0, "{meant:?}");
}

#[test]
fn a_trace_is_the_same_in_any_unit() {
    let folder = folder();
    let leak = |arguments: &str| {
        let report = folder.json(&format!("render {arguments} {CONTACT}"));
        number(of_method(&report, "basic"), "leak_held_j")
    };
    let metres = leak("metres.csv");
    for arguments in ["wrong.csv --unit mm", "named.csv", "named.csv --unit mm"] {
        let found = leak(arguments);
        assert!(
            (found - metres).abs() < 1e-9 * metres.abs(),
            "{arguments}: {found} {metres}"
        );
    }
    folder.fail(
        &format!("render named.csv {CONTACT} --unit cm"),
        3,
        &["no column `position_m`", "position_mm"],
    );
}

#[test]
fn a_recorded_device_takes_the_unit_of_its_motion() {
    let folder = folder();
    folder.write("wall.toml", crate::common::experiment_text("wall"));
    let run = "run wall.toml --fast --duration 0.2 --device replay --motion";
    folder.fail(
        &format!("{run} wrong.csv"),
        3,
        &["is the unit mm?", "--unit mm"],
    );
    for motion in ["wrong.csv --unit mm", "named.csv"] {
        let answer = folder.palpate(&format!("{run} {motion}"));
        assert_eq!(answer.code, 0, "{motion}: {answer:?}");
    }
    folder.fail("run wall.toml --unit mm", 2, &["--unit", "--motion"]);
    crate::recordings::record(&folder.path("tap.mcap"));
    folder.fail(
        &format!("{run} tap.mcap --unit mm"),
        2,
        &["--unit is for a trace", "metres"],
    );
}

/// A table of a recorder: milliseconds and millimetres, semicolons, decimal commas, additional columns.
#[test]
fn a_recorders_table_is_read_as_flags_say_and_never_guessed() {
    let folder = folder();
    let lines: String = taps(0.01, 3.0)
        .iter()
        .map(|(t, x)| format!("{};grip;{};7\n", 1000.0 * t, 1000.0 * x).replace('.', ","))
        .collect();
    folder.write("recorder.csv", format!("time;note;X;Y\n{lines}"));
    let render = format!("render recorder.csv {CONTACT}");
    let metres = folder.json(&format!("render metres.csv {CONTACT}"));
    let flags = "--columns t=time,x=X --decimal-comma --unit mm";
    for (given, words) in [
        ("", "--columns t=NAME,x=NAME"),
        ("--columns t=time,x=X", "--decimal-comma"),
        (flags, "--time-unit ms"),
        (
            "--columns t=time,x=X --decimal-comma --time-unit ms",
            "--unit mm",
        ),
    ] {
        folder.fail(&format!("{render} {given}"), 3, &["recorder.csv", words]);
    }
    folder.fail(
        &format!("{render} --columns w=X"),
        2,
        &["--columns", "allowed: t, x, force"],
    );
    let report = folder.json(&format!("{render} {flags} --time-unit ms"));
    let leak = |report| number(of_method(report, "basic"), "leak_held_j");
    let (found, right) = (leak(&report), leak(&metres));
    assert!(
        (found - right).abs() < 1e-9 * right.abs(),
        "{found} {right}"
    );
    folder.write("wall.toml", crate::common::experiment_text("wall"));
    let run = "run wall.toml --fast --duration 0.2 --device replay --motion recorder.csv";
    let answer = folder.palpate(&format!("{run} {flags} --time-unit ms"));
    assert_eq!(answer.code, 0, "{answer:?}");
    folder.fail(
        "run wall.toml --skip-missing",
        2,
        &["--skip-missing", "--motion"],
    );
}

#[test]
fn gaps_samples_without_a_value_and_a_number_that_may_be_cut_off_are_said() {
    let folder = Folder::new();
    let mut lines: Vec<String> = taps(0.01, 3.0)
        .iter()
        .map(|(t, x)| format!("{t},{x}"))
        .collect();
    lines.drain(100..130);
    let table = |lines: &[String]| format!("t_s,position_m\n{}\n", lines.join("\n"));
    folder.write("gap.csv", table(&lines));
    let render = format!("render gap.csv {CONTACT}");
    let json = |render: &str| -> serde_json::Value {
        let answer = folder.palpate(&format!("{render} --json"));
        serde_json::from_str(&answer.stdout).unwrap_or_else(|_| panic!("{answer:?}"))
    };
    let report = json(&render);
    let motion = &report["motion"];
    assert!(
        (number(motion, "longest_gap_s") - 0.31).abs() < 1e-9,
        "{motion}"
    );
    assert!(
        (number(motion, "longest_gap_from_s") - 0.99).abs() < 1e-9,
        "{motion}"
    );
    let share = 100.0 * 30.0 / (lines.len() + 30) as f64;
    assert!(
        (number(motion, "interpolated_percent") - share).abs() < 1e-9,
        "{motion}"
    );
    let answer = folder.palpate(&render);
    assert!(
        answer
            .stderr
            .contains("warning: gap.csv: no sample was recorded for 0.310 s"),
        "{answer:?}"
    );
    assert!(
        answer.stdout.contains("the longest gap is 0.310 s"),
        "{answer:?}"
    );

    lines[50] = lines[50].split_once(',').unwrap().0.to_owned() + ",";
    folder.write("gap.csv", table(&lines));
    folder.fail(&render, 3, &["gap.csv:52:", "--skip-missing"]);
    let report = json(&format!("{render} --skip-missing"));
    assert_eq!(report["motion"]["samples_left_out"], 1);

    let cut = table(&lines[..40]);
    folder.write("gap.csv", &cut[..cut.len() - 3]);
    let answer = folder.palpate(&render);
    assert!(answer.stderr.contains("may be cut off"), "{answer:?}");
    // A scene rejects a unit.
    folder.write(
        "hand.toml",
        crate::common::experiment_text("wall").replace(
            "force_n = [2.0, 0.0, 0.0]\n",
            "stiffness_n_per_m = 100\nrest_file = \"gap.csv\"\n",
        ),
    );
    folder.fail("simulate hand.toml", 3, &["may be cut off"]);
}

#[test]
fn an_intention_that_no_hand_has_is_doubted() {
    let folder = folder();
    let scene = crate::common::experiment_text("wall");
    let hand = "force_n = [2.0, 0.0, 0.0]\n";
    assert!(scene.contains(hand));
    for (file, is_doubted) in [
        ("wrong.csv", true),
        ("named.csv", false),
        ("metres.csv", false),
    ] {
        folder.write(
            "scene.toml",
            scene.replace(
                hand,
                &format!(
                    "stiffness_n_per_m = 100\ndamping_n_s_per_m = 2\nrest_file = \"{file}\"\n"
                ),
            ),
        );
        let answer = folder.palpate("run scene.toml --fast --duration 0.05");
        // A device that moves by metres exceeds the speed limit: the motors are off for most of the run.
        let code = if is_doubted { 5 } else { 0 };
        assert_eq!(answer.code, code, "{answer:?}");
        let said = answer.stderr.contains("device.hand.rest_file")
            && answer.stderr.contains("position_mm");
        assert_eq!(said, is_doubted, "{file}: {answer:?}");
    }
}

/// The hands of worlds are doubted, too, along any axis.
#[test]
fn an_intention_of_a_world_that_no_hand_has_is_doubted() {
    let folder = folder();
    let scene = crate::common::experiment_text("worlds/paddle");
    let rest = "rest_m = [0.0, 0.0, 0.0]";
    assert!(scene.contains(rest));
    for (file, factor) in [("metres.csv", 1.0), ("wrong.csv", 1000.0)] {
        let path = trace("x_m,y_m,z_m", factor);
        let (header, rows) = path.split_once('\n').unwrap();
        let rows = rows.lines().map(|row| row.replacen(',', ",0,0,", 1) + "\n");
        folder.write(file, format!("{header}\n{}", rows.collect::<String>()));
        let recorded = scene.replace(rest, &format!("rest_file = \"{file}\""));
        folder.write("scene.toml", recorded);
        let answer = folder.palpate("simulate scene.toml --set measure.duration_s=0.05");
        let said = answer.stderr.contains("device.hand.rest_file of")
            && answer
                .stderr
                .contains("name its columns x_mm, y_mm and z_mm");
        assert_eq!(said, factor > 1.0, "{file}: {answer:?}");
    }
}

#[test]
fn a_period_that_is_likely_to_be_in_milliseconds_is_questioned() {
    let folder = folder();
    folder.write("scene.toml", crate::common::experiment_text("fig2"));
    // The proxy's mass of the virtual coupling would be too small for this period.
    let slow = crate::common::experiment_text("fig2")
        .replace("period_s = 0.01", "period_s = 1")
        .replace("coupling_mass_kg = 0.00191\n", "");
    folder.write("slow.toml", slow);
    let world = crate::common::experiment_text("worlds/paddle");
    assert!(world.contains("period_s = 0.001"));
    folder.write(
        "world.toml",
        world.replace("period_s = 0.001", "period_s = 1"),
    );
    let asked = "is 1 s, a loop of 1 Hz; is it in milliseconds? A period of 1 ms is";
    for (command, name, usual) in [
        (
            "simulate scene.toml --period 1",
            "--period",
            "--period 0.001",
        ),
        ("simulate slow.toml", "loop.period_s", "period_s = 0.001"),
        ("simulate world.toml", "loop.period_s", "period_s = 0.001"),
        (
            "advise --device-mass 0.2 --period 1 --stiffness 0.1",
            "--period",
            "--period 0.001",
        ),
        ("report --period 1 --json", "--period", "--period 0.001"),
        (
            "pipe --stiffness 1 --mass 1 --period 1",
            "--period",
            "--period 0.001",
        ),
    ] {
        let answer = folder.palpate(command);
        let question = format!("{name} {asked} {usual}\n");
        assert!(answer.stderr.contains(&question), "{command}: {answer:?}");
    }
    let usual = folder.palpate("simulate scene.toml --period 0.02");
    assert_eq!(usual.stderr, "");
}

#[test]
fn recording_starting_inside_object_causes_warning() {
    let folder = folder();
    let answer = folder.palpate(&format!(
        "render metres.csv {CONTACT} --object-position -0.01"
    ));
    assert_eq!(answer.code, 0, "{answer:?}");
    for words in [
        "warning: the device starts",
        "inside the object",
        "--object-position",
    ] {
        assert!(answer.stderr.contains(words), "{answer:?}");
    }
}
