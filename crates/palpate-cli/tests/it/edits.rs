//! `--set`, sweeps over a key, several seeds, and the words of figures.

use crate::common::{Folder, experiment_text, number, of_method};
use serde_json::Value;

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("fig2.toml", experiment_text("fig2"));
    folder.write("world.toml", experiment_text("worlds/pushed-block"));
    folder
}

#[test]
fn an_edit_is_read_as_if_it_stood_in_the_file() {
    let folder = folder();
    let text = experiment_text("fig2").replace("period_s = 0.01", "period_s = 0.004");
    folder.write("edited.toml", text);
    let expected = folder.json("simulate edited.toml --method all");
    let mut found = folder.json("simulate fig2.toml --method all --set loop.period_s=0.004");
    let title = found["title"].as_str().unwrap();
    assert!(title.ends_with("(changed: loop.period_s=0.004)"), "{title}");
    found["title"] = expected["title"].clone();
    assert_eq!(found, expected);
    for command in [
        "tune {} --from 0.01 --to 0.02 --steps 2 --method hfcr",
        "compare {}",
        "paper heights {}",
    ] {
        let of = |scene| {
            let report = folder.json(&command.replace("{}", scene)).to_string();
            let report = report.replace(" (changed: loop.period_s=0.004)", "");
            report.replace("edited.toml", "fig2.toml")
        };
        assert_eq!(
            of("fig2.toml --set loop.period_s=0.004"),
            of("edited.toml"),
            "{command}"
        );
    }
}

#[test]
fn errors_of_an_edit_name_the_flag() {
    let folder = folder();
    for (command, words) in [
        (
            "simulate fig2.toml --set body.0.mas_kg=1",
            &["--set body.0.mas_kg=1: unknown key mas_kg, did you mean mass_kg?"][..],
        ),
        (
            "compare fig2.toml --set contact.stiffness_n_per_m=-1",
            &[
                "--set contact.stiffness_n_per_m=-1: ",
                "-1 N/m",
                "greater than 0",
            ],
        ),
        (
            "simulate world.toml --set body.block.mass_kg=-1",
            &["--set body.block.mass_kg=-1: ", "mass is -1"],
        ),
        (
            "run world.toml --set body.mass_kg=1 --fast",
            &["choose one of body[block], body[table]"],
        ),
        (
            "pipe --stiffness 400 --mass 0.1 --period 0.01 --set body.mass_kg=1",
            &["--set body.mass_kg=1: pipe without a scene file has no such keys"],
        ),
        (
            "sweep fig2.toml --over body.0.mass_kg --values 0.1,-1",
            &["--over body.0.mass_kg, value -1: ", "greater than 0"],
        ),
        (
            "sweep fig2.toml --over body.0.fixed --values 1",
            &["--over body.0.fixed, value 1: ", "expected a boolean"],
        ),
        (
            "sweep fig2.toml --over loop.period_s --from 0 --to 1 --steps 3 --log",
            &["--from 0 --to 1", "with --log be above 0"],
        ),
        (
            "sweep world.toml --over body.block.mass_kg --values 0.1 --collisions 3",
            &["--collisions: world.toml is a world"],
        ),
        (
            "sweep world.toml --over body.block.mass_kg --values 0.1 --columns any.toml",
            &["--columns: world.toml is a world", "[methods.NAME]"],
        ),
        (
            "sweep fig2.toml --over body.0.mass_kg --values 0.1 --and mass",
            &["--and-values"],
        ),
    ] {
        folder.fail(command, 2, words);
    }
}

/// The scene in a recording is the edited one, and a replay may edit it again.
#[test]
fn a_recording_has_the_edited_scene_and_a_replay_edits_it() {
    let folder = folder();
    folder.succeed(
        "run world.toml --fast --duration 0.05 --record w.mcap --set body.block.mass_kg=0.25",
    );
    let text = folder.succeed("info w.mcap --text world");
    assert!(text.contains("mass_kg = 0.25"), "{text}");
    folder.succeed("replay w.mcap --set body.block.mass_kg=0.5");
    folder.fail(
        "replay w.mcap --set body.block.mass=0.5",
        2,
        &["unknown key mass, did you mean mass_kg?"],
    );
    folder.succeed("run fig2.toml --fast --duration 0.2 --record c.mcap --set body.0.mass_kg=0.25");
    let text = folder.succeed("info c.mcap --text scene");
    assert!(text.contains("mass_kg = 0.25"), "{text}");
    let report = folder.json("replay c.mcap --set body.0.mass_kg=0.5");
    assert_eq!(number(&report, "object_mass_kg"), 0.5);
}

