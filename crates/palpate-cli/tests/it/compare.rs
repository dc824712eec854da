//! `palpate compare`: scenes and methods in one table.

use crate::common::{Folder, METHODS, experiment_text, number};
use serde_json::Value;

fn folder() -> Folder {
    let folder = Folder::new();
    for name in ["fig2", "experiment2", "wall"] {
        folder.write(&format!("{name}.toml"), experiment_text(name));
    }
    folder
}

fn row<'a>(comparison: &'a Value, scene: usize, method: &str) -> &'a Value {
    comparison["scenes"][scene]["methods"]
        .as_array()
        .unwrap()
        .iter()
        .find(|row| row["method"] == method)
        .unwrap()
}

#[test]
fn every_figure_is_that_of_the_simulation() {
    let folder = folder();
    let comparison = folder.json("compare fig2.toml experiment2.toml wall.toml");
    assert_eq!(comparison["format"], "palpate compare 1");
    assert_eq!(comparison["scenes"].as_array().unwrap().len(), 3);
    for (scene, name) in ["fig2", "experiment2", "wall"].into_iter().enumerate() {
        let report = folder.json(&format!("simulate {name}.toml --method all"));
        let group = &comparison["scenes"][scene];
        assert_eq!(group["scene"], format!("{name}.toml"));
        assert_eq!(group["title"], report["title"]);
        assert_eq!(group["hold_bound_percent"], report["hold_bound_percent"]);
        assert_eq!(group["methods"].as_array().unwrap().len(), METHODS.len());
        for method in METHODS {
            let (row, expected) = (
                row(&comparison, scene, method),
                crate::common::of_method(&report, method),
            );
            for key in [
                "mean_force_error_percent",
                "force_rendering_error_percent",
                "error_over_bound",
                "absolute_leak_held_j",
                "diverged",
                "parameters",
            ] {
                assert_eq!(row[key], expected[key], "{name} {method} {key}");
            }
            let peak = number(row, "peak_over_ideal") * number(group, "ideal_peak_force_n");
            let expected = number(expected, "peak_force_n");
            assert!((peak / expected - 1.0).abs() < 1e-12, "{name} {method}");
        }
    }
    // The paper's peak; that of the basic model is half as much again.
    assert!((number(&comparison["scenes"][0], "ideal_peak_force_n") - 5.52).abs() < 0.01);
}

#[test]
fn the_table_marks_the_best_and_the_broken() {
    let folder = folder();
    let text = folder.succeed("compare fig2.toml experiment2.toml");
    let best: Vec<&str> = text
        .lines()
        .filter(|line| line.starts_with(" * "))
        .collect();
    assert!(best.iter().all(|line| line.contains(" coupled ")), "{text}");
    assert_eq!(best.len(), 2, "{text}");
    let text = folder.succeed(
        "compare fig2.toml experiment2.toml \
         --method basic,seh,virtual-damper,popc,popc-ref,hfcr-mod,hfcr-mod-st,hfcr",
    );
    let (first, second) = text.split_at(text.find("Paper, experiment 2").unwrap());
    let marked = |part: &str, mark: &str| -> Vec<String> {
        let marked = part
            .lines()
            .filter(|line| line.starts_with(&format!(" {mark} ")));
        marked
            .map(|line| line.split_whitespace().nth(1).unwrap().to_owned())
            .collect()
    };
    assert_eq!(marked(first, "*"), ["hfcr"]);
    assert!(marked(first, "!").is_empty());
    assert_eq!(
        marked(second, "!"),
        ["basic", "seh", "virtual-damper", "popc-ref", "hfcr-mod"]
    );
    // The damper has a lower error than some stable methods, but it diverged.
    assert_eq!(marked(second, "*"), ["hfcr"]);
}

