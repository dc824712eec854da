//! `palpate simulate` with a world.

mod common;

use common::{Folder, parse, schema};
use serde_json::Value;

const BALL: &str = r#"
format = 2
title = "A tool juggles a ball on the floor"
[loop]
period_s = 0.001
[[device]]
name = "tool"
mass_kg = 0.25
position_m = [0.004, 0.0, 0.08]
hand_force_n = [0.0, 0.0, -1.0]
tool = { sphere = { radius_m = 0.01 } }
[[body]]
name = "ball"
mass_kg = 0.1
position_m = [0.0, 0.0, 0.03]
force_n = [0.0, 0.0, -0.981]
shape = { sphere = { radius_m = 0.03 } }
[[body]]
name = "floor"
fixed = true
shape = { half_space = { normal = [0.0, 0.0, 1.0] } }
[[contact]]
between = ["*", "*"]
stiffness_n_per_m = 4000.0
damping_n_s_per_m = 1.0
[render]
device_mass_kg = 0.375
[measure]
duration_s = 0.3
"#;

fn error(report: &Value, method: &str) -> f64 {
    let methods = report["methods"].as_array().unwrap();
    let of = methods.iter().find(|it| it["method"] == method).unwrap();
    of["sum"]["mean_force_error_percent"].as_f64().unwrap()
}

#[test]
#[allow(clippy::print_stdout)] // what was measured
fn coupled_renders_a_world_at_the_floor_of_its_loop_where_the_spring_force_does_not() {
    let folder = Folder::new();
    folder.write("ball.toml", BALL);
    let report = folder.json("simulate ball.toml --method basic,coupled");
    assert_eq!(schema::check(&report), "world");
    let (basic, coupled) = (error(&report, "basic"), error(&report, "coupled"));
    println!("E: basic {basic} %, coupled {coupled} %, told one and a half times the mass");
    assert!(basic > 5.0 && coupled < 0.3, "{basic} {coupled}");
    // The judge agrees with itself, and the whole window was judged.
    assert!(report["ideal_error_percent"].as_f64().unwrap() < 0.01);
    assert_eq!(report["chaotic_from_s"], Value::Null);
    assert_eq!(report["samples"], 300);
}

#[test]
fn without_a_method_the_scenes_own_is_run_and_the_text_explains_its_columns() {
    let folder = Folder::new();
    folder.write("ball.toml", BALL);
    let text = folder.succeed("simulate ball.toml");
    let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
    for said in [
        "A tool juggles a ball",
        " E: error",
        "FRE: error",
        "Leak: energy",
    ] {
        assert_eq!(words.matches(said).count(), 1, "{said}: {text}");
    }
    assert!(
        words.contains("coupled") && !words.contains("basic"),
        "{text}"
    );
    assert!(
        text.lines().all(|line| line.chars().count() <= 80),
        "{text}"
    );
}

#[test]
fn a_world_that_cannot_be_judged_or_rendered_says_why() {
    let folder = Folder::new();
    for (right, wrong, code, why) in [
        (
            "duration_s = 0.3",
            "duration_s = 3e4",
            3,
            "at most 1e6 are run",
        ),
        (
            "shape = { sphere = { radius_m = 0.03 } }",
            "shape = { cylinder = { radius_m = 0.03, length_m = 0.02 } }",
            3,
            "\"ball\"",
        ),
    ] {
        folder.write("wrong.toml", BALL.replace(right, wrong));
        let answer = folder.palpate("simulate wrong.toml");
        assert_eq!(answer.code, code, "{answer:?}");
        assert!(answer.stderr.contains(why), "{answer:?}");
    }
    folder.write("ball.toml", BALL);
    folder.fail(
        "simulate ball.toml --stiffness 5",
        2,
        &["--stiffness", "is a world"],
    );
    folder.fail("compare ball.toml", 3, &["format is 2, a world"]);
}

#[test]
fn an_overlap_at_the_start_is_rendered_and_said() {
    let folder = Folder::new();
    folder.write(
        "ball.toml",
        BALL.replace("[0.004, 0.0, 0.08]", "[0.004, 0.0, 0.068]"),
    );
    let text = folder.succeed("simulate ball.toml");
    let said = "\"tool\" and \"ball\" overlap at the start";
    assert_eq!(text.matches(said).count(), 1, "{text}");
    folder.write("ball.toml", BALL);
    assert!(!folder.succeed("simulate ball.toml").contains("overlap"));
}

#[test]
fn the_json_of_a_scene_is_the_same_on_every_run() {
    let folder = Folder::new();
    folder.write("ball.toml", BALL);
    let run = || folder.succeed("simulate ball.toml --method all --json");
    let first = run();
    assert_eq!(first, run());
    let report = parse(&first);
    let names: Vec<_> = report["methods"]
        .as_array()
        .unwrap()
        .iter()
        .map(|it| it["method"].clone())
        .collect();
    assert!(
        names.contains(&"basic".into()) && names.contains(&"coupled".into()),
        "{names:?}"
    );
}

#[test]
fn errors_of_forces_and_torques_stand_apart_for_a_device_of_six_axes() {
    let folder = Folder::new();
    let file = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../experiments/worlds/box.toml"
    );
    let report = folder.json(&format!("simulate {file} --method basic,coupled"));
    assert_eq!(schema::check(&report), "world");
    let device = &report["methods"][1]["devices"][0];
    let of = |value: &Value| value["mean_force_error_percent"].as_f64().unwrap();
    let all = [
        of(&device["sum"]),
        of(&device["force"]),
        of(&device["torque"]["sum"]),
    ];
    assert!(
        all.iter().all(|error| *error > 1e-3 && *error < 1.0),
        "{all:?}"
    );
    assert!(error(&report, "basic") > 5.0);
    let text = folder.palpate(&format!("simulate {file} --method coupled"));
    assert!(text.stdout.contains("of the torque"), "{}", text.stdout);
}
