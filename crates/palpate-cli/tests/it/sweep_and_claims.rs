//! `palpate sweep` and `palpate paper claims`; scenes with a hand in the motors and with a radius.

use crate::common::{Folder, experiment, experiment_text, number};
use serde_json::Value;

fn column<'a>(value: &'a Value, name: &str) -> &'a Value {
    let columns = value["columns"].as_array().unwrap();
    columns
        .iter()
        .find(|column| column["name"] == name)
        .unwrap_or_else(|| panic!("no {name} in {value}"))
}

#[test]
fn a_sweep_over_the_box_says_who_leaves_when() {
    let folder = Folder::new();
    let scene = experiment("fig5").display().to_string();
    let sweep = format!(
        "sweep {scene} --over box --values 0.1,0.11 --method virtual-damper,popc-ref,coupled"
    );
    let report = folder.json(&sweep);
    assert_eq!(report["format"], "palpate sweep 1");
    assert_eq!(
        (&report["over"], &report["unit"]),
        (&"box".into(), &"m".into())
    );
    let left = |at: usize, name: &str| column(&report["values"][at], name)["left_box_at_s"].clone();
    let at = |at, name| left(at, name).as_f64().unwrap();
    assert!((at(0, "virtual-damper") - 0.32).abs() < 1e-9);
    assert!((at(1, "virtual-damper") - 0.34).abs() < 1e-9);
    assert!((at(1, "popc-ref") - 0.56).abs() < 1e-9);
    assert_eq!(left(0, "coupled"), Value::Null);
    let coupled = column(&report["values"][0], "coupled");
    assert_eq!(coupled["bounce"], "stable");
    assert!((number(coupled, "force_rendering_error_percent") - 35.0).abs() < 0.1);
}

#[test]
fn a_sweep_over_dampings_takes_the_methods_that_have_one_and_all_heights() {
    let folder = Folder::new();
    let scene = experiment("fig2").display().to_string();
    let plain = folder.json(&format!("sweep {scene} --over damping --values 0.01"));
    let names: Vec<_> = plain["values"][0]["columns"]
        .as_array()
        .unwrap()
        .iter()
        .map(|column| column["name"].as_str().unwrap().to_owned())
        .collect();
    let with_damping = [
        "virtual-damper",
        "popc",
        "popc-ref",
        "force-bounding",
        "energy-tank",
        "virtual-coupling",
        "hfcr",
    ];
    assert_eq!(names, with_damping);
    let table = folder.succeed(&format!("sweep {scene} --over damping --values 0.01"));
    for words in [
        "damping 0.01 N s/m: hold bound 11.03 %",
        "rebound",
        "left box s",
        "stable",
    ] {
        assert!(table.contains(words), "{words}:\n{table}");
    }
    let high = folder.json(&format!(
        "sweep {scene} --over damping --values 0,0.0125 --method hfcr --collisions 10 --heights"
    ));
    for (at, [own, median, worst]) in [(0, [92.3, 92.8, 95.5]), (1, [69.5, 69.1, 74.1])] {
        let hfcr = column(&high["values"][at], "hfcr");
        let near = |name: &str, expected: f64| {
            let found = number(hfcr, name);
            assert!((found - expected).abs() < 0.1, "{name}: {found}");
        };
        near("force_rendering_error_percent", own);
        near("median_force_rendering_error_percent", median);
        near("worst_force_rendering_error_percent", worst);
        assert_eq!(hfcr["left_box_heights"], 0);
        assert_eq!(hfcr["almost_stable_heights"], 21);
    }
}

#[test]
fn a_sweep_of_what_is_not_there_says_so() {
    let folder = Folder::new();
    let fig2 = experiment("fig2").display().to_string();
    let fails = |arguments: &str, code, words: &[&str]| {
        folder.fail(&format!("sweep {fig2} {arguments}"), code, words);
    };
    fails(
        "--over box --values 0.1",
        3,
        &["fig2.toml", "pantograph", "safety box"],
    );
    fails(
        "--over friction --values 1",
        3,
        &["no friction to multiply"],
    );
    fails(
        "--over damping --values 1 --method basic",
        3,
        &["column basic", "no damping"],
    );
    fails(
        "--over damping --values -1 --method hfcr",
        3,
        &["damping -1", "not below 0 N s/m"],
    );
    fails("--over weight --values 1", 2, &["friction, box, damping"]);
    fails("--over box --values 1,x", 2, &["a number is needed"]);
    fails("--over box", 2, &["--values"]);
}

