//! Existing files are kept without `--overwrite`, and checked before any work.

use crate::common::{Folder, experiment, taps, trace_text};

const CONTACT: &str = "--stiffness 400 --mass 0.1 --period 0.01";

/// Returns every command that writes tables and figures, with the files it writes; each is fast.
fn commands() -> Vec<(String, &'static [&'static str])> {
    let fig2 = experiment("fig2").display().to_string();
    let wall = experiment("wall").display().to_string();
    vec![
        (
            format!("render tap.csv {CONTACT} --out r.csv --plot r.svg"),
            &["r.csv", "r.svg"],
        ),
        (
            format!("simulate {fig2} --out s.csv --plot s.svg"),
            &["s.csv", "s.svg"],
        ),
        (
            format!("compare {fig2} {wall} --method basic --out c.csv"),
            &["c.csv"],
        ),
        (
            format!("tune {fig2} --method virtual-damper --steps 2 --plot t.svg"),
            &["t.svg"],
        ),
        (
            "suite --plants 2 --method basic --out p.csv --plot p.svg --write-scenes plants".into(),
            &[
                "p.csv",
                "p.svg",
                "plants/plant-0000.toml",
                "plants/plant-0001.toml",
            ],
        ),
        (
            "map --cells 2 --method basic --out m.csv".into(),
            &["m.csv", "m.svg"],
        ),
        ("map merge m.csv --plot again.svg".into(), &["again.svg"]),
        (
            "map merge m.csv --out copy.csv".into(),
            &["copy.csv", "copy.svg"],
        ),
        ("paper figure fig2".into(), &["fig2.svg"]),
        ("convert tap.mcap".into(), &["tap.csv", "tap-events.csv"]),
        (
            "replay tap.mcap --method basic --out q.csv --plot q.svg".into(),
            &["q.csv", "q.svg"],
        ),
    ]
}

fn with_inputs() -> Folder {
    let folder = Folder::new();
    folder.write("tap.csv", trace_text(&taps(0.001, 0.5)));
    crate::recordings::record(&folder.path("tap.mcap"));
    folder
}

#[test]
fn no_file_is_overwritten_unless_that_is_asked_for() {
    let folder = with_inputs();
    for (command, files) in commands() {
        if command.starts_with("convert") {
            std::fs::remove_file(folder.path("tap.csv")).unwrap();
        }
        folder.succeed(&command);
        let written: Vec<String> = files.iter().map(|file| folder.read(file)).collect();
        for kept in files {
            // One existing file is enough to keep all of them.
            for file in files {
                let _ = std::fs::remove_file(folder.path(file));
            }
            folder.write(kept, "mine");
            let before = folder.names();
            folder.fail(
                &command,
                1,
                &[
                    &format!("cannot write `{kept}`: there is a file of that name"),
                    "--overwrite",
                ],
            );
            assert_eq!(folder.read(kept), "mine", "{command}");
            assert_eq!(folder.names(), before, "{command}");
        }
        for file in files {
            folder.write(file, "mine");
        }
        folder.succeed(&format!("{command} --overwrite"));
        let again: Vec<String> = files.iter().map(|file| folder.read(file)).collect();
        assert!(again == written, "{command}");
    }
}

#[test]
fn what_cannot_be_written_is_said_before_the_work() {
    let folder = with_inputs();
    std::fs::create_dir(folder.path("taken.svg")).unwrap();
    std::fs::create_dir(folder.path("taken.csv")).unwrap();
    let fig2 = experiment("fig2").display().to_string();
    // Each would compute for hours.
    let long = [
        (
            "suite --plants 1000000 --method coupled".to_owned(),
            "--out",
        ),
        (
            "suite --plants 1000000 --method coupled".to_owned(),
            "--plot",
        ),
        ("map --cells 1000".to_owned(), "--out"),
        ("map --cells 1000 --resume".to_owned(), "--out"),
        ("map --cells 1000".to_owned(), "--plot"),
        (
            format!("tune {fig2} --method virtual-damper --steps 100000"),
            "--plot",
        ),
    ];
    let before = folder.names();
    for (command, flag) in &long {
        let ending = if *flag == "--out" { "csv" } else { "svg" };
        let mut places = vec![
            (format!("taken.{ending}"), "it is a directory"),
            (format!("none/x.{ending}"), "there is no directory `none`"),
        ];
        if *flag == "--out" && cfg!(target_os = "linux") {
            places.push(("/dev/full".into(), "no space left on the device"));
        }
        for (place, words) in places {
            folder.fail(
                &format!("{command} {flag} {place}"),
                1,
                &[&format!("cannot write `{place}`"), words],
            );
            assert_eq!(folder.names(), before, "{command} {flag} {place}");
        }
    }
    // No journal is left without its file.
    if cfg!(unix) {
        folder.fail(
            "map --cells 1000 --out /dev/null",
            2,
            &["--out /dev/null", "journal"],
        );
        assert!(!std::path::Path::new("/dev/null.journal").exists());
        assert!(!std::path::Path::new("/dev/full.journal").exists());
    }
    folder.fail(
        "convert tap.mcap --out taken.csv",
        1,
        &["cannot write `taken.csv`: it is a directory"],
    );
    folder.fail(
        "demo --out-dir tap.csv",
        1,
        &["cannot create the folder `tap.csv`"],
    );
    assert_eq!(folder.names(), before);
}

