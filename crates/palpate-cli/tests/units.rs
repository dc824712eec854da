//! The unit of recorded positions: said by the column or a flag, and doubted where no hand moves so.

mod common;
mod recordings;

use common::{Folder, number, of_method, taps};

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
            "m of hand motion in 3 s",
            "is the unit mm?",
            "--unit mm",
            "--unit m says",
        ],
    );
    // Whoever means it goes on.
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
    folder.write("wall.toml", common::experiment_text("wall"));
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
    recordings::record(&folder.path("tap.mcap"));
    folder.fail(
        &format!("{run} tap.mcap --unit mm"),
        2,
        &["--unit is the unit of a trace", "metres"],
    );
}

#[test]
fn an_intention_that_no_hand_has_is_doubted() {
    let folder = folder();
    let scene = common::experiment_text("wall");
    let hand = "kind = \"constant-force\"\nforce_n = 2\n";
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
                    "kind = \"impedance\"\nstiffness_n_per_m = 100\ndamping_n_s_per_m = 2\n\
                     intention = \"{file}\"\n"
                ),
            ),
        );
        let answer = folder.palpate("run scene.toml --fast --duration 0.05");
        // A device that moves by metres trips the largest speed: the motors are off for most of the run.
        let code = if is_doubted { 5 } else { 0 };
        assert_eq!(answer.code, code, "{answer:?}");
        let said =
            answer.stderr.contains("hand.intention") && answer.stderr.contains("position_mm");
        assert_eq!(said, is_doubted, "{file}: {answer:?}");
    }
}

#[test]
fn a_recording_that_starts_inside_the_object_is_told() {
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
