//! `palpate map`: parts, interruptions and files.

mod common;

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use common::{Folder, METHODS, number, parse};

const SMALL: &str = "map --cells 5 --threads 2";

#[test]
fn a_small_map_says_what_each_method_can_render_and_draws_it() {
    let folder = Folder::new();
    let report = folder.json(SMALL);
    assert_eq!(report["format"], "palpate map report 1");
    assert_eq!(report["cells"], 30);
    let methods = report["methods"].as_array().unwrap();
    assert_eq!(methods.len(), 2 * METHODS.len());
    let of = |plant: &str, method: &str, field: &str| {
        let entry = methods
            .iter()
            .find(|entry| entry["plant"] == plant && entry["method"] == method);
        number(entry.unwrap(), field)
    };
    // The order of what is known: more is stable with smooth transitions than without, and the
    // plain spring is stable nowhere that matters.
    let stable = |method| of("undamped", method, "stable_percent");
    assert!(stable("hfcr") > stable("hfcr-mod") && stable("hfcr-mod") > stable("basic"));
    assert!(of("damped", "hfcr", "faithful_percent") > 20.0);
    assert!(number(&report["work"], "ticks") > 1e5);
    assert_eq!(folder.names(), ["map.csv", "map.svg"]);

    let table = folder.read("map.csv");
    assert_eq!(table.lines().count(), 1 + 30 * 2 * METHODS.len());
    let picture = folder.read("map.svg");
    let document = roxmltree::Document::parse(&picture).unwrap();
    let words: Vec<&str> = document
        .descendants()
        .filter_map(|node| node.text())
        .collect();
    for word in METHODS.iter().chain(&["wall", "diverged", "Kc = K T²/M"]) {
        assert!(words.contains(word), "{word}: {words:?}");
    }
    let text = folder.succeed(&format!("{SMALL} --out again.csv"));
    assert!(
        text.contains("walls to kappa") && text.contains("ticks/s"),
        "{text}"
    );
    assert_eq!(folder.read("again.csv"), table);
    assert_eq!(folder.read("again.svg"), picture);
}

#[test]
fn three_parts_one_of_them_killed_and_run_again_are_the_whole_map() {
    let folder = Folder::new();
    let arguments = "map --cells 17 --method hfcr,basic --threads 1";
    folder.succeed(&format!("{arguments} --out whole.csv"));

    // The loop of docs/map.md; part 2 is killed as soon as it has done something.
    let journal = folder.path("map-2-of-3.csv.journal");
    let mut child = Command::new(assert_cmd::cargo::cargo_bin("palpate"))
        .current_dir(folder.path("."))
        .args(arguments.split(' '))
        .args(["--shard", "2/3"])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let begun = Instant::now();
    while std::fs::metadata(&journal).map_or(0, |file| file.len()) < 3000 {
        assert!(begun.elapsed() < Duration::from_secs(50), "no journal");
        std::thread::sleep(Duration::from_millis(1));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(!folder.path("map-2-of-3.csv").exists(), "killed too late");
    let kept = std::fs::read_to_string(&journal).unwrap().lines().count();
    assert!(kept > 1, "nothing was kept");
    // Without --resume nothing is thrown away.
    folder.fail(
        &format!("{arguments} --shard 2/3"),
        3,
        &["map-2-of-3.csv.journal", "--resume"],
    );
    // With it, but for another map, neither.
    folder.fail(
        &format!("{arguments} --shard 2/3 --resume --delay 1"),
        3,
        &["of another map", "delay_samples=1"],
    );

    for part in 1..=3 {
        folder.succeed(&format!("{arguments} --shard {part}/3 --resume"));
    }
    assert!(!journal.exists());
    // A part that is complete is complete.
    let again = folder.succeed(&format!("{arguments} --shard 2/3 --resume"));
    assert!(!again.contains("ticks"), "{again}");
    let parts = "map-3-of-3.csv map-1-of-3.csv map-2-of-3.csv";
    folder.succeed(&format!("map merge {parts} --out merged.csv"));
    assert!(folder.read("merged.csv") == folder.read("whole.csv"));
    assert!(folder.read("merged.svg") == folder.read("whole.svg"));

    folder.fail(
        "map merge map-1-of-3.csv map-3-of-3.csv",
        3,
        &["part 2/3 is not among the files"],
    );
    folder.fail(
        &format!("map merge {parts} map-1-of-3.csv"),
        3,
        &["map-1-of-3.csv", "name each part once"],
    );
    let part = folder.read("map-2-of-3.csv");
    let torn = part.len() / 2;
    folder.write("map-2-of-3.csv", &part[..torn]);
    folder.fail(
        &format!("map merge {parts}"),
        3,
        &["map-2-of-3.csv is torn", "make this part again"],
    );
    folder.write(
        "other.csv",
        folder
            .read("map-1-of-3.csv")
            .replacen("\"\"0\"\"", "\"\"1\"\"", 1),
    );
    folder.fail(
        "map merge map-3-of-3.csv other.csv",
        3,
        &["other.csv", "not parts of one map"],
    );
    assert!(!folder.path("map.csv").exists());
}

#[cfg(unix)]
#[test]
fn ctrl_c_keeps_what_is_done() {
    let folder = Folder::new();
    let journal = folder.path("map.csv.journal");
    let child = Command::new(assert_cmd::cargo::cargo_bin("palpate"))
        .current_dir(folder.path("."))
        .args("map --cells 33 --method hfcr,basic,seh --threads 1".split(' '))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let begun = Instant::now();
    while std::fs::metadata(&journal).map_or(0, |file| file.len()) < 3000 {
        assert!(begun.elapsed() < Duration::from_secs(50), "no journal");
        std::thread::sleep(Duration::from_millis(1));
    }
    let id = child.id().to_string();
    assert!(
        Command::new("kill")
            .args(["-INT", &id])
            .status()
            .unwrap()
            .success()
    );
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130));
    assert_eq!(output.stdout, b"");
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(
        said.starts_with("stopped: ") && said.contains("of 1122 cells are kept in map.csv.journal"),
        "{said}"
    );
    assert_eq!(folder.names(), ["map.csv.journal"]);
}

