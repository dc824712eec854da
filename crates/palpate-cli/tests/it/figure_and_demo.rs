//! `palpate paper figure` and `palpate demo`: pictures without any input.

use std::time::{Duration, Instant};

use crate::common::{Folder, number, of_method, parse};

/// Checks that a file is an SVG document that shows every one of `words` as text.
fn drawn(folder: &Folder, name: &str, words: &[&str]) {
    let text = folder.read(name);
    let document = roxmltree::Document::parse(&text).unwrap_or_else(|e| panic!("{name}: {e}"));
    let root = document.root_element();
    assert_eq!(root.tag_name().name(), "svg");
    assert!(root.attribute("viewBox").is_some() || root.attribute("width").is_some());
    assert!(
        !text.contains("NaN") && !text.contains("inf\""),
        "{name} has no numbers in places"
    );
    let shown: Vec<_> = document
        .descendants()
        .filter_map(|node| node.text())
        .collect();
    for word in words {
        assert!(
            shown.iter().any(|text| text.contains(word)),
            "{name} does not show {word:?}"
        );
    }
}

#[test]
fn fig2_is_drawn_step_by_step() {
    let folder = Folder::new();
    let table = folder.succeed("paper figure fig2");
    assert_eq!(folder.names(), ["fig2.svg"]);
    let steps = [
        "basic model",
        "modified force",
        "+ smooth transitions",
        "+ leak dissipation",
    ];
    drawn(&folder, "fig2.svg", &steps);
    drawn(
        &folder,
        "fig2.svg",
        &["position [mm]", "force on object [N]", "time [s]", "ideal"],
    );
    assert!(table.contains("wrote fig2.svg"), "{table}");
}

#[test]
fn fig2_report_errors_decrease_with_each_step() {
    let folder = Folder::new();
    let report = folder.json("paper figure fig2 --plot steps.svg");
    assert_eq!(report["files"], serde_json::json!(["steps.svg"]));
    let errors = ["basic", "hfcr-mod", "hfcr-mod-st", "hfcr"]
        .map(|method| number(of_method(&report, method), "force_rendering_error_percent"));
    assert!(
        errors.is_sorted_by(|a, b| a > b),
        "each step is better: {errors:?}"
    );
    assert!((errors[2] - 14.96).abs() < 0.02, "{errors:?}");
}

#[test]
fn the_drawings_name_what_they_show() {
    let folder = Folder::new();
    assert_eq!(folder.succeed("paper figure fig1"), "wrote fig1.svg\n");
    let modes = [
        "(a) free motion",
        "contact",
        "(b) sampled loop",
        "zero-order hold",
        "p = ξ − η > 0",
        "f = K (ξ − η)",
        "device, m",
        "object, M",
        "K",
        "η",
        "ξ",
        "−f",
    ];
    drawn(&folder, "fig1.svg", &modes);
    let report = folder.json("paper figure fig3 --plot linkage.svg");
    assert_eq!(report["format"], "palpate figure 1");
    assert_eq!(report["files"], serde_json::json!(["linkage.svg"]));
    let joints = [
        "A",
        "B",
        "end-point P, m",
        "θ",
        "d",
        "l",
        "L",
        "x",
        "y",
        "r",
    ];
    drawn(&folder, "linkage.svg", &joints);
}

#[test]
fn leak_dissipation_is_drawn_over_ten_collisions() {
    let folder = Folder::new();
    let table = folder.succeed("paper figure fig2-long");
    assert!(table.contains("10 ideal collisions"), "{table}");
    assert!(table.contains("b = 0, 0.0125, 0.03, 0.05 N s/m"), "{table}");
    drawn(
        &folder,
        "fig2-long.svg",
        &["b = 0 N s/m: FRE 92.3 %", "b = 0.03 N s/m: FRE 30.1 %"],
    );
}

#[test]
fn an_experiment_says_how_true_the_paper_s_truth_is_and_shows_coupled_rendering() {
    let folder = Folder::new();
    let table = folder.succeed("paper figure fig5-box");
    assert!(table.contains("left the safety box at 0.34 s"), "{table}");
    let shown = [
        "basic at 1 kHz, itself 105 % off the ideal",
        "coupled (ours): FRE 35.0 %",
        "HFCR: FRE 93.2 %",
        "the object's centre",
    ];
    drawn(&folder, "fig5-box.svg", &shown);
}

#[test]
fn a_figure_without_a_place_leaves_nothing() {
    let folder = Folder::new();
    folder.fail(
        "paper figure fig2 --plot no/fig2.svg",
        1,
        &["no directory `no`"],
    );
    folder.fail(
        "paper figure fig2 --plot fig2.gif",
        2,
        &["fig2.gif", ".svg, .pdf or .png"],
    );
    assert!(folder.names().is_empty());
}

#[test]
fn figures_of_runs_are_documents_with_titles() {
    let folder = Folder::new();
    folder.write(
        "hand & eye <1>.csv",
        "t_s,position_m\n0,-0.01\n0.05,0.02\n0.1,-0.01\n",
    );
    let output = assert_cmd::Command::cargo_bin("palpate")
        .unwrap()
        .current_dir(folder.path("."))
        .args(["render", "hand & eye <1>.csv", "--plot", "run.svg"])
        .args("--stiffness 400 --mass 0.1 --period 0.01 --method all".split_whitespace())
        .output()
        .unwrap();
    assert!(output.status.success());
    drawn(
        &folder,
        "run.svg",
        &[
            "hand & eye <1>.csv",
            "virtual-damper",
            "force on object [N]",
        ],
    );
}

