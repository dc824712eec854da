//! `palpate suite` and `palpate paper heights`.

use crate::common::{Folder, METHODS, experiment, number, of_method, parse};
use serde_json::Value;

fn column<'a>(report: &'a Value, name: &str) -> &'a Value {
    let columns = report["columns"].as_array().unwrap();
    columns
        .iter()
        .find(|column| column["name"] == name)
        .unwrap_or_else(|| panic!("no {name} in {report}"))
}

/// Returns the rows of a table as maps from its header.
fn rows(text: &str) -> Vec<std::collections::HashMap<&str, &str>> {
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    // The metadata is the last column and may contain commas.
    lines
        .map(|line| {
            header
                .iter()
                .copied()
                .zip(line.splitn(header.len(), ','))
                .collect()
        })
        .collect()
}

#[test]
fn sets_with_actuators_are_evaluated_by_model_condition() {
    let folder = Folder::new();
    let report = folder
        .json("suite --set real --plants 3 --out rows.csv --plot spread.svg --write-scenes plants");
    assert_eq!(report["set"], "real");
    let names: Vec<&Value> = report["columns"].as_array().unwrap().iter().collect();
    let names: Vec<&str> = (names.iter())
        .map(|column| column["name"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["coupled", "hfcr", "virtual-damper, best B of each"]);
    let conditions = column(&report, "coupled")["conditions"].as_array().unwrap();
    let said: Vec<&str> = (conditions.iter())
        .map(|found| found["condition"].as_str().unwrap())
        .collect();
    let expected = ["actuator unmodelled", "true model", "calibrated model"];
    assert_eq!(said, expected);
    let median = |place: usize| number(&conditions[place]["mean_force_error_percent"], "median");
    assert!(median(1) < 0.5 * median(0) && median(2) < 0.5 * median(0));

    let text = folder.read("rows.csv");
    let rows = rows(&text);
    assert_eq!(rows.len(), 3 * 3 * 3);
    assert!(rows[0]["palpate_run_1"].contains("\"\"set\"\":\"\"real\"\""));
    let svg = folder.read("spread.svg");
    assert!(expected.iter().all(|words| svg.contains(words)));
    // A row is a scene and a command.
    let row = rows
        .iter()
        .find(|row| {
            (row["plant"], row["column"], row["condition"]) == ("1", "coupled", "calibrated model")
        })
        .unwrap();
    let single = folder.json("simulate plants/plant-0001.toml --method coupled");
    let error = number(of_method(&single, "coupled"), "mean_force_error_percent");
    let of_row: f64 = row["mean_force_error_percent"].parse().unwrap();
    assert!((error / of_row - 1.0).abs() < 1e-12, "{error} {of_row}");

    let refused = folder.palpate("suite --set table");
    assert_eq!(refused.code, 2, "{refused:?}");
    assert!(
        refused
            .stderr
            .contains("the sets are paper, desk, real, calibrated, steps")
    );
}

#[test]
fn every_method_is_evaluated_in_all_delay_conditions() {
    let folder = Folder::new();
    let report = folder.json("suite --plants 6 --out rows.csv --plot spread.svg");
    assert_eq!(report["format"], "palpate suite 1");
    assert_eq!((&report["seed"], &report["plants"]), (&1.into(), &6.into()));
    assert_eq!(report["collisions"], 3);
    assert!(number(&report, "ideal_error") < 1e-4);
    let names: Vec<&str> = report["columns"]
        .as_array()
        .unwrap()
        .iter()
        .map(|column| column["name"].as_str().unwrap())
        .collect();
    assert_eq!(names, METHODS);
    for (place, delay, model) in [(0, 0, 0), (1, 1, 1), (2, 1, 0)] {
        let found = &column(&report, "hfcr")["delays"][place];
        assert_eq!(found["delay_samples"], delay);
        assert_eq!(found["model_delay_samples"], model);
        let error = &found["mean_force_error_percent"];
        let quantiles =
            ["median", "quantile_75", "quantile_90", "largest"].map(|name| number(error, name));
        assert!(quantiles.is_sorted() && quantiles[0] > 1.0, "{error}");
        assert!(number(&found["error_over_bound"], "median") > 1.0);
    }
    let text = folder.read("rows.csv");
    let rows = rows(&text);
    assert_eq!(rows.len(), 6 * 3 * METHODS.len());
    assert_eq!(rows[0]["plant"], "0");
    assert_eq!(rows[rows.len() - 1]["plant"], "5");
    assert!(
        rows[0]["palpate_run_1"].contains("\"\"seed\"\":\"\"1\"\""),
        "{rows:?}"
    );
    // The rows form a run file that other readers accept.
    assert_eq!(folder.run_file("rows.csv").len(), rows.len());
    let svg = folder.read("spread.svg");
    roxmltree::Document::parse(&svg).unwrap();
    for words in [
        "no delay",
        "1 sample of delay",
        "mean-force error E [%]",
        ">100<",
        "hfcr",
    ] {
        assert!(svg.contains(words), "no {words:?} in the figure");
    }
}

#[test]
fn each_row_is_a_scene_and_a_command() {
    let folder = Folder::new();
    folder.succeed(
        "suite --plants 4 --seed 9 --method hfcr,coupled --write-scenes plants --out rows.csv",
    );
    let text = folder.read("rows.csv");
    let rows = rows(&text);
    assert_eq!(rows.len(), 24);
    for row in rows {
        let model_delay = row["model_delay_samples"].parse::<f64>().unwrap()
            * row["period_s"].parse::<f64>().unwrap();
        let text = folder.succeed(&format!(
            "simulate plants/plant-000{}.toml --method {} --delay-periods {} --model-delay {model_delay} --json",
            row["plant"], row["method"], row["delay_samples"]
        ));
        let report = parse(&text);
        let found = of_method(&report, row["method"]);
        for name in [
            "mean_force_error_percent",
            "force_rendering_error_percent",
            "error_over_bound",
            "peak_force_n",
            "hold_bound_percent",
            "ideal_error",
        ] {
            // As text: the JSON reader is sometimes off by a bit.
            let same = format!("\"{name}\": {},\n", row[name]);
            assert!(text.contains(&same), "no {same} in {text}");
        }
        assert_eq!(row["diverged"] == "yes", found["diverged"] == true);
        for (at, collision) in found["collisions"].as_array().unwrap().iter().enumerate() {
            for what in ["impulse", "peak_force"] {
                let error = collision[format!("{what}_error_percent")].as_f64();
                let cell = row[format!("collision_{}_{what}_error_percent", at + 1).as_str()];
                match (cell.parse::<f64>().ok(), error) {
                    (Some(cell), Some(error)) => {
                        assert!((cell - error).abs() < 1e-12 * error.abs().max(1.0))
                    }
                    (cell, error) => assert_eq!(cell, error, "{collision}"),
                }
            }
        }
    }
}

#[test]
fn a_delay_that_is_not_in_the_model_is_a_condition_of_its_own() {
    let folder = Folder::new();
    let report = folder.json("suite --plants 4 --method hfcr,coupled");
    let median = |name, place: usize| {
        let found = &column(&report, name)["delays"][place];
        number(&found["mean_force_error_percent"], "median")
    };
    assert_eq!(column(&report, "hfcr")["models_delay"], false);
    assert_eq!(median("hfcr", 2), median("hfcr", 1));
    assert_eq!(column(&report, "coupled")["models_delay"], true);
    let [modelled, unmodelled] = [1, 2].map(|place| median("coupled", place));
    assert!(
        modelled < 15.0 && unmodelled > 80.0,
        "{modelled} {unmodelled}"
    );
    let table = folder.succeed("suite --plants 2 --method hfcr,coupled");
    let (_, last) = table.split_once("1 sample of delay, unmodelled").unwrap();
    assert!(
        last.contains(" coupled ") && !last.contains(" hfcr "),
        "{table}"
    );
    assert!(
        last.contains("The other methods do not use the model of the delay"),
        "{table}"
    );
}

#[test]
fn several_seeds_give_medians_with_their_range() {
    let folder = Folder::new();
    let of = |arguments: &str| {
        let report = folder.json(&format!("suite --plants 5 --method hfcr {arguments}"));
        let found = column(&report, "hfcr")["delays"][0].clone();
        (report, found)
    };
    let mut each: Vec<f64> = (3..6)
        .map(|seed| {
            let (report, found) = of(&format!("--seed {seed}"));
            assert!(report.get("seeds").is_none() && found.get("over_seeds").is_none());
            number(&found["mean_force_error_percent"], "median")
        })
        .collect();
    each.sort_by(f64::total_cmp);
    let (report, found) = of("--seed 3 --seeds 3 --out rows.csv");
    assert_eq!(
        (&report["seeds"], &report["plants"]),
        (&3.into(), &15.into())
    );
    let spread = &found["over_seeds"]["median_percent"];
    assert_eq!(
        ["least", "median", "largest"].map(|name| number(spread, name)),
        each[..]
    );
    let rows = folder.run_file("rows.csv");
    let seeds = rows.numbers("seed").unwrap();
    assert_eq!(seeds.len(), 3 * 5 * 3);
    assert_eq!((seeds[0], seeds[44]), (3.0, 5.0));
    let table = folder.succeed("suite --plants 5 --method hfcr --seed 3 --seeds 3");
    let shown = format!("{:.1} ({:.1}-{:.1})", each[1], each[0], each[2]);
    assert!(
        table.contains("seeds 3 to 5") && table.contains(&shown),
        "{shown}\n{table}"
    );
    folder.fail(
        "suite --plants 1 --seeds 2 --write-scenes plants",
        2,
        &["--write-scenes"],
    );
    folder.fail("suite --seeds 0", 2, &["--seeds"]);

    // Also with worlds.
    let of = |arguments: &str| folder.json(&format!("suite --set worlds --plants 1 {arguments}"));
    let basic = |report: &Value| report["loops"][0]["methods"][0].clone();
    let [first, second] = [1, 2].map(|seed| {
        let report = of(&format!("--seed {seed}"));
        assert!(report.get("seeds").is_none() && basic(&report).get("over_seeds").is_none());
        number(&basic(&report), "median_percent")
    });
    let both = of("--seeds 2");
    assert_eq!(both["seeds"], 2);
    let spread = &basic(&both)["over_seeds"]["median_percent"];
    assert_eq!(number(spread, "least"), first.min(second));
    assert_eq!(number(spread, "largest"), first.max(second));
    assert!(first != second);
}

#[test]
fn variants_of_a_method_are_columns_of_their_own() {
    let folder = Folder::new();
    folder.write(
        "variants.toml",
        "[plain]\nmethod = \"hfcr\"\n\n[auto]\nmethod = \"hfcr\"\ndamping_n_s_per_m = \"auto\"\n",
    );
    let report = folder.json("suite --plants 3 --columns variants.toml --plot both.svg");
    let median = |name| {
        number(
            &column(&report, name)["delays"][0]["mean_force_error_percent"],
            "median",
        )
    };
    assert_ne!(median("plain"), median("auto"));
    let plain = folder.json("suite --plants 3 --method hfcr");
    let error = &column(&plain, "hfcr")["delays"][0]["mean_force_error_percent"];
    assert_eq!(median("plain"), number(error, "median"));
    let table = folder.succeed("suite --plants 3 --columns variants.toml");
    for words in [
        "3 random plants, seed 1",
        "no delay",
        "1 sample of delay",
        " auto ",
    ] {
        assert!(table.contains(words), "no {words:?} in:\n{table}");
    }
}

/// A committed file of columns.
fn committed(name: &str) -> String {
    let path = crate::common::experiment(&format!("columns/{name}"));
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path:?}: {e}"))
}