#[cfg(unix)]
#[test]
fn a_folder_that_may_not_be_changed_is_said_before_the_work() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new();
    let closed = folder.path("closed");
    std::fs::create_dir(&closed).unwrap();
    std::fs::set_permissions(&closed, std::fs::Permissions::from_mode(0o555)).unwrap();
    if std::fs::write(closed.join("probe"), "").is_ok() {
        eprintln!("SKIPPED: this user may write into any folder, as root may");
        return;
    }
    for command in [
        "map --cells 1000 --out closed/m.csv",
        "suite --plants 1000000 --out closed/s.csv",
        "suite --plants 1000000 --write-scenes closed",
    ] {
        folder.fail(command, 1, &["cannot write `closed/", "permission denied"]);
    }
}

#[test]
fn two_outputs_and_inputs_are_never_one_file() {
    let folder = with_inputs();
    let fig2 = experiment("fig2").display().to_string();
    for (command, words) in [
        (
            format!("render tap.csv {CONTACT} --out x.svg --plot ./x.svg"),
            "--out and --plot name the same file",
        ),
        (
            "suite --plants 2 --out x.svg --plot x.svg".into(),
            "--out and --plot name the same file",
        ),
        (
            "map --cells 2 --out x.svg".into(),
            "--out and --plot name the same file",
        ),
        (
            format!("render tap.csv {CONTACT} --out ./tap.csv --overwrite"),
            "--out would overwrite the input tap.csv",
        ),
        (
            format!("compare {fig2} --out {fig2} --overwrite"),
            "--out would overwrite the input",
        ),
        (
            "convert tap.mcap --out tap.mcap --overwrite".into(),
            "--out would overwrite the input tap.mcap",
        ),
    ] {
        folder.fail(&command, 2, &[words]);
    }
    folder.succeed("map --cells 2 --method basic");
    folder.fail(
        "map merge map.csv --out map.csv --overwrite",
        2,
        &["--out would overwrite the input map.csv"],
    );
}

#[test]
fn a_demonstration_replaces_what_it_has_made_and_nothing_else() {
    let folder = Folder::new();
    folder.succeed("demo");
    let figure = folder.read("palpate-demo/fig2.svg");
    // A file made by another version.
    let list = folder.read("palpate-demo/made-by-palpate-demo.txt");
    assert_eq!(list.lines().count(), 4, "{list}");
    folder.succeed("demo");

    folder.write("palpate-demo/hand.csv", "t_s,position_m\n0,0\n1,0\n");
    folder.write("palpate-demo/notes.txt", "mine");
    for _ in 0..2 {
        folder.fail(
            "demo",
            1,
            &[
                "cannot write `palpate-demo/hand.csv`",
                "is not an unchanged file of palpate demo",
                "--out-dir",
                "--overwrite",
            ],
        );
    }
    assert!(folder.read("palpate-demo/hand.csv").ends_with("1,0\n"));
    assert_eq!(folder.read("palpate-demo/fig2.svg"), figure);
    folder.succeed("demo --out-dir another");
    folder.succeed("demo --overwrite");
    assert_eq!(
        folder.read("palpate-demo/hand.csv"),
        folder.read("another/hand.csv")
    );
    assert_eq!(folder.read("palpate-demo/notes.txt"), "mine");
    folder.succeed("demo");
}