#[test]
fn demo_prints_summary_and_writes_its_files() {
    let folder = Folder::new();
    let begun = Instant::now();
    let story = folder.succeed("demo");
    assert!(
        begun.elapsed() < Duration::from_secs(10),
        "{:?}",
        begun.elapsed()
    );
    let demo = folder.path("palpate-demo");
    for file in ["fig2.svg", "hand.svg", "hand.csv"] {
        assert!(
            story.contains(&format!("wrote palpate-demo/{file}")),
            "{file}:\n{story}"
        );
        assert!(demo.join(file).is_file(), "{file}");
    }
    // And the list of them.
    assert_eq!(std::fs::read_dir(demo).unwrap().count(), 4);
    drawn(
        &folder,
        "palpate-demo/fig2.svg",
        &["basic model", "+ leak dissipation", "coupled rendering"],
    );
    drawn(
        &folder,
        "palpate-demo/hand.svg",
        &["hfcr", "popc-ref", "ideal"],
    );
    assert!(
        story.contains("FRE %") && story.contains("Next steps"),
        "{story}"
    );
    let report = folder.json("demo --out-dir other");
    let methods = report["simulation"]["methods"].as_array().unwrap();
    let leak = |name: &str| {
        let found = methods.iter().find(|one| one["method"] == name).unwrap();
        found["absolute_leak_held_j"].as_f64().unwrap()
    };
    let less = format!("has {:.0} times less of it", leak("basic") / leak("hfcr"));
    assert!(story.contains(&less), "{less}:\n{story}");
}

#[test]
fn where_to_go_next_is_a_way() {
    let folder = Folder::new();
    let story = folder.succeed("demo --out-dir first");
    let next = story
        .split("Next steps")
        .nth(1)
        .unwrap()
        .replace("\\\n", " ");
    let render = next
        .lines()
        .find(|line| line.contains("palpate render"))
        .unwrap();
    let arguments = render.trim().trim_start_matches("palpate ");
    let arguments = &arguments[..arguments.find("run.svg").unwrap() + "run.svg".len()];
    folder.succeed(arguments);
    assert_eq!(folder.names(), ["first", "run.csv", "run.svg"]);
    // The file contains the hand of the demonstration.
    let report = folder.json(&format!("{arguments} --overwrite"));
    let demo = folder.json("demo --out-dir first");
    let error = |report| {
        number(
            of_method(report, "coupled"),
            "force_rendering_error_percent",
        )
    };
    assert!((error(&report) - error(&demo["hand"])).abs() < 1e-3);
}

#[test]
fn the_demo_gives_the_same_bytes_every_time() {
    let folder = Folder::new();
    let story = folder.succeed("demo");
    let bytes = |name| folder.read(&format!("palpate-demo/{name}"));
    let first = ["fig2.svg", "hand.svg", "hand.csv"].map(bytes);
    assert_eq!(folder.succeed("demo"), story, "over its own files");
    assert_eq!(["fig2.svg", "hand.svg", "hand.csv"].map(bytes), first);
}

#[test]
fn the_demo_reports_both_parts_as_json() {
    let folder = Folder::new();
    let report = parse(&folder.succeed("demo --json"));
    assert_eq!(report["format"], "palpate demo 1");
    for (part, methods) in [("simulation", 5), ("hand", 6)] {
        let part = &report[part];
        assert_eq!(part["format"], "palpate report 1");
        assert_eq!(part["methods"].as_array().unwrap().len(), methods);
    }
    // Main point of the demonstration: on the same motion, HFCR generates almost no energy.
    let leak = |method| number(of_method(&report["hand"], method), "absolute_leak_held_j");
    assert!(
        leak("hfcr") < 0.05 * leak("basic"),
        "{} {}",
        leak("hfcr"),
        leak("basic")
    );
    // In closed loop and with the hand alike, coupled rendering is at the zero-order-hold bound.
    for part in ["simulation", "hand"] {
        let error = |method| {
            let entry = of_method(&report[part], method);
            number(entry, "mean_force_error_percent")
        };
        assert!(error("coupled") < 0.2 * error("hfcr"), "{part}");
    }
}

#[test]
fn a_folder_that_cannot_be_made_is_named() {
    let folder = Folder::new();
    folder.write("taken", "");
    folder.fail(
        "demo --out-dir taken",
        1,
        &["cannot create the folder `taken`"],
    );
    folder.fail("demo --out-dir taken/below", 1, &["`taken/below`"]);
}

#[test]
fn the_experiments_stand_beside_the_paper_s_numbers() {
    let folder = Folder::new();
    for (figure, measured) in [
        ("fig4", ["17.1", "51.1", "84.9"]),
        ("fig5", ["52.2", "failed", "failed"]),
    ] {
        let table = folder.succeed(&format!("paper figure {figure}"));
        for words in measured
            .iter()
            .chain(&["virtual pantograph", "to basic at 1 kHz"])
        {
            assert!(table.contains(words), "no {words} in:\n{table}");
        }
        drawn(
            &folder,
            &format!("{figure}.svg"),
            &[
                "basic model",
                "SEH",
                "virtual damper",
                "POPC-REF",
                "HFCR",
                "HFCR: FRE",
                "force [N]",
                "leak [mJ]",
            ],
        );
    }
    drawn(
        &folder,
        "fig5.svg",
        &["safety box left", "left the safety box at 0.76 s"],
    );
    let report = folder.json("paper figure fig5 --overwrite");
    let left = |method| &of_method(&report, method)["left_box_at_s"];
    assert_eq!(left("virtual-damper").as_f64(), Some(0.76));
    assert!(left("hfcr").is_null());
    let report = folder.json("paper figure fig4 --overwrite");
    let error = |method| number(of_method(&report, method), "mean_force_error_percent");
    for other in ["basic", "seh", "virtual-damper", "popc-ref"] {
        assert!(error("hfcr") < error(other), "{other}");
    }
}