#[test]
fn a_column_may_choose_its_damping_and_says_which() {
    let folder = Folder::new();
    folder.write("damper.toml", committed("damper"));
    folder.write("fig2.toml", crate::common::experiment_text("fig2"));
    let suite = "suite --plants 3 --columns damper.toml";
    let report = folder.json(&format!("{suite} --out rows.csv"));
    for delay in 0..2 {
        let error = |name| {
            let found = &column(&report, name)["delays"][delay]["mean_force_error_percent"];
            number(found, "largest")
        };
        assert!(error("damper, best B") <= error("damper, one B"));
        assert!(error("hfcr, best b") <= error("hfcr"));
    }
    let rows = folder.run_file("rows.csv");
    let dampings = rows.numbers("damping_n_s_per_m").unwrap();
    for (name, damping) in rows.texts("column").unwrap().iter().zip(dampings) {
        let chooses = name.contains(',');
        assert_eq!(damping.is_finite(), chooses, "{name}: {damping}");
    }
    let heights = "paper heights fig2.toml --columns damper.toml";
    let table = folder.succeed(heights);
    assert!(table.contains("best B"), "{table}");
    let report = folder.json(heights);
    let chosen = &report["scenes"][0]["columns"][1];
    assert_eq!(chosen["name"], "damper, best B");
    let damping = number(chosen, "damping_n_s_per_m");
    let alone = folder.json(&format!(
        "simulate fig2.toml --method virtual-damper --damping {damping}"
    ));
    let own = number(&chosen["mean_force_error_percent"], "own");
    let error = number(
        crate::common::of_method(&alone, "virtual-damper"),
        "mean_force_error_percent",
    );
    assert!((own - error).abs() < 1e-9 * own);
    // Without a choice, nothing is printed about it.
    let plain = folder.succeed("paper heights fig2.toml --method hfcr");
    assert!(!plain.contains("best B"), "{plain}");
}

