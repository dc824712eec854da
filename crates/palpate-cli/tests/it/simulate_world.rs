//! `palpate simulate`, `compare`, `tune` and `render` with a world.

mod guard;
mod recorded;

use crate::common::{Folder, parse, schema};
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
hand.force_n = [0.0, 0.0, -1.0]
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
[model]
device_mass_kg = 0.375
[render]
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
    // The reference solution has converged, and the whole window was evaluated.
    assert!(report["ideal_error_percent"].as_f64().unwrap() < 0.01);
    assert_eq!(report["chaotic_from_s"], Value::Null);
    assert_eq!(report["samples"], 300);
}

/// The floor in the axes of a body that is 2 mm higher, and rotated so that its -x points up.
#[test]
fn half_space_of_offset_rotated_body_gives_same_force_error() {
    let folder = Folder::new();
    folder.write("ball.toml", BALL);
    let placed = BALL.replace(
        "shape = { half_space = { normal = [0.0, 0.0, 1.0] } }",
        "position_m = [0.0, 0.0, 0.002]
orientation = [1.0, 0.0, 1.0, 0.0]
shape = { half_space = { normal = [-1.0, 0.0, 0.0], offset_m = -0.002 } }",
    );
    assert_ne!(placed, BALL);
    folder.write("placed.toml", placed);
    let [plain, placed] = ["ball", "placed"]
        .map(|name| folder.json(&format!("simulate {name}.toml --method basic,coupled")));
    for method in ["basic", "coupled"] {
        let (one, other) = (error(&plain, method), error(&placed, method));
        assert!((one - other).abs() < 1e-4, "{method}: {one} {other}");
    }
    assert_eq!(
        placed["overlapping_at_start"],
        plain["overlapping_at_start"]
    );
}

/// With a contact of 100 MN/m on a ball of 50 g a tick of 1 ms overflows.
#[test]
fn a_setting_with_which_samples_are_refused_is_not_the_best_for_its_missing_leak() {
    let folder = Folder::new();
    let stiff = BALL
        .replace("stiffness_n_per_m = 4000.0", "stiffness_n_per_m = 1e8")
        .replace("[0.004, 0.0, 0.08]", "[0.004, 0.0, 0.069]")
        .replace("duration_s = 0.3", "duration_s = 0.05");
    folder.write("stiff.toml", stiff);
    let command = "tune stiff.toml --method god-object --least leak";
    let tuned = folder.json(command);
    let refused = |point: &Value| point["refused_samples"].as_u64().unwrap();
    let all = tuned["curve"].as_array().unwrap();
    assert!(all.iter().any(|point| refused(point) > 0), "{tuned}");
    let fewest = all.iter().map(refused).min().unwrap();
    assert_eq!(refused(&tuned["best"]), fewest, "{tuned}");
    let text = folder.succeed(command);
    assert!(text.contains(" refused"), "{text}");
}

/// At 10 ms a contact of 400 N/mm on a device of 50 g is stable with soft couplings only, and with no damper; at 100
/// MN/m the renderer rejects samples with every setting.
#[test]
fn where_every_setting_runs_away_softer_ones_are_tried_or_none_is_found() {
    let folder = Folder::new();
    let slow = BALL
        .replace("period_s = 0.001", "period_s = 0.01")
        .replace("mass_kg = 0.25", "mass_kg = 0.05")
        .replace("[0.004, 0.0, 0.08]", "[0.004, 0.0, 0.072]");
    let with = |stiffness: &str| slow.replace("stiffness_n_per_m = 4000.0", stiffness);
    folder.write("stiff.toml", with("stiffness_n_per_m = 4e5"));
    folder.write("stiffest.toml", with("stiffness_n_per_m = 1e8"));

    let tuned = folder.json("tune stiff.toml --method virtual-coupling");
    assert_eq!(schema::check(&tuned), "world-tune");
    let setting = &tuned["best"]["settings"]["coupling_stiffness_n_per_m"];
    assert_eq!(tuned["found"], true);
    assert!(setting.as_f64().unwrap() < 0.1 * 4e5, "{tuned}");
    let command =
        "compare stiff.toml --method virtual-damper,virtual-coupling,coupled --out table.csv";
    let compared = folder.json(command);
    assert_eq!(schema::check(&compared), "compare");
    let coupling = row(&compared, "virtual-coupling");
    assert_eq!(
        coupling["mean_force_error_percent"],
        tuned["best"]["mean_force_error_percent"]
    );
    assert_eq!(coupling["tuned"], tuned["curve"].as_array().unwrap().len());
    let none = row(&compared, "virtual-damper")["none_found"].as_str();
    assert!(none.unwrap().contains("no setting found"), "{compared}");
    assert!(folder.read("table.csv").contains("no setting found"));

    let tune = "tune stiffest.toml --method virtual-coupling";
    let tuned = folder.json(tune);
    assert_eq!(tuned["found"], false);
    let text = folder.succeed(tune);
    assert!(
        text.contains("no setting found") && !text.contains("In [methods"),
        "{text}"
    );
    let text = folder.succeed("compare stiffest.toml --method virtual-coupling");
    assert!(text.contains("no setting found"), "{text}");
}