#[test]
fn a_sweep_over_a_key_has_the_results_of_each_value_alone() {
    let folder = folder();
    let sweep = "sweep fig2.toml --over contact.stiffness_n_per_m --from 50 --to 200 --steps 3 --log \
                 --method basic,coupled --out k.csv --plot k.svg";
    let report = folder.json(sweep);
    let values = report["values"].as_array().unwrap();
    assert_eq!(values[1]["value"], 100.0);
    let alone = folder
        .json("simulate fig2.toml --method basic,coupled --set contact.stiffness_n_per_m=200");
    for (column, method) in values[2]["columns"]
        .as_array()
        .unwrap()
        .iter()
        .zip(["basic", "coupled"])
    {
        assert_eq!(
            column["mean_force_error_percent"],
            of_method(&alone, method)["mean_force_error_percent"]
        );
    }
    let table = folder.read("k.csv");
    assert_eq!(table.lines().count(), 1 + 3 * 2, "{table}");
    assert!(
        table.starts_with("over,value,and,and_value,column,method,"),
        "{table}"
    );
    assert!(folder.read("k.svg").contains("contact.stiffness_n_per_m"));

    let worlds =
        folder.json("sweep world.toml --over body.block.mass_kg --values 0.1,0.2 --method basic");
    let alone = folder.json("simulate world.toml --method basic --set body.block.mass_kg=0.2");
    assert_eq!(
        worlds["values"][1]["columns"][0]["mean_force_error_percent"],
        alone["methods"][0]["sum"]["mean_force_error_percent"]
    );
}

/// A map of a world over two quantities has the results of the edited scenes, and start heights around each.
#[test]
fn a_world_is_swept_over_quantities_pairs_and_start_heights() {
    let folder = folder();
    let map = folder.json(
        "sweep world.toml --over stiffness --values 0.5,1 --and body.block.mass_kg --and-values 0.1,0.2 --method \
         basic --out map.csv --plot map.svg",
    );
    assert_eq!(map["and"], "body.block.mass_kg");
    let values = map["values"].as_array().unwrap();
    assert_eq!((values.len(), &values[3]["and_value"]), (4, &0.2.into()));
    let error = |report: &Value| report["columns"][0]["mean_force_error_percent"].clone();
    let alone = folder.json("simulate world.toml --method basic --set body.block.mass_kg=0.2");
    assert_eq!(
        error(&values[3]),
        alone["methods"][0]["sum"]["mean_force_error_percent"]
    );
    assert_ne!(error(&values[1]), error(&values[3]));
    assert_eq!(folder.read("map.csv").lines().count(), 5);
    assert!(folder.read("map.svg").contains("body.block.mass_kg 0.2"));

    let heights = folder.json("paper heights world.toml --method basic");
    let of = &heights["scenes"][0]["columns"][0]["mean_force_error_percent"];
    assert_eq!(
        of["own"],
        folder.json("simulate world.toml --method basic")["methods"][0]["sum"]["mean_force_error_percent"]
    );
    assert!(of["worst"].as_f64() > of["median"].as_f64(), "{of}");
    let swept = folder.json("sweep world.toml --over mass --values 1 --heights --method basic");
    let column = &swept["values"][0]["columns"][0];
    assert_eq!(
        column["worst_force_rendering_error_percent"],
        heights["scenes"][0]["columns"][0]["force_rendering_error_over_heights_percent"]["worst"]
    );
    folder.fail(
        "sweep world.toml --over box --values 0.1",
        3,
        &["pantograph has a safety box"],
    );
    let at_the_body = "--set device.0.position_m.0=-0.024";
    folder.fail(
        &format!("paper heights world.toml --method basic {at_the_body}"),
        3,
        &["no start height to vary"],
    );
}

#[test]
fn tune_and_heights_write_their_tables() {
    let folder = folder();
    folder.succeed("tune fig2.toml --method hfcr --from 0.01 --to 0.02 --steps 2 --out tune.csv");
    assert_eq!(folder.read("tune.csv").lines().count(), 3);
    folder.succeed("paper heights fig2.toml --method basic,hfcr --out heights.csv");
    assert_eq!(folder.read("heights.csv").lines().count(), 3);
    folder.fail("paper heights fig2.toml --out fig2.toml", 2, &["fig2.toml"]);
}