#[test]
fn the_other_committed_columns_are_understood() {
    let folder = Folder::new();
    for name in ["ablation", "damper-scan", "guard", "readme"] {
        folder.write("columns.toml", committed(name));
        folder.succeed("suite --plants 1 --columns columns.toml");
    }
}

#[test]
fn what_a_guard_held_back_is_counted() {
    let folder = Folder::new();
    folder.write("guard.toml", committed("guard"));
    let suite = "suite --plants 6 --columns guard.toml";
    let report = folder.json(suite);
    let of = |name, what| number(&column(&report, name)["delays"][0], what);
    assert_eq!(of("coupled", "limited_plants"), 0.0);
    assert!(of("coupled, guarded", "limited_plants") >= 1.0);
    assert!(of("coupled, guarded", "limited_samples_percent") > 0.0);
    let table = folder.succeed(suite);
    assert!(table.contains("limited plants"), "{table}");
    let plain = folder.succeed("suite --plants 1 --method hfcr --plot one.svg");
    let figure = std::fs::read_to_string(folder.path("one.svg")).unwrap();
    assert!(figure.contains(">1 random plant,"), "{figure}");
    assert!(!plain.contains("limited plants"), "{plain}");
}

#[test]
fn what_a_suite_cannot_do_is_an_error_that_says_why() {
    let folder = Folder::new();
    folder.write("bad.toml", "[a]\nmethod = \"seh\"\ndamping_n_s_per_m = 1\n");
    folder.write(
        "negative.toml",
        "[a]\nmethod = \"hfcr\"\ndamping_n_s_per_m = -1\n",
    );
    folder.write("file", "");
    for (arguments, code, words) in [
        ("--plants 0", 2, ["--plants", "1..=1000000"]),
        ("--plants many", 2, ["--plants", "many"]),
        ("--seed -1", 2, ["-1", "a whole number from 0 on"]),
        ("--seed 1.5", 2, ["--seed", "1.5"]),
        ("--method hfrc", 2, ["hfrc", "hfcr"]),
        (
            "--method hfcr --columns bad.toml",
            2,
            ["--method", "--columns"],
        ),
        (
            "--columns nowhere.toml",
            1,
            ["nowhere.toml", "No such file"],
        ),
        (
            "--columns bad.toml",
            3,
            ["bad.toml: column a", "seh cannot use it"],
        ),
        (
            "--plants 1 --columns negative.toml",
            3,
            ["column a on plant 0", "-1 N s/m"],
        ),
        ("--plot spread.gif", 2, ["spread.gif", ".svg"]),
        ("--plot a.svg --out a.svg", 2, ["same file", "--plot"]),
        (
            "--plants 1 --method seh --write-scenes file",
            1,
            ["file", "exists"],
        ),
    ] {
        folder.fail(&format!("suite {arguments}"), code, &words);
    }
    assert_eq!(folder.names(), ["bad.toml", "file", "negative.toml"]);
}

