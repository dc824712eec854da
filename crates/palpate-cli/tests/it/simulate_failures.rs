//! `palpate simulate` with errors in the scene.

use crate::common::{Folder, experiment, experiment_text};

/// Edits of the scene of Fig. 2, the position of the error, and its message.
const FAULTS: [(&str, &str, &str, &[&str]); 24] = [
    (
        "stiffness_n_per_m = 100",
        "stiffness_n_per_m = -100",
        "27:21",
        &["contact.stiffness_n_per_m is -100 N/m", "greater than 0"],
    ),
    (
        "stiffness_n_per_m = 100",
        "stiffness_n_per_m = nan",
        "27:21",
        &["contact.stiffness_n_per_m is NaN"],
    ),
    (
        "stiffness_n_per_m = 100",
        "stiffness_n_per_m = \"100\"",
        "27:21",
        &["string \"100\""],
    ),
    (
        "stiffness_n_per_m =",
        "stifness_n_per_m =",
        "27:1",
        &[
            "unknown key stifness_n_per_m",
            "did you mean stiffness_n_per_m?",
        ],
    ),
    (
        "mass_kg = 0.1\nposition_m",
        "mass_kg = 0\nposition_m",
        "20:11",
        &["body.mass_kg is 0 kg"],
    ),
    (
        "position_m = [0.1,",
        "position_m = [inf,",
        "21:14",
        &["body.position_m is inf m", "finite"],
    ),
    (
        "mass_kg = 0.1\n\n[device.hand]",
        "mass_kg = inf\n\n[device.hand]",
        "12:11",
        &["device.mass_kg is inf kg"],
    ),
    (
        "mass_kg = 0.1\n\n[device.hand]",
        "linkage = { preset = \"robot\" }\n\n[device.hand]",
        "11:8",
        &["moves along y"],
    ),
    (
        "[device.hand]",
        "[device.hand]\ntremor_n = 1",
        "15:12",
        &["a tremor needs both"],
    ),
    (
        "force_n = [0.981,",
        "force_n = [nan,",
        "15:11",
        &["device.hand.force_n is NaN N", "finite"],
    ),
    (
        "period_s = 0.01",
        "period_s = 0",
        "7:12",
        &["loop.period_s is 0 s", "greater than 0"],
    ),
    (
        "period_s = 0.01",
        "period_s = 0.01\ndelay_samples = 5000",
        "8:17",
        &["loop.delay_samples is 5000", "at most 1024"],
    ),
    (
        "period_s = 0.01",
        "period_s = 0.01\ndelay_samples = -1",
        "8:17",
        &["-1"],
    ),
    ("collisions = 3", "collisions = 0", "33:14", &["at least 1"]),
    (
        "collisions = 3",
        "duration_s = -1",
        "33:14",
        &["duration_s is -1 s", "greater than 0"],
    ),
    (
        "collisions = 3",
        "duration_s = 1e12",
        "33:14",
        &["100000000000000 periods", "at most 2000000"],
    ),
    (
        "collisions = 3",
        "collisions = 3\nduration_s = 1",
        "34:14",
        &["either collisions or duration_s"],
    ),
    (
        "force_n = [0.981,",
        "force_n = [-5,",
        "33:14",
        &["requires 3 collisions", "has only 0"],
    ),
    (
        "method = \"hfcr\"",
        "method = \"hfrc\"",
        "30:10",
        &["did you mean \"hfcr\"?"],
    ),
    (
        "[methods.popc]",
        "[methods.popd]",
        "43:10",
        &["popd", "did you mean \"popc\"?"],
    ),
    (
        "damping_n_s_per_m = 0.53",
        "damping_n_s_per_m = -0.53",
        "41:21",
        &["damping_n_s_per_m is -0.53 N s/m"],
    ),
    (
        "damping_n_s_per_m = 0.53",
        "damping_cap_n_s_per_m = 1",
        "41:1",
        &["virtual-damper", "popc, popc-ref, energy-tank"],
    ),
    (
        "format = 2",
        "format = 3",
        "3:10",
        &["format is 3", "must be 2"],
    ),
    ("format = 2", "", "1:1", &["format = 2"]),
];

#[test]
fn a_fault_of_the_scene_is_shown_in_its_line_and_column() {
    let folder = Folder::new();
    let text = experiment_text("fig2");
    for (old, new, place, words) in FAULTS {
        assert!(text.contains(old), "{old}");
        folder.write("bad.toml", text.replacen(old, new, 1));
        folder.fail(
            "simulate bad.toml",
            3,
            &[&format!("error: bad.toml:{place}: ")],
        );
        folder.fail("simulate bad.toml --out run.csv --plot run.svg", 3, words);
        assert_eq!(folder.names(), ["bad.toml"], "nothing is written");
    }
}

