//! `palpate render --replay hand`: the hand of a recording under a new force.

use crate::common::{Folder, METHODS, in_a_line, number, of_method, taps, trace_text};

const CONTACT: &str = "--stiffness 400 --mass 0.1 --period 0.01 --force -0.981";
const HAND: &str = "--replay hand --device-mass 0.25 --hand-stiffness 300 --hand-damping 5";

fn with_taps() -> Folder {
    let folder = Folder::new();
    folder.write("tap.csv", trace_text(&taps(0.001, 1.5)));
    folder
}

/// Returns the taps with a column of the held force before the others.
fn with_force(force: impl Fn(usize) -> String) -> String {
    let mut text = String::from("# a note\nforce_on_device_n,t_s,position_m\n");
    for (i, (t, x)) in taps(0.001, 1.5).into_iter().enumerate() {
        text.push_str(&format!("{},{t},{x}\n", force(i)));
    }
    text
}

#[test]
fn every_method_gets_a_hand_and_the_report_says_how_well_it_is_known() {
    let folder = with_taps();
    let arguments = format!("render tap.csv {CONTACT} {HAND} --method all");
    let report = folder.json(&format!("{arguments} --plot run.svg --out run.csv"));
    let replay = &report["replay"];
    assert_eq!(replay["kind"], "hand");
    assert_eq!(replay["force_recorded"], false);
    assert_eq!(number(replay, "hand_stiffness_n_per_m"), 300.0);
    assert_eq!(number(&report, "device_mass_kg"), 0.25);
    // The taps have no noise; two swings of 9 and 31 rad/s.
    assert!(number(replay, "hand_force_deviation_n") < 0.02 * number(replay, "hand_force_n"));
    assert!(number(replay, "given_back_within_m") < 1e-6);
    let departures = replay["largest_departure_m"].as_array().unwrap();
    assert_eq!(departures.len(), METHODS.len());
    for method in METHODS {
        let entry = of_method(&report, method);
        assert!(
            entry["diverged"].is_boolean(),
            "{method} ran in a closed loop"
        );
    }
    let floor = number(of_method(&report, "coupled"), "error_over_bound");
    assert!(floor < 1.5, "{floor}");
    let table = folder.succeed(&arguments);
    for words in [
        "hand replay (motor off)",
        "1 sigma",
        "reproduces the recorded motion within",
        "its impedance is 300 N/m and 5 N s/m",
        "the device leaves the recorded motion, which spans",
        "by up to: basic ",
    ] {
        assert!(
            in_a_line(&table).contains(words),
            "no {words:?} in:\n{table}"
        );
    }
    let run = folder.run_file("run.csv");
    let entry = |key: &str| run.metadata().iter().find(|(name, _)| name == key).cloned();
    assert_eq!(entry("replay").unwrap().1, "hand");
    assert_eq!(entry("hand_damping_n_s_per_m").unwrap().1, "5");
}

#[test]
fn a_motion_is_said_to_be_one() {
    let folder = with_taps();
    let plain = format!("render tap.csv {CONTACT}");
    let report = folder.json(&plain);
    assert_eq!(report["replay"], serde_json::json!({ "kind": "motion" }));
    assert_eq!(
        of_method(&report, "coupled")["parameters"]["device_mass_kg"],
        "inf"
    );
    let words = "motion replay: the device repeats its motion, whatever the force (1/m = 0)";
    assert!(folder.succeed(&plain).contains(words));
    assert_eq!(folder.json(&format!("{plain} --replay motion")), report);
}

#[test]
fn the_recorded_force_is_no_force_of_the_hand() {
    let folder = with_taps();
    folder.write("zero.csv", with_force(|_| "0".into()));
    folder.write(
        "pushed.csv",
        with_force(|i| format!("{}", if i % 200 < 100 { 2 } else { -1 })),
    );
    let report = |trace: &str| folder.json(&format!("render {trace} {CONTACT} {HAND}"));
    let (none, zero, pushed) = (report("tap.csv"), report("zero.csv"), report("pushed.csv"));
    assert_eq!(zero["replay"]["force_recorded"], true);
    assert_eq!(zero["methods"], none["methods"]);
    assert_ne!(pushed["methods"], none["methods"]);
    let force = |report: &serde_json::Value| number(&report["replay"], "hand_force_n");
    assert!(
        force(&pushed) > 1.2 * force(&none),
        "the hand held against the motor"
    );
    // A replayed motion does not depend on its origin.
    let motion = |trace: &str| folder.json(&format!("render {trace} {CONTACT}"))["methods"].clone();
    assert_eq!(motion("pushed.csv"), motion("tap.csv"));
}