#[test]
fn hfcr_hardly_depends_on_the_start_height() {
    let folder = Folder::new();
    let scenes = ["fig2", "experiment1", "experiment2"].map(experiment);
    let scenes = scenes.map(|path| path.display().to_string()).join(" ");
    let report = folder.json(&format!("paper heights {scenes} --model-mass-factor 1.5"));
    assert_eq!(report["format"], "palpate heights 1");
    assert_eq!(report["model_mass_factor"], 1.5);
    for (scene, known) in [(0, [10.0, 11.0]), (1, [15.0, 15.0]), (2, [100.0, 107.0])] {
        let report = &report["scenes"][scene];
        let error = &column(report, "hfcr-mod-st")["mean_force_error_percent"];
        let found = ["median", "worst"].map(|name| number(error, name).round());
        assert_eq!(found, known);
        let (total, floor) = (
            number(
                column(report, "hfcr-mod-st"),
                "force_rendering_error_percent",
            ),
            number(report, "hold_bound_percent"),
        );
        assert!((total.hypot(0.0) - floor.hypot(number(error, "own"))).abs() < 1e-9);
    }
    let table = folder.succeed(&format!("paper heights {scenes} --method basic"));
    for words in [
        "21 start heights within ±5 %",
        "model mass 1 times",
        "Fig. 2",
        "120.05",
        "0 of 21",
    ] {
        assert!(table.contains(words), "no {words:?} in:\n{table}");
    }
}