#[test]
fn a_scene_that_is_not_text_is_shown_where_it_stops_to_be() {
    let folder = Folder::new();
    folder.write("bad.toml", b"format = 2\ntitle = \"\xff\"\n");
    folder.fail(
        "simulate bad.toml",
        3,
        &["error: bad.toml:2:10: ", "0xFF", "UTF-8"],
    );
    folder.write("bad.toml", "");
    folder.fail("simulate bad.toml", 3, &["error: bad.toml:1:1: ", "format"]);
    folder.write("bad.toml", "format = 2\ntitle = \n");
    folder.fail("simulate bad.toml", 3, &["error: bad.toml:2:9: "]);
}

#[test]
fn a_scene_that_is_not_there_is_a_failure_of_the_system() {
    let words = ["error: no.toml: ", "No such file"];
    Folder::new().fail("simulate no.toml", 1, &words);
}

#[test]
fn the_line_at_fault_is_drawn() {
    let folder = Folder::new();
    let text = experiment_text("fig2").replace("period_s = 0.01", "period = 0.01");
    folder.write("bad.toml", text);
    let drawing = [
        "did you mean period_s?",
        "6 │ [loop]\n7 │ period = 0.01\n",
        "━━━━━━ here",
    ];
    folder.fail("simulate bad.toml", 3, &drawing);
}

#[test]
fn a_wrong_value_of_a_setting_is_drawn_at_the_value() {
    let folder = Folder::new();
    let text =
        experiment_text("fig2").replace("damping_n_s_per_m = 0.53", "damping_n_s_per_m = -0.53");
    folder.write("bad.toml", text);
    folder.fail(
        "simulate bad.toml",
        3,
        &["41 │ damping_n_s_per_m = -0.53\n   ╰╴                    ━━━━━ here"],
    );
}

#[test]
fn a_fault_that_a_flag_brings_in_is_the_flag_s() {
    let folder = Folder::new();
    folder.write("scene.toml", experiment_text("fig2"));
    let run = |flags: &str, words: &[&str]| {
        folder.fail(&format!("simulate scene.toml {flags}"), 2, words);
    };
    run("--period 1e-9", &["--period", "at most 2000000"]);
    run(
        "--method virtual-damper --damping auto",
        &["--damping auto", "virtual-damper a number"],
    );
    run(
        "--mass inf --object-velocity 1",
        &["--object-velocity is 1 m/s", "0 for a wall"],
    );
}

#[test]
fn a_wall_that_the_scene_would_move_is_shown_in_the_scene() {
    let folder = Folder::new();
    let text = experiment_text("fig2");
    folder.write(
        "scene.toml",
        text.replace(
            "position_m = [0.1,",
            "velocity_m_per_s = [1.0, 0.0, 0.0]\nposition_m = [0.1,",
        ),
    );
    let words = [
        "scene.toml:21:20: ",
        "body.velocity_m_per_s is 1 m/s",
        "0 for a wall",
    ];
    folder.fail("simulate scene.toml --mass inf", 3, &words);
}

#[test]
fn the_scene_is_never_overwritten_by_its_run() {
    let folder = Folder::new();
    folder.write("scene.toml", experiment_text("fig2"));
    let words = ["--out", "overwrite", "scene.toml"];
    folder.fail("simulate scene.toml --out scene.toml", 2, &words);
    assert_eq!(folder.read("scene.toml"), experiment_text("fig2"));
}

#[test]
fn a_scene_that_flags_make_impossible_is_not_blamed_on_the_file() {
    let folder = Folder::new();
    let scene = experiment("fig2").display().to_string();
    for flags in ["--object-position 1e9", "--side negative", "--force 5"] {
        folder.fail(
            &format!("simulate {scene} {flags}"),
            2,
            &["with these flags, "],
        );
    }
    let words = "--stiffness is 10000000000000 N/m, but must be at most 1e12";
    folder.fail(&format!("simulate {scene} --stiffness 1e13"), 2, &[words]);
}

#[test]
fn a_recording_in_place_of_a_scene_is_said_to_be_one() {
    let folder = Folder::new();
    for (file, what) in [
        ("motion.csv", ".csv is a table, for `palpate render`"),
        ("motion.MCAP", ".mcap is a recording, for `palpate replay`"),
    ] {
        folder.write(file, "t_s,position_m\n0,0\n");
        let words = format!("a scene is a TOML file; {what}");
        folder.fail(&format!("simulate {file}"), 2, &[&words]);
    }
    folder.fail(
        "render motion.MCAP",
        2,
        &["is a recording: pass it to `palpate replay`"],
    );
    folder.fail(
        "render wall.toml",
        2,
        &["a .toml file is a scene, for `palpate simulate` or `palpate run`"],
    );
}

#[cfg(unix)]
#[test]
fn a_scene_that_does_not_end_is_refused() {
    let answer = Folder::new().palpate("simulate /dev/zero");
    assert_eq!(answer.code, 1, "{answer:?}");
    for words in ["/dev/zero", "16 MiB", "a scene"] {
        assert!(answer.stderr.contains(words), "{words}: {answer:?}");
    }
}