#[test]
fn a_method_that_cannot_be_set_up_says_why_and_the_others_run() {
    let folder = folder();
    // For such a soft contact 3 K T is 0, which is not a valid cap, and K T^2 is 0, which is not a valid mass.
    let text = experiment_text("wall")
        .replace("stiffness_n_per_m = 1000", "stiffness_n_per_m = 5e-324")
        .replace("collisions = 3", "duration_s = 0.2");
    folder.write("soft.toml", text);
    let comparison = folder.json("compare soft.toml");
    for method in METHODS {
        let row = row(&comparison, 0, method);
        let setting = match method {
            "popc" | "popc-ref" | "energy-tank" => Some("damping_cap_n_s_per_m is 0 N s/m"),
            "virtual-coupling" => Some("coupling_mass_kg is 0 kg"),
            _ => None,
        };
        if let Some(is) = setting {
            let why = format!("{is}, but must be finite and greater than 0");
            assert_eq!(row["cannot"], why.as_str(), "{method}");
            assert_eq!(row.get("diverged"), None, "{method}");
        } else {
            assert_eq!(row.get("cannot"), None, "{method}");
            assert_eq!(row["diverged"], false, "{method}");
        }
    }
    let model = folder.succeed("compare soft.toml --out soft.csv");
    assert_eq!(
        model
            .matches("cannot be set up: damping_cap_n_s_per_m is 0")
            .count(),
        3,
        "{model}"
    );
    assert!(folder.read("soft.csv").contains(",popc,"));
    let text = experiment_text("wall");
    folder.write("gap.toml", &text);
    folder.fail("compare nothing.toml", 1, &["nothing.toml"]);
    folder.write("bad.toml", text.replace("period_s = 0.001", "period_s = 0"));
    folder.fail(
        "compare gap.toml bad.toml",
        3,
        &["bad.toml:7:12: loop.period_s is 0 s"],
    );
    folder.fail("compare", 2, &["<SCENE.toml>"]);
    folder.fail(
        "compare gap.toml --method hfrc",
        2,
        &["did you mean \"hfcr\"?"],
    );
}

#[test]
fn the_table_is_written_as_csv() {
    let folder = folder();
    let model =
        folder.succeed("compare fig2.toml experiment2.toml --method basic,hfcr --out t.csv");
    assert!(model.contains("wrote t.csv"), "{model}");
    let text = folder.read("t.csv");
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 5);
    assert!(lines[0].starts_with("scene,title,method,tuned,period_s,kappa,hold_bound_percent,"));
    assert!(
        lines[3].starts_with("experiment2.toml,\"Paper, experiment 2"),
        "{}",
        lines[3]
    );
    assert!(lines[3].contains(",basic,,0.02,0.64,35."), "{}", lines[3]);
    assert!(lines[3].contains(",true,,,0,"), "{}", lines[3]);
    folder.fail(
        "compare fig2.toml --out fig2.toml",
        2,
        &["--out would overwrite the input fig2.toml"],
    );
}

#[test]
fn integrators_of_the_object_are_rows_with_their_least_mass() {
    let folder = Folder::new();
    folder.write("fig2.toml", experiment_text("fig2"));
    let asked = "compare fig2.toml --method basic --integrators";
    let comparison = folder.json(asked);
    let scene = &comparison["scenes"][0];
    let rows = scene["methods"].as_array().unwrap();
    let error = |row: usize| number(&rows[row], "force_rendering_error_percent");
    let names: Vec<_> = rows.iter().map(|row| row["method"].as_str()).collect();
    let expected = [
        "basic",
        "exact",
        "midpoint",
        "explicit",
        "semi-implicit",
        "implicit",
    ];
    assert_eq!(names, expected.map(Some));
    // The sampled spring moves its object exactly.
    assert_eq!(error(0), error(1));
    assert!(error(3) > 1.2 * error(1) && error(5) < 0.2 * error(1));
    // K = 100 N/m at 10 ms.
    assert!((number(scene, "least_explicit_mass_kg") - 0.0025).abs() < 1e-12);
    let text = folder.succeed(asked);
    assert!(
        text.contains("passive") && text.contains("0.00250 kg"),
        "{text}"
    );
    folder.write("paddle.toml", experiment_text("worlds/paddle"));
    folder.fail("compare paddle.toml --integrators", 2, &["one contact"]);
}