#[test]
fn claims_report_contains_verdicts_and_findings() {
    let folder = Folder::new();
    let report = folder.json("paper claims");
    assert_eq!(report["format"], "palpate claims 1");
    let claims = report["claims"].as_array().unwrap();
    let holds: Vec<_> = claims
        .iter()
        .map(|claim| {
            (
                claim["name"].as_str().unwrap(),
                claim["holds"].as_str().unwrap(),
            )
        })
        .collect();
    assert_eq!(
        holds,
        [
            ("remaining leak", "holds in part"),
            ("leak at 1 kHz", "holds in part"),
            ("truth at 1 kHz", "does not hold"),
            ("sensitivity to b", "holds in part"),
            ("SEH almost stable", "holds in part"),
            ("safety box", "holds in part"),
            ("when they leave the box", "holds"),
            ("errors", "holds in part"),
            ("intervals of a collision", "holds in part"),
            ("as difficult at 1 kHz", "holds"),
        ]
    );
    for claim in claims {
        assert!(!claim["found"].as_array().unwrap().is_empty(), "{claim}");
    }
}

#[test]
fn the_place_of_the_hand_s_force_is_a_flag_and_a_key() {
    let folder = Folder::new();
    let edited = experiment_text("fig5")
        .replace("[device.hand]\n", "[device.hand]\nforce_at = \"motors\"\n");
    folder.write("motors.toml", edited);
    folder.write("plain.toml", experiment_text("fig5"));
    let simulate = |arguments: &str| folder.json(&format!("simulate {arguments} --method hfcr"));
    let of = |report: &Value| {
        let hfcr = crate::common::of_method(report, "hfcr");
        number(hfcr, "force_rendering_error_percent")
    };
    let by_key = simulate("motors.toml --out motors.csv");
    let by_flag = simulate("plain.toml --hand-force-at motors");
    let plain = simulate("plain.toml");
    assert_eq!(of(&by_key), of(&by_flag));
    assert!((of(&by_key) - 89.8).abs() < 0.1 && (of(&plain) - 87.3).abs() < 0.1);
    assert_eq!(
        of(&simulate("motors.toml --hand-force-at end-point")),
        of(&plain)
    );
    let run = folder.run_file("motors.csv");
    let said = ("hand_force_at".to_owned(), "motors".to_owned());
    assert!(run.metadata().contains(&said), "{:?}", run.metadata());
    let fig2 = experiment("fig2").display().to_string();
    folder.fail(
        &format!("simulate {fig2} --hand-force-at motors"),
        2,
        &["--hand-force-at motors", "point mass", "pantograph"],
    );
    folder.fail(
        "simulate plain.toml --hand-force-at elbow",
        2,
        &["end-point, motors"],
    );
}

#[test]
fn a_run_of_a_ball_has_its_centre() {
    let folder = Folder::new();
    let ball = experiment_text("fig2").replace(
        "position_m = [0.1,",
        "centre_m = [0.01, 0.0, 0.0]\nposition_m = [0.1,",
    );
    folder.write("ball.toml", ball);
    folder.write("point.toml", experiment_text("fig2"));
    for name in ["ball", "point"] {
        folder.succeed(&format!(
            "simulate {name}.toml --out {name}.csv --plot {name}.svg"
        ));
    }
    let (ball, point) = (folder.read("ball.csv"), folder.read("point.csv"));
    let header = |text: &str| text.lines().next().unwrap().to_owned();
    assert!(
        header(&ball).contains(",method,object_centre_m,"),
        "{}",
        header(&ball)
    );
    assert!(!header(&point).contains("object_centre_m"));
    let run = folder.run_file("ball.csv");
    let values = |name: &str| run.numbers(name).unwrap();
    let (place, centre) = (values("object_position_m"), values("object_centre_m"));
    assert!(place.len() > 70);
    for (place, centre) in place.iter().zip(&centre) {
        assert_eq!(place + 0.01, *centre);
    }
    // The drawn object moves, and the drawn force does not.
    assert_ne!(folder.read("ball.svg"), folder.read("point.svg"));
}