/// With a contact of 10 GN/m a tick of 1 ms overflows: the report contains the time and the reason of the first
/// rejected sample.
#[test]
fn a_world_with_a_contact_that_is_too_fast_says_why_its_samples_are_refused() {
    let folder = Folder::new();
    let stiff = BALL
        .replace("stiffness_n_per_m = 4000.0", "stiffness_n_per_m = 1e10")
        .replace("[0.004, 0.0, 0.08]", "[0.004, 0.0, 0.069]")
        .replace("duration_s = 0.3", "duration_s = 0.02");
    folder.write("stiff.toml", stiff);
    folder.write("ball.toml", BALL);
    let report = folder.json("simulate stiff.toml --method coupled");
    assert_eq!(schema::check(&report), "world");
    let method = &report["methods"][0];
    assert!(method["refused_samples"].as_u64().unwrap() > 0, "{method}");
    let first = &method["first_refusal"];
    assert_eq!(first["fault"], "overflow", "{first}");
    assert_eq!(first["too_fast"], true, "{first}");
    assert_eq!(first["device"], Value::Null, "{first}");
    assert!(first["time_s"].as_f64().unwrap() < 0.02, "{first}");
    let text = folder.succeed("simulate stiff.toml --method coupled");
    let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        words.contains("The first, at ") && words.contains("too stiff or too damped"),
        "{text}"
    );
    let taken = folder.json("simulate ball.toml --method coupled");
    assert_eq!(taken["methods"][0]["first_refusal"], Value::Null);
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
fn invalid_world_is_rejected_with_reason() {
    let folder = Folder::new();
    for (right, wrong, code, why) in [
        (
            "duration_s = 0.3",
            "duration_s = 3e4",
            3,
            "at most 1e6 are allowed",
        ),
        (
            "shape = { sphere = { radius_m = 0.03 } }",
            "shape = { mesh = { vertices_m = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0]], faces = [[0, 1, 2]] } }\n\
             inertia_kg_m2 = [1e-4, 1e-4, 1e-4]",
            3,
            "\"ball\" and \"floor\": it is flat or nearly flat",
        ),
        (
            "format = 2",
            "format = 3",
            3,
            "wrong.toml:2:10: format is 3, but must be 2",
        ),
        (
            "between = [\"*\", \"*\"]",
            "between = [\"ball\", \"ball\"]",
            3,
            "\"ball\" cannot touch itself; give two different names",
        ),
        (
            "[[device]]",
            "[[device]]\nname = \"second\"\nmass_kg = 0.1\ntool = { sphere = { radius_m = 0.01 } }\n\
             [[contact]]\nbetween = [\"second\", \"tool\"]\nstiffness_n_per_m = 9.0\n[[device]]",
            3,
            "two tools do not touch each other",
        ),
        (
            "normal = [0.0, 0.0, 1.0]",
            "normal = [0.0, 0.0, 0.0]",
            3,
            "normal has length 0, so it has no direction",
        ),
        (
            "mass_kg = 0.1",
            "mass_kg = 0.1\ninertia_kg_m2 = [1.0, 5.0, 2.0]",
            3,
            "inertia has a moment of 5, and it has to be at most the sum of the other two, 3",
        ),
    ] {
        folder.write("wrong.toml", BALL.replace(right, wrong));
        let answer = folder.palpate("simulate wrong.toml");
        assert_eq!(answer.code, code, "{answer:?}");
        assert!(answer.stderr.contains(why), "{answer:?}");
    }
    // A normal may have any length.
    for length in ["1e-300", "1e300"] {
        let long = BALL.replace(
            "normal = [0.0, 0.0, 1.0]",
            &format!("normal = [0.0, 0.0, {length}]"),
        );
        folder.write("long.toml", long);
        assert_eq!(folder.palpate("simulate long.toml").code, 0);
    }
    folder.write("ball.toml", BALL);
    folder.fail(
        "simulate ball.toml --stiffness 5",
        2,
        &["--stiffness", "is a world"],
    );
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

/// The row of a method in the first scene of a comparison.
fn row<'a>(comparison: &'a Value, method: &str) -> &'a Value {
    let rows = comparison["scenes"][0]["methods"].as_array().unwrap();
    rows.iter().find(|it| it["method"] == method).unwrap()
}