#[test]
fn several_seeds_have_means_and_paired_differences() {
    let folder = folder();
    let seeds = "--method basic,coupled --seeds 4 --start-range 0.001";
    for (scene, place) in [
        ("fig2.toml", "/scenes/0/seeded"),
        ("world.toml", "/scenes/0/seeded"),
    ] {
        let report = folder.json(&format!("compare {scene} {seeds}"));
        let seeded = report.pointer(place).unwrap();
        assert_eq!(
            (&seeded["seeds"], &seeded["least"]),
            (&4.into(), &"coupled".into())
        );
        let basic = &seeded["methods"][0];
        assert_eq!(basic["worse_seeds"], 4);
        let mean = &basic["mean_force_error_percent"];
        assert!(
            number(mean, "low") < number(mean, "mean")
                && number(mean, "mean") < number(mean, "high")
        );
    }
    let report = folder.json(&format!("simulate fig2.toml {seeds}"));
    let compared = folder.json(&format!("compare fig2.toml {seeds}"));
    assert_eq!(report["seeded"], compared["scenes"][0]["seeded"]);
    let text = folder.succeed(&format!("simulate world.toml {seeds}"));
    assert!(
        text.contains("minus coupled (95 %)") && text.contains("4 of 4"),
        "{text}"
    );
    folder.fail(
        "compare world.toml --method basic --seeds 2",
        2,
        &[
            "--seeds 2: nothing is random in this scene",
            "--start-range",
        ],
    );
    folder.fail(
        "compare fig2.toml --seeds 2 --start-range 0",
        2,
        &["--start-range is 0 m, but must be finite and greater than 0"],
    );
}

#[test]
fn a_figure_has_the_words_that_it_is_given() {
    let folder = folder();
    let draw = |flags: &str| {
        folder.succeed(&format!(
            "simulate fig2.toml --plot f.svg --overwrite {flags}"
        ));
        folder.read("f.svg")
    };
    let usual = draw("");
    assert!(usual.contains("Paper, Fig. 2"));
    let bare = draw("--title none --caption none");
    assert!(!bare.contains("Paper, Fig. 2") && bare.len() < usual.len());
    assert!(draw("--title Bounce").contains("Bounce"));
    folder.fail(
        "simulate fig2.toml --title none",
        2,
        &["--title is for a figure"],
    );
}

/// E of the report is that of the means in the table.
#[test]
fn a_worlds_signals_have_those_of_the_ideal() {
    let folder = folder();
    let report = folder.json("simulate world.toml --method basic,coupled --out s.csv --plot s.svg");
    let text = folder.read("s.csv");
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let header = lines.next().unwrap();
    let place = |name: &str| header.iter().position(|column| *column == name).unwrap();
    let [mean, ideal] = ["mean_fx_n", "ideal_fx_n"].map(place);
    let [mut basic, mut coupled] = [(0.0, 0.0); 2];
    for row in lines {
        let sums = if row[0] == "basic" {
            &mut basic
        } else {
            &mut coupled
        };
        for axis in 0..3 {
            let [held, ideal] = [mean, ideal].map(|at| row[at + axis].parse::<f64>().unwrap());
            sums.0 += (held - ideal) * (held - ideal);
            sums.1 += ideal * ideal;
        }
    }
    assert!(coupled.0 < 0.01 * basic.0, "{basic:?} {coupled:?}");
    assert_eq!(basic.1, coupled.1);
    // E is relative to the force itself, which exceeds its means.
    let sum = &report["methods"][0]["sum"];
    let found = 100.0 * f64::sqrt(basic.0 / basic.1);
    let expected = number(sum, "mean_force_error_percent");
    assert!((found / expected - 1.0).abs() < 0.02, "{found} {expected}");
    let figure = folder.read("s.svg");
    for words in [
        "force x [N]",
        "off ideal",
        "penetration x [mm]",
        "contacts",
        "deepest penetration",
        "generated energy",
        "time [s]",
    ] {
        assert!(figure.contains(words), "{words}");
    }
    folder.fail("simulate world.toml --out -", 2, &["--out -"]);
}