#[test]
fn what_is_missing_or_wrong_is_named() {
    let folder = with_taps();
    let render = format!("render tap.csv {CONTACT}");
    folder.fail(
        &format!("{render} --replay hand"),
        2,
        &[
            "--replay hand needs --device-mass <kg>, finite and above 0",
            "--replay motion",
        ],
    );
    for flag in [
        "--hand-bandwidth 20",
        "--hand-stiffness 1",
        "--hand-damping 1",
    ] {
        let name = flag.split(' ').next().unwrap();
        folder.fail(&format!("{render} {flag}"), 2, &[name, "for --replay hand"]);
    }
    for (flag, said) in [
        (
            "--hand-bandwidth 0",
            "--hand-bandwidth is 0, but must be finite and greater than 0",
        ),
        (
            "--hand-stiffness -1",
            "--hand-stiffness is -1, but must be finite and not below 0",
        ),
        (
            "--hand-damping nan",
            "--hand-damping is NaN, but must be finite and not below 0",
        ),
        ("--stiffness 0", "--stiffness is 0 N/m"),
        ("--object-position nan", "--object-position is NaN m"),
        ("--period 9", "less than one period of 9 s"),
    ] {
        let name = flag.split(' ').next().unwrap();
        let own = format!("{CONTACT} ").replace(&format!("{name} "), "--seen ");
        let mut words: Vec<&str> = own.split_whitespace().collect();
        if let Some(at) = words.iter().position(|word| *word == "--seen") {
            words.drain(at..at + 2);
        }
        let command = format!(
            "render tap.csv {} --replay hand --device-mass 0.2 {flag}",
            words.join(" ")
        );
        let code = if name == "--period" { 3 } else { 2 };
        folder.fail(&command, code, &[said]);
    }
    folder.write("short.csv", "t_s,position_m\n0,0\n0.01,0\n0.02,0.001\n");
    folder.fail(
        &format!("render short.csv {CONTACT} {HAND}"),
        3,
        &["short.csv: ", "at least 8 samples with a position, not 3"],
    );
    folder.write(
        "bad.csv",
        with_force(|i| if i == 3 { "two".into() } else { "1".into() }),
    );
    folder.fail(
        &format!("render bad.csv {CONTACT} {HAND}"),
        3,
        &[
            "bad.csv:6:1: `two` in column `force_on_device_n` is not a finite number",
            "two,0.003",
            "here",
        ],
    );
    folder.write(
        "nan.csv",
        with_force(|i| if i == 0 { "nan".into() } else { "1".into() }),
    );
    folder.fail(
        &format!("render nan.csv {CONTACT} {HAND}"),
        3,
        &["nan.csv:3:1: `nan`"],
    );
    folder.write(
        "twice.csv",
        "t_s,force_on_device_n,position_m,force_on_device_n\n0,0,0,0\n1,0,0,0\n",
    );
    folder.fail(
        &format!("render twice.csv {CONTACT} {HAND}"),
        3,
        &["names the column `force_on_device_n` twice"],
    );
}

#[test]
fn a_hand_comes_from_standard_input_too() {
    let folder = with_taps();
    let arguments = format!("{CONTACT} {HAND} --json");
    let from_file = folder.succeed(&format!("render tap.csv {arguments}"));
    let answer = folder.palpate_reading(folder.read("tap.csv"), &format!("render - {arguments}"));
    assert_eq!(
        answer.stdout.replace("standard input", "tap.csv"),
        from_file
    );
}

/// Without parameters, a hand has the default stiffness; nothing is carried away.
#[test]
fn a_hand_of_which_nothing_is_said_holds_on_to_its_motion() {
    let folder = with_taps();
    let render = format!("render tap.csv {CONTACT} --replay hand --device-mass 0.25");
    let report = folder.json(&render);
    let replay = &report["replay"];
    assert_eq!(number(replay, "hand_stiffness_n_per_m"), 60.0);
    assert_eq!(number(replay, "hand_damping_n_s_per_m"), 2.0);
    assert_eq!(replay["hand_is_assumed"], true);
    let departure = replay["largest_departure_m"][0].as_f64().unwrap();
    assert!((1e-4..0.1).contains(&departure), "{departure} m");
    let words = folder.succeed(&render);
    for said in [
        "its impedance is 60 N/m and 2 N s/m (assumed; change it with --hand-stiffness and",
        "mm, by up to: coupled ",
    ] {
        assert!(in_a_line(&words).contains(said), "no {said:?} in:\n{words}");
    }
    let stated = folder.json(&format!("{render} --hand-stiffness 60 --hand-damping 2"));
    assert_eq!(stated["replay"]["hand_is_assumed"], false);
    assert_eq!(stated["methods"], report["methods"]);
}

/// The weight of the block carries away a hand without stiffness: such results are rejected before the report.
#[test]
fn what_no_hand_can_follow_is_refused() {
    let folder = with_taps();
    folder.write("long.csv", trace_text(&taps(0.001, 4.0)));
    let free = "--replay hand --device-mass 0.25 --hand-stiffness 0 --hand-damping 0";
    folder.fail(
        &format!("render long.csv {CONTACT} {free}"),
        2,
        &[
            "long.csv: held by a hand of 0 N/m and 0 N s/m, the device leaves the recorded motion by",
            "farther than an arm reaches (1 m)",
            "--hand-stiffness 60 --hand-damping 2",
        ],
    );
    // A wall of such a light touch carries nothing away, and is replayed as before.
    let light = "--stiffness 10 --mass inf --period 0.01 --object-position 1";
    let report = folder.json(&format!("render long.csv {light} {free}"));
    assert_eq!(report["replay"]["hand_stiffness_n_per_m"], 0.0);
}