#[test]
fn compare_takes_the_best_setting_where_the_scene_has_none_and_the_scenes_where_it_has_one() {
    let folder = Folder::new();
    folder.write("ball.toml", BALL);
    let compared = folder.json("compare ball.toml --out table.csv --plot dots.svg");
    assert_eq!(schema::check(&compared), "compare");
    let e = |method: &str| {
        row(&compared, method)["mean_force_error_percent"]
            .as_f64()
            .unwrap()
    };
    let simulated = folder.json("simulate ball.toml --method basic,coupled");
    for method in ["basic", "coupled"] {
        assert_eq!(e(method), error(&simulated, method));
        assert_eq!(row(&compared, method)["tuned"], Value::Null);
    }
    // The smallest tried value is the result of tune, and a damping of 0 is among them.
    for method in ["virtual-damper", "virtual-coupling", "god-object"] {
        let tuned = folder.json(&format!("tune ball.toml --method {method}"));
        assert_eq!(schema::check(&tuned), "world-tune");
        assert_eq!(tuned["best"]["mean_force_error_percent"], e(method));
        assert_eq!(
            tuned["best"]["settings"],
            row(&compared, method)["settings"]
        );
        let curve = tuned["curve"].as_array().unwrap();
        assert_eq!(row(&compared, method)["tuned"], curve.len());
        let errors = curve
            .iter()
            .filter_map(|it| it["mean_force_error_percent"].as_f64());
        assert_eq!(errors.fold(f64::INFINITY, f64::min), e(method));
    }
    assert!(e("virtual-damper") <= e("basic") && e("coupled") < 0.1 * e("virtual-damper"));
    assert_eq!(folder.read("table.csv").lines().count(), 12);
    let figure = folder.read("dots.svg");
    assert!(figure.contains("god-object") && figure.contains("coupled has the least force"));

    folder.write(
        "said.toml",
        BALL.replace(
            "[measure]",
            "[methods.virtual-damper]\ndamping_n_s_per_m = 1.25\n[measure]",
        ),
    );
    let said = folder.json("compare said.toml --method virtual-damper");
    let damper = row(&said, "virtual-damper");
    assert_eq!(damper["tuned"], Value::Null);
    assert_eq!(damper["settings"]["damping_n_s_per_m"], 1.25);
}