#[cfg(unix)]
#[test]
fn a_full_disk_is_named_and_leaves_no_half_map() {
    let folder = Folder::new();
    // Blocks of 512 bytes or 1 KiB: a few cells of the journal, not all.
    let script = format!(
        "trap '' XFSZ; ulimit -f 8; exec {} map --cells 9 --method hfcr --threads 1 --out full.csv",
        assert_cmd::cargo::cargo_bin("palpate").display()
    );
    let output = Command::new("bash")
        .current_dir(folder.path("."))
        .args(["-c", &script])
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(
        said.contains("cannot write `full.csv.journal`") && said.contains("--resume"),
        "{said}"
    );
    assert_eq!(folder.names(), ["full.csv.journal"]);
    // With room again it goes on, past the line that was torn.
    let resumed = "map --cells 9 --method hfcr --threads 1 --out full.csv --resume";
    folder.succeed(resumed);
    folder.succeed("map --cells 9 --method hfcr --threads 2 --out plain.csv");
    assert!(folder.read("full.csv") == folder.read("plain.csv"));
}

#[test]
fn what_is_told_wrong_and_delays_stand_in_the_map() {
    let folder = Folder::new();
    let arguments = "map --cells 3 --method hfcr --delay 1 --told-mass 2 --told-period 1.1 \
                     --encoder-quantum 1e-5 --viscous-friction 0.5 --show growth,over-floor";
    let text = folder.succeed(arguments);
    for word in [
        "delay [samples] 1",
        "told mass x 2",
        "told period x 1.1",
        "0.5 N s/m",
    ] {
        assert!(text.contains(word), "{word}: {text}");
    }
    let table = folder.read("map.csv");
    for word in [
        "\"\"delay_samples\"\":\"\"1\"\"",
        "\"\"told_mass_factor\"\":\"\"2\"\"",
    ] {
        assert!(table.contains(word), "{word}");
    }
    let picture = folder.read("map.svg");
    assert!(picture.contains("over the hold floor") && picture.contains("Gil"));
}

#[test]
fn wrong_arguments_are_named() {
    let folder = Folder::new();
    for (arguments, words) in [
        ("map --cells 1", vec!["--cells", "2..=1000"]),
        ("map --shard 4/3", vec!["--shard", "I/N"]),
        ("map --shard 0/3", vec!["--shard", "I/N"]),
        ("map --told-mass 0", vec!["--told-mass", "0.001 to 1000"]),
        (
            "map --viscous-friction -1",
            vec!["--viscous-friction", "not below 0"],
        ),
        ("map --shard 1/3 --plot a.svg", vec!["--plot", "map merge"]),
        ("map --plot a.gif", vec![".svg"]),
        ("map --method hfr", vec!["hfr", "hfcr"]),
    ] {
        folder.fail(arguments, 2, &words);
    }
    folder.fail("map merge none.csv", 1, &["none.csv"]);
    folder.write("hand.csv", "t_s,position_m\n0,0\n");
    folder.fail("map merge hand.csv", 3, &["hand.csv:1", "not a map"]);
    assert_eq!(folder.names(), ["hand.csv"]);
}