/// A block of 12 triangles [mm], pushed by a tool.
const BLOCK: &str = r#"
format = 2
[loop]
period_s = 0.001
[[device]]
name = "tool"
mass_kg = 0.2
position_m = [0.0, 0.0, 0.0159]
tool = { sphere = { radius_m = 0.005 } }
[[body]]
name = "block"
fixed = true
shape = { mesh = { file = "block.obj", unit = "mm" } }
[[contact]]
between = ["tool", "block"]
stiffness_n_per_m = 2000.0
[measure]
duration_s = 0.1
"#;

/// Input files named in another file or in a flag, and recordings, whether read or not.
#[test]
fn what_a_scene_or_a_flag_names_and_every_recording_is_kept() {
    let folder = with_inputs();
    let corners = (0..8).map(|corner| {
        let place = [1, 2, 4].map(|bit| if corner & bit == 0 { "-11" } else { "11" });
        format!("v {}\n", place.join(" "))
    });
    let faces = "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    folder.write("block.obj", corners.collect::<String>() + faces);
    folder.write("block.toml", BLOCK);
    folder.write("motion.csv", "t,x,y,z\n0,0,0,0.017\n0.01,0,0,0.0159\n");
    folder.write(
        "device.toml",
        "calibration_format = 1\ndevice_mass_kg = 0.25\ndelay_s = 0.001\nlag_s = 0.0\n",
    );
    folder.write("fig2.toml", crate::common::experiment_text("fig2"));
    folder.write(
        "cube.toml",
        crate::common::experiment_text("users/s02-light-cube"),
    );
    let intention = experiment("users/hand_intention").with_extension("csv");
    std::fs::copy(intention, folder.path("hand_intention.csv")).unwrap();
    std::fs::copy(folder.path("tap.mcap"), folder.path("other.mcap")).unwrap();
    for (command, kept) in [
        (
            "render block.toml --input motion.csv --out motion.csv",
            "motion.csv",
        ),
        (
            "render block.toml --input motion.csv --out block.obj",
            "block.obj",
        ),
        ("compare block.toml --out block.obj", "block.obj"),
        (
            "simulate fig2.toml --device-file device.toml --out device.toml",
            "device.toml",
        ),
        (
            "replay tap.mcap --device-file device.toml --out device.toml",
            "device.toml",
        ),
        (
            "simulate cube.toml --out hand_intention.csv",
            "hand_intention.csv",
        ),
        ("convert tap.mcap --out other.mcap", "other.mcap"),
        ("replay tap.mcap --out other.mcap", "other.mcap"),
        ("simulate fig2.toml --out other.mcap", "other.mcap"),
        ("compare fig2.toml --out other.mcap", "other.mcap"),
        ("report tap.mcap --out other.mcap", "other.mcap"),
    ] {
        let before = std::fs::read(folder.path(kept)).unwrap();
        let words = if kept.ends_with(".mcap") {
            "other.mcap is a recording, which is never replaced".to_owned()
        } else {
            format!("--out would overwrite the input {kept}")
        };
        // Notes on a mesh precede the error.
        let answer = folder.palpate(&format!("{command} --overwrite"));
        assert_eq!(answer.code, 2, "{command}: {answer:?}");
        assert!(answer.stderr.contains(&words), "{command}: {answer:?}");
        assert_eq!(
            std::fs::read(folder.path(kept)).unwrap(),
            before,
            "{command}"
        );
    }
    // Before the device moves, also for a file given by a shell.
    for command in [
        "calibrate --device simulated --scene fig2.toml --seconds 3 --out fig2.toml",
        "calibrate --device simulated --before device.toml --added-mass 0.1 --seconds 3 --out device.toml",
        "report --device replay --motion tap.csv --duration 1 --out tap.csv",
        "tune fig2.toml --method virtual-damper --device-file device.toml --plot ./device.svg",
    ] {
        if command.starts_with("tune") {
            std::fs::copy(folder.path("device.toml"), folder.path("device.svg")).unwrap();
        }
        let command = command.replace("device-file device.toml", "device-file device.svg");
        let names = folder.names();
        let answer = folder.palpate(&format!("{command} --overwrite"));
        assert_eq!(answer.code, 2, "{command}: {answer:?}");
        assert!(
            answer.stderr.contains("would overwrite the input"),
            "{command}: {answer:?}"
        );
        assert_eq!(folder.names(), names, "{command}");
    }
    // Each works with a separate name.
    for command in [
        "compare block.toml --out table.csv",
        "render block.toml --input motion.csv --out forces.csv",
        "simulate cube.toml --out cube.csv",
    ] {
        let answer = folder.palpate(command);
        assert_eq!(answer.code, 0, "{command}: {answer:?}");
    }
}