#[test]
fn tune_tries_the_dampings_that_are_named_and_refuses_what_has_nothing_to_tune() {
    let folder = Folder::new();
    folder.write("ball.toml", BALL);
    let asked = "tune ball.toml --method virtual-damper --from 1 --to 2 --steps 3 --plot curve.svg";
    let report = folder.json(asked);
    let curve = report["curve"].as_array().unwrap();
    let dampings: Vec<_> = curve
        .iter()
        .map(|it| &it["settings"]["damping_n_s_per_m"])
        .collect();
    assert_eq!(dampings, [1.0, 1.5, 2.0]);
    assert!(folder.read("curve.svg").contains("virtual-damper with B"));
    // 0.4 N s/m leak the least: with fewer dampings the largest is the best one.
    let damper = "tune ball.toml --method virtual-damper --least leak --steps 3 --from 0 --to";
    let words = "has the largest damping that was tried";
    let flat = |asked: String| {
        let text = folder.succeed(&asked);
        text.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    for (to, is_at_the_end) in [("0.2", true), ("1", false)] {
        let text = flat(format!("{damper} {to}"));
        assert_eq!(text.contains(words), is_at_the_end, "{to}: {text}");
    }
    let text = folder.succeed("tune ball.toml --method god-object");
    assert!(text.contains("coupling_stiffness_n_per_m = "), "{text}");
    assert!(
        text.lines().all(|line| line.chars().count() <= 80),
        "{text}"
    );
    folder.fail(
        "tune ball.toml",
        2,
        &["coupled has no setting to tune on a world"],
    );
    folder.fail(
        "tune ball.toml --method virtual-damper --delay-periods 1",
        2,
        &["--delay", "is a world"],
    );
    folder.fail(
        "tune ball.toml --method virtual-damper --steps 3",
        2,
        &["--steps"],
    );
    folder.write("fig2.toml", crate::common::experiment_text("fig2"));
    folder.fail(
        "simulate fig2.toml --method god-object",
        2,
        &["renders worlds only"],
    );
    // One table has scenes of both renderers, each with the numbers of its own simulation.
    let both = folder.json("compare fig2.toml ball.toml --method basic");
    assert_eq!(schema::check(&both), "compare");
    let e = |scene: usize| &both["scenes"][scene]["methods"][0]["mean_force_error_percent"];
    let contact = folder.json("simulate fig2.toml --method basic");
    assert_eq!(*e(0), contact["methods"][0]["mean_force_error_percent"]);
    assert_eq!(
        *e(1),
        folder.json("simulate ball.toml --method basic")["methods"][0]["sum"]["mean_force_error_percent"]
    );
}

#[test]
fn what_the_damper_of_a_joint_takes_is_dissipated() {
    let folder = Folder::new();
    // The ball slides down beside the floor and touches nothing.
    let joint = "[[joint]]\nkind = \"slider\"\nbetween = [\"ball\", \"world\"]\naxis = [0.0, 0.0, 1.0]\n\
                 stiffness_n_per_m = 2e4\nspan_m = 0.04\nalong_damping_n_s_per_m = 2.0\n[render]";
    let slides = BALL
        .replace("[render]", joint)
        .replace(
            "normal = [0.0, 0.0, 1.0]",
            "normal = [0.0, 0.0, 1.0], offset_m = -1.0",
        )
        .replace("hand.force_n = [0.0, 0.0, -1.0]", "");
    folder.write("slides.toml", slides);
    let taken = |report: &Value| report["dissipated_j"].as_f64().unwrap();
    let report = folder.json("simulate slides.toml");
    // The damper dissipates P = F v of the weight, and the ball reaches its speed F/B after some 50 ms.
    let (weight, damping, time): (f64, f64, f64) = (0.981, 2.0, 0.3);
    let late = 0.1 / damping;
    let slowed = late * (-time / late).exp_m1();
    let twice = late / 2.0 * (-2.0 * time / late).exp_m1();
    let expected = weight.powi(2) / damping * (time + 2.0 * slowed - twice);
    let simulated = taken(&report["methods"][0]);
    assert!(
        (simulated / expected - 1.0).abs() < 0.02,
        "{simulated} {expected}"
    );
    let motion = "0.004,0,0.08\n".repeat(300);
    let answer = folder.palpate_reading(motion, "pipe slides.toml --json");
    let summary = parse(&answer.stderr[answer.stderr.find('{').unwrap()..]);
    let piped = taken(&summary);
    assert!((piped / expected - 1.0).abs() < 0.02, "{piped} {expected}");
}

/// A finger falls on a plate of 10 g at 50 Hz: no sample is rejected, but E is some 30 %.
#[test]
fn a_contact_that_swings_within_a_few_periods_is_said() {
    let folder = Folder::new();
    let light = BALL
        .replace("period_s = 0.001", "period_s = 0.02")
        .replace("mass_kg = 0.25", "mass_kg = 0.2")
        .replace("[0.004, 0.0, 0.08]", "[0.003, 0.002, 0.013]")
        .replace("radius_m = 0.01", "radius_m = 0.008")
        .replace("mass_kg = 0.1", "mass_kg = 0.01")
        .replace("[0.0, 0.0, 0.03]", "[0.0, 0.0, 0.00198]")
        .replace("-0.981", "-0.0981")
        .replace(
            "sphere = { radius_m = 0.03 }",
            "box = { size_m = [0.04, 0.04, 0.004] }",
        )
        .replace("4000.0", "4800.0")
        .replace("device_mass_kg = 0.375", "")
        .replace("duration_s = 0.3", "duration_s = 0.6");
    folder.write("light.toml", light);
    let report = folder.json("simulate light.toml");
    let method = &report["methods"][0];
    let count = |key: &str| method[key].as_u64().unwrap();
    let many = count("too_fast_samples");
    assert!(many > 0 && count("refused_samples") == 0, "{method}");
    let said = crate::common::in_a_line(&folder.succeed("simulate light.toml"));
    let words = format!("coupled: at {many} samples a contact or joint swings within");
    assert!(said.contains(&words), "{said}");
    folder.write("ball.toml", BALL);
    let report = folder.json("simulate ball.toml");
    assert_eq!(report["methods"][0]["too_fast_samples"], 0);
}

#[test]
fn all_names_the_methods_that_are_left_out() {
    let folder = Folder::new();
    folder.write("ball.toml", BALL);
    let report = folder.json("simulate ball.toml --method all");
    let methods = |key: &str| -> Vec<String> {
        let all = report[key].as_array().unwrap().iter();
        all.map(|one| one["method"].as_str().unwrap().to_owned())
            .collect()
    };
    let run = [
        "basic",
        "seh",
        "popc",
        "popc-ref",
        "hfcr-mod",
        "hfcr-mod-st",
        "hfcr",
        "coupled",
    ];
    assert_eq!(methods("methods"), run);
    let left_out = ["virtual-damper", "virtual-coupling", "god-object"];
    assert_eq!(methods("left_out"), left_out);
    let text = folder.succeed("simulate ball.toml --method all");
    for method in left_out {
        assert!(
            text.contains(&format!("{method} was left out: {method} needs")),
            "{text}"
        );
    }
}