#[test]
fn parquet_is_a_feature() {
    let folder = Folder::new();
    let arguments = "map --cells 2 --method hfcr --parquet map.parquet";
    if cfg!(feature = "parquet") {
        folder.succeed(arguments);
        let bytes = std::fs::read(folder.path("map.parquet")).unwrap();
        assert!(bytes.starts_with(b"PAR1") && bytes.ends_with(b"PAR1"));
    } else {
        folder.fail(arguments, 2, &["--parquet", "--features parquet"]);
    }
}

#[test]
fn an_advice_answers_in_words_first() {
    let folder = Folder::new();
    let device = "advise --device-mass 0.3 --period 0.002 --encoder-quantum 1e-5";
    // Without a quantum: one of 10 um shakes so light an object by a sixth of its weight.
    let asked = "advise --device-mass 0.3 --period 0.002 --stiffness 2000 --mass 0.05";
    let text = folder.succeed(asked);
    assert!(
        text.starts_with("Yes: 2000 N/m for an object of 0.05 kg"),
        "{text}"
    );
    assert!(text.contains("Classical bounds"), "{text}");
    let report = folder.json(asked);
    assert_eq!(report["format"], "palpate advise 2");
    assert_eq!(report["verdict"]["answer"], "yes");
    // Without tuning, and its limits are beside those of the others.
    assert_eq!(report["verdict"]["method"], "coupled");
    assert_eq!(
        report["verdict"]["damping_n_s_per_m"],
        serde_json::Value::Null
    );
    let methods = report["methods"].as_array().unwrap();
    assert_eq!(methods.len(), METHODS.len());
    for entry in methods {
        assert!(entry["by_itself"]["class"].is_string(), "{entry}");
    }
    let stiffest = |method: &str| {
        let mut entries = methods.iter().filter(|entry| entry["method"] == method);
        number(&entries.next().unwrap()["stiffest_n_per_m"], "value")
    };
    assert!(stiffest("coupled") > 3.0 * stiffest("hfcr"));
    assert!((number(&report["contact"], "kappa") - 0.026_666).abs() < 1e-4);
    assert!((number(&report["bounds"], "undamped_wall_n_per_m") - 51_471.9).abs() < 1.0);

    let hard = folder.succeed(&format!(
        "{device} --stiffness 3e6 --mass 0.05 --method hfcr"
    ));
    assert!(hard.starts_with("No: 3000000 N/m"), "{hard}");
    // What bounces well and then swings for ever is no yes, nor is what every hold does badly.
    let light = "advise --device-mass 0.25 --stiffness 10000 --mass 0.1 --period 0.01";
    let swings = folder.json(&format!(
        "{light} --delay 1 --method virtual-damper,hfcr,coupled"
    ));
    assert_ne!(swings["verdict"]["answer"], "yes", "{swings}");
    let coarse = folder.json(&format!("{light} --method coupled"));
    assert_eq!(coarse["verdict"]["answer"], "hold-too-coarse", "{coarse}");
    assert!(number(&coarse["contact"], "hold_floor_percent") > 20.0);
    let coupled = &coarse["methods"][0]["by_itself"];
    assert!(number(coupled, "resting_swing") < 0.01, "{coupled}");
    assert!(number(coupled, "pressed_swing") < 0.01, "{coupled}");
    let only = folder.succeed(&format!("{device} --method hfcr"));
    assert!(
        only.starts_with("The stiffest contact with a wall"),
        "{only}"
    );
    assert_eq!(
        parse(&folder.succeed(&format!("{device} --method hfcr --json")))["contact"],
        serde_json::Value::Null
    );
    for (arguments, words) in [
        ("advise --period 0.002", vec!["--device-mass"]),
        (
            "advise --device-mass 0 --period 0.002",
            vec!["--device-mass is 0 kg"],
        ),
        (
            "advise --device-mass 1 --period 0.002 --mass -1",
            vec!["--mass is -1 kg"],
        ),
    ] {
        folder.fail(arguments, 2, &words);
    }
}
