//! `palpate tune`: the curve of a method's damping.

use crate::common::{Folder, experiment, experiment_text, number};

fn fig2() -> String {
    experiment("fig2").display().to_string()
}

#[test]
fn the_best_damping_and_the_whole_curve_are_reported() {
    let folder = Folder::new();
    let report = folder.json(&format!(
        "tune {} --method virtual-damper --to 2 --steps 201 --plot curve.svg",
        fig2()
    ));
    assert_eq!(report["format"], "palpate tune 1");
    assert_eq!(report["method"], "virtual-damper");
    assert_eq!(report["setting"], "damping_n_s_per_m");
    assert_eq!(report["start_heights"], 21);
    assert!((number(&report["best"], "value_n_s_per_m") - 0.39).abs() < 1e-9);
    let own = &report["best_at_own_height"];
    assert!((number(own, "value_n_s_per_m") - 0.53).abs() < 1e-9);
    let error = &own["mean_force_error_percent"];
    assert!((number(error, "own") - 15.52).abs() < 0.02, "{error}");
    assert!(number(error, "median") > 80.0, "{error}");
    let curve = report["curve"].as_array().unwrap();
    assert_eq!(curve.len(), 201);
    assert!((number(&curve[200], "value_n_s_per_m") - 2.0).abs() < 1e-12);
    assert_eq!(report["files"], serde_json::json!(["curve.svg"]));
    let svg = folder.read("curve.svg");
    roxmltree::Document::parse(&svg).unwrap();
    assert!(svg.contains("median height") && svg.contains("damping [N s/m]"));
}

#[test]
fn the_least_leak_is_not_the_least_error() {
    let folder = Folder::new();
    let best = |least: &str| {
        let report = folder.json(&format!(
            "tune {} --method hfcr --to 2 --steps 101 --least {least}",
            experiment("experiment2").display()
        ));
        number(&report["best"], "value_n_s_per_m")
    };
    assert_ne!(best("leak"), best("error"));
}

#[test]
fn the_table_says_what_is_best_where() {
    let folder = Folder::new();
    let table = folder.succeed(&format!("tune {} --method popc-ref --steps 20", fig2()));
    for words in [
        "damping cap of popc-ref, 20 values",
        "21 start heights within ±5 %",
        "in the median",
        "at the scene's own height",
        "of 21",
    ] {
        assert!(table.contains(words), "no {words:?} in:\n{table}");
    }
}

#[test]
fn what_cannot_be_tuned_is_an_error_that_says_why() {
    let folder = Folder::new();
    let scene = fig2();
    for (arguments, words) in [
        ("--method seh", "seh has no damping to tune"),
        ("--method all", "tune varies one method"),
        (
            "--method hfcr --damping 1",
            "--damping is the setting that tune varies",
        ),
        ("--method hfcr --from 3 --to 1", "--from 3 --to 1"),
        ("--method hfcr --to nan", "must be finite"),
        ("--method hfcr --steps 1", "--steps"),
        ("--method hfcr --stiffness -1", "--stiffness is -1 N/m"),
        ("--method hfcr --plot curve.gif", "curve.gif"),
    ] {
        folder.fail(&format!("tune {scene} {arguments}"), 2, &[words]);
    }
    let apart = experiment_text("fig2").replace("collisions = 3", "duration_s = 0.05");
    folder.write("apart.toml", apart);
    folder.fail(
        "tune apart.toml --method hfcr",
        3,
        &["no contact in the window"],
    );
    assert_eq!(folder.names(), ["apart.toml"]);
}