#[test]
fn what_has_no_heights_is_an_error_that_says_why() {
    let folder = Folder::new();
    let scene = experiment("fig2").display().to_string();
    let text = crate::common::experiment_text("fig2");
    folder.write(
        "apart.toml",
        text.replace("collisions = 3", "duration_s = 0.05"),
    );
    folder.write("bad.toml", text.replace("period_s = 0.01", "period_s = 0"));
    for (arguments, code, words) in [
        (
            format!("{scene} --model-mass-factor 0"),
            2,
            "--model-mass-factor is 0",
        ),
        (
            format!("{scene} --model-mass-factor nan"),
            2,
            "--model-mass-factor is NaN",
        ),
        (String::new(), 2, "<SCENE.toml>"),
        ("nowhere.toml".into(), 1, "nowhere.toml"),
        ("bad.toml".into(), 3, "bad.toml:7:12: loop.period_s is 0 s"),
        (
            "apart.toml".into(),
            3,
            "apart.toml: the ideal has no contact",
        ),
    ] {
        folder.fail(&format!("paper heights {arguments}"), code, &[words]);
    }
}

#[test]
fn model_device_mass_may_differ_from_true_mass() {
    let folder = Folder::new();
    let scene = experiment("fig2").display().to_string();
    let damping = |flags: &str| {
        let report = folder.json(&format!(
            "simulate {scene} --method hfcr --damping auto {flags}"
        ));
        (
            number(
                &of_method(&report, "hfcr")["parameters"],
                "damping_n_s_per_m",
            ),
            number(&report, "kappa"),
        )
    };
    let (right, kappa) = damping("");
    let (model, same) = damping("--model-device-mass 0.15");
    assert!(
        model < right && same == kappa,
        "{model} {right} {same} {kappa}"
    );
    assert_eq!(damping("--model-device-mass 0.1").0, right);
    folder.write(
        "model.toml",
        crate::common::experiment_text("fig2")
            .replace("[render]", "[model]\ndevice_mass_kg = 0.15\n\n[render]"),
    );
    let report = folder.json("simulate model.toml --method hfcr --damping auto --out run.csv");
    let parameters = &of_method(&report, "hfcr")["parameters"];
    assert_eq!(number(parameters, "damping_n_s_per_m"), model);
    assert!(folder.read("run.csv").contains("renderer_device_mass_kg"));
    folder.fail(
        &format!("simulate {scene} --model-device-mass 0"),
        2,
        &["--model-device-mass is 0 kg, but must be finite and greater than 0"],
    );
    folder.fail(
        "pipe --stiffness 1 --mass 1 --period 1 --model-device-mass 1",
        2,
        &[
            "--model-device-mass is for simulate and tune",
            "--device-mass",
        ],
    );
}
