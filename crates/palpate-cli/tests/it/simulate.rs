//! `palpate simulate`: a scene in closed loop, its metrics, and flags that override its values.

use crate::common::{Folder, METHODS, experiment, experiment_text, number, of_method};
use palpate_scene::ContactFile;
use palpate_scene::method::MethodName;
use palpate_study::sim::closed_loop::Bench;
use serde_json::Value;

/// A folder with the scene of Fig. 2.
fn with_scene() -> Folder {
    let folder = Folder::new();
    folder.write("scene.toml", experiment_text("fig2"));
    folder
}

fn committed(name: &str, arguments: &str) -> Value {
    let scene = experiment(name);
    let report = Folder::new().json(&format!("simulate {} {arguments}", scene.display()));
    assert_eq!(report["format"], "palpate report 1");
    report
}

fn close(found: f64, expected: f64) {
    assert!((found - expected).abs() < 0.02, "{found} for {expected}");
}

#[test]
fn fig2_has_the_published_errors() {
    let report = committed("fig2", "--method hfcr-mod-st");
    close(number(&report, "hold_bound_percent"), 11.03);
    let method = of_method(&report, "hfcr-mod-st");
    close(number(method, "force_rendering_error_percent"), 14.96);
    close(number(method, "mean_force_error_percent"), 10.11);
    close(number(&report, "kappa"), 0.1);
    close(number(&report, "object_kappa"), 0.1);
    assert_eq!(
        (&report["ideal_collisions"], &method["diverged"]),
        (&3.into(), &false.into())
    );
}

#[test]
fn the_basic_model_fails_the_experiments_as_published() {
    for (name, error, diverged) in [
        ("experiment1", 121.92, false),
        ("experiment2", 163.12, true),
    ] {
        let report = committed(name, "--method basic");
        let basic = of_method(&report, "basic");
        close(number(basic, "force_rendering_error_percent"), error);
        assert_eq!(basic["diverged"], diverged, "{name}");
    }
}

#[test]
fn a_method_that_diverges_is_marked_in_the_table() {
    let scene = experiment("experiment2");
    let table = Folder::new().succeed(&format!("simulate {} --method basic,hfcr", scene.display()));
    // Below the table, which is too narrow for it.
    assert!(table.contains("\n basic: diverged\n"), "{table}");
    assert_eq!(table.matches("diverged").count(), 1, "{table}");
}

#[test]
fn without_a_method_the_scene_s_is_run() {
    let folder = with_scene();
    let report = folder.json("simulate scene.toml");
    assert_eq!(report["methods"].as_array().unwrap().len(), 1);
    of_method(&report, "hfcr");
    let text = folder.read("scene.toml");
    folder.write(
        "scene.toml",
        text.replace("method = \"hfcr\"", "method = \"popc-ref\""),
    );
    of_method(&folder.json("simulate scene.toml"), "popc-ref");
}

#[test]
fn every_tick_of_every_method_is_the_library_s_bit_for_bit() {
    let folder = with_scene();
    folder.succeed("simulate scene.toml --method all --out run.csv");
    let run = folder.run_file("run.csv");
    let scene = ContactFile::parse("scene.toml", &folder.read("scene.toml"))
        .unwrap()
        .scene;
    let bench = Bench::new(&scene).unwrap();
    let columns = [
        "t_s",
        "device_position_m",
        "object_position_m",
        "held_force_on_object_n",
        "leak_held_j",
        "port_work_j",
    ]
    .map(|name| run.numbers(name).unwrap());
    let mut row = 0;
    for method in MethodName::ALL {
        for tick in bench.run(method).unwrap().ticks {
            let expected = [
                tick.time,
                tick.device_position,
                tick.output.object_position,
                tick.held_force_on_object,
                tick.ledger.held_leak.accumulated,
                tick.ledger.port_work,
            ];
            let found = columns.each_ref().map(|column| column[row]);
            assert_eq!(found, expected, "{method}, row {row}");
            row += 1;
        }
    }
    assert_eq!(row, run.len());
}

#[test]
fn all_methods_stand_in_table_json_run_file_and_figure() {
    let folder = with_scene();
    let arguments = "simulate scene.toml --method all";
    let table = folder.succeed(&format!("{arguments} --out run.csv --plot run.svg"));
    let report = folder.json(arguments);
    let figure = folder.read("run.svg");
    let run = folder.run_file("run.csv");
    let in_run = run.texts("method").unwrap();
    assert_eq!(report["methods"].as_array().unwrap().len(), METHODS.len());
    for method in METHODS {
        assert!(
            table.contains(&format!("\n {method} ")),
            "{method} in\n{table}"
        );
        assert!(
            figure.contains(&format!(">{method}: FRE ")),
            "{method} in the figure"
        );
        assert_eq!(
            in_run.iter().filter(|&&name| name == method).count(),
            76,
            "{method}"
        );
        let entry = of_method(&report, method);
        assert!(
            number(entry, "energy_drift_percent").is_finite(),
            "{method}"
        );
        // The renderer's energy ledger against the integral of the simulation.
        let recorded = number(entry, "port_work_j") - number(entry, "bench_port_work_j");
        assert!(recorded.abs() < 1e-12, "{method}: {recorded}");
    }
}

#[test]
fn a_flag_does_what_an_edit_of_the_scene_does() {
    let edits: [(&str, &str, &str); 15] = [
        (
            "--stiffness 250",
            "stiffness_n_per_m = 100",
            "stiffness_n_per_m = 250",
        ),
        (
            "--mass 0.4",
            "mass_kg = 0.1\nposition_m",
            "mass_kg = 0.4\nposition_m",
        ),
        (
            "--mass inf",
            "axes = [\"x\"]\nmass_kg = 0.1\nposition_m = [0.1, 0.0, 0.0]\nforce_n = [-0.981, 0.0, 0.0] # weight",
            "fixed = true\nposition_m = [0.1, 0.0, 0.0]",
        ),
        ("--force -0.5", "force_n = [-0.981,", "force_n = [-0.5,"),
        (
            "--object-position 0.05",
            "position_m = [0.1,",
            "position_m = [0.05,",
        ),
        (
            "--object-velocity -0.3",
            "position_m = [0.1,",
            "velocity_m_per_s = [-0.3, 0.0, 0.0]\nposition_m = [0.1,",
        ),
        ("--period 0.004", "period_s = 0.01", "period_s = 0.004"),
        (
            "--delay-periods 2",
            "period_s = 0.01",
            "period_s = 0.01\ndelay_samples = 2",
        ),
        (
            "--device-mass 0.3",
            "mass_kg = 0.1\n\n[device.hand]",
            "mass_kg = 0.3\n\n[device.hand]",
        ),
        (
            "--encoder-quantum 0.003",
            "mass_kg = 0.1\n\n[device.hand]",
            "mass_kg = 0.1\nquantum_m = 0.003\n\n[device.hand]",
        ),
        ("--method seh", "method = \"hfcr\"", "method = \"seh\""),
        (
            "--damping 0.7",
            "\ndamping_n_s_per_m = 0.01\n",
            "\ndamping_n_s_per_m = 0.7\n",
        ),
        (
            "--damping auto",
            "\ndamping_n_s_per_m = 0.01\n",
            "\ndamping_n_s_per_m = \"auto\"\n",
        ),
        (
            "--force-limit 2",
            "method = \"hfcr\"",
            "method = \"hfcr\"\nforce_limit_n = 2",
        ),
        (
            "--slew-limit 90",
            "method = \"hfcr\"",
            "method = \"hfcr\"\nslew_limit_n_per_s = 90",
        ),
    ];
    let folder = Folder::new();
    let text = experiment_text("fig2").replace("collisions = 3", "duration_s = 0.75");
    folder.write("plain.toml", &text);
    let unchanged = folder.json("simulate plain.toml");
    for (flags, old, new) in edits {
        assert_eq!(text.matches(old).count(), 1, "{old}");
        folder.write("edited.toml", text.replace(old, new));
        let mut by_flag = folder.json(&format!("simulate plain.toml {flags}"));
        let mut by_edit = folder.json("simulate edited.toml");
        // A title that contains a value of the file is followed by the value of the flag.
        let title = by_flag["title"].take().as_str().unwrap().to_owned();
        let own = by_edit["title"].take().as_str().unwrap().to_owned();
        if flags.starts_with("--stiffness") {
            assert_eq!(title, format!("{own} (changed: stiffness 250 N/m)"));
        }
        assert!(title.starts_with(&own), "{title}");
        assert_eq!(by_flag, by_edit, "{flags}");
        assert_ne!(
            by_flag["methods"], unchanged["methods"],
            "{flags} changes nothing"
        );
    }
}

#[test]
fn a_mirrored_scene_gives_mirrored_forces() {
    let folder = with_scene();
    let text = folder.read("scene.toml");
    let mirrored = text
        .replace("position_m = [0.1,", "position_m = [-0.1,")
        .replace("normal = [-1.0,", "normal = [1.0,")
        .replace("force_n = [-0.981,", "force_n = [+0.981,")
        .replace("force_n = [0.981,", "force_n = [-0.981,");
    folder.write("mirrored.toml", mirrored);
    folder.succeed("simulate scene.toml --method all --out plus.csv");
    folder.succeed("simulate mirrored.toml --method all --out minus.csv");
    let forces = |name: &str| folder.run_file(name).numbers("force_on_device_n").unwrap();
    let negated: Vec<f64> = forces("minus.csv").iter().map(|force| -force).collect();
    assert_eq!(forces("plus.csv"), negated);
    assert!(negated.iter().any(|&force| force < -1.0));
}

#[test]
fn an_encoder_is_seen_by_the_renderer_only() {
    let folder = with_scene();
    folder.succeed("simulate scene.toml --encoder-quantum 0.002 --out run.csv");
    let run = folder.run_file("run.csv");
    let seen = run.numbers("device_position_m").unwrap();
    let truth = run.numbers("true_device_position_m").unwrap();
    for (seen, truth) in seen.iter().zip(&truth) {
        let counts = seen / 0.002;
        assert!((counts - counts.round()).abs() < 1e-9, "{seen} is no count");
        assert!((seen - truth).abs() <= 0.002, "{seen} for {truth}");
    }
    assert_ne!(seen, truth);
}

#[test]
fn table_of_single_method_lists_each_collision() {
    let table = with_scene().succeed("simulate scene.toml");
    let rest = table
        .split("Collision by collision")
        .nth(1)
        .expect("a second table");
    let rows: Vec<_> = rest
        .lines()
        .filter(|line| line.starts_with("  0."))
        .collect();
    assert_eq!(rows.len(), 3, "{table}");
    assert!(
        rows[0].starts_with("  0.1010") && rows[2].starts_with("  0.6648"),
        "{table}"
    );
}

#[test]
fn long_lists_of_collisions_are_cut_with_a_word() {
    let folder = with_scene();
    for (collisions, cut) in [(12, false), (20, true)] {
        let text = experiment_text("fig2");
        let text = text.replace("collisions = 3", &format!("collisions = {collisions}"));
        folder.write("scene.toml", text);
        let table = folder.succeed("simulate scene.toml");
        assert_eq!(table.contains("The first 12 of"), cut, "{table}");
    }
}

#[test]
fn an_imperfect_loop_by_flags_is_that_of_the_scene_file() {
    let folder = with_scene();
    let text = folder.read("scene.toml").replace(
        "period_s = 0.01\n",
        "period_s = 0.01\ndelay_fraction = 0.25\njitter_s = 0.002\ndrop_probability = 0.1\nseed = 7\n",
    );
    folder.write("imperfect.toml", text);
    let flags = "--delay-fraction 0.25 --jitter 0.002 --drop 0.1 --seed 7";
    let by_flags = folder.json(&format!("simulate scene.toml {flags}"));
    let by_file = folder.json("simulate imperfect.toml");
    assert_eq!(by_flags, by_file);
    assert_eq!(
        by_file["timing"],
        serde_json::json!({
            "delay_fraction": 0.25, "jitter_s": 0.002, "drop_probability": 0.1, "seed": 7
        })
    );
    let samples = number(&by_file, "samples");
    assert!(samples > 55.0 && samples < 76.0, "{samples}");
    // The delay of a flag replaces the whole delay, and a delay in seconds has no additional fraction of a period.
    let whole = folder.json("simulate imperfect.toml --delay-periods 1");
    assert_eq!(whole["delay_samples"], 1);
    assert_eq!(whole["timing"].get("delay_fraction"), None);
    folder.fail(
        "simulate scene.toml --delay-periods 0.5 --delay-fraction 0.25",
        2,
        &[
            "--delay-fraction 0.25",
            "the delay is 0.005 s",
            "--delay-periods 1",
        ],
    );
    let perfect = folder.json("simulate scene.toml");
    assert_eq!(perfect.get("timing"), None);
    assert_eq!(number(&perfect, "samples"), 76.0);
    // The run file contains the time at which each command reached the motor, and the text names the imperfection.
    let model = folder.succeed("simulate imperfect.toml --out run.csv --plot run.svg");
    assert!(
        model.contains("jitter up to 2.00 ms, 10 % of samples dropped"),
        "{model}"
    );
    let run = folder.run_file("run.csv");
    let (sampled, from) = (
        run.numbers("t_s").unwrap(),
        run.numbers("command_from_s").unwrap(),
    );
    for (sampled, from) in sampled.iter().zip(&from[..from.len() - 1]) {
        assert!((from - sampled - 0.0025).abs() < 1e-12 || from.is_nan());
    }
    assert!(from.last().unwrap().is_nan());
    for (flag, said) in [
        (
            "--jitter 0.005",
            "--jitter is 0.005 s, but must be from 0 s to below half",
        ),
        (
            "--drop 1",
            "--drop is 1, but must be a probability from 0 to below 1",
        ),
        (
            "--delay-fraction -0.1",
            "--delay-fraction is -0.1 periods, but must be",
        ),
    ] {
        let answer = folder.palpate(&format!("simulate scene.toml {flag}"));
        assert_eq!(answer.code, 2, "{flag}");
        assert!(answer.stderr.contains(said), "{flag}: {}", answer.stderr);
    }
}

#[test]
fn random_parts_state_their_seed_and_several_seeds_give_their_range() {
    let folder = with_scene();
    let random = "simulate scene.toml --method basic,coupled --jitter 0.002 --drop 0.1";
    // E of coupled, its leak, and the zero-order-hold bound, with each of three seeds.
    let mut values = [const { Vec::new() }; 3];
    for seed in 3..6 {
        let report = folder.json(&format!("{random} --seed {seed}"));
        assert_eq!(report["seed"], seed);
        assert!(report.get("seeds").is_none());
        let coupled = of_method(&report, "coupled");
        assert!(coupled.get("over_seeds").is_none());
        values[0].push(number(coupled, "mean_force_error_percent"));
        values[1].push(number(coupled, "leak_held_j"));
        values[2].push(number(&report, "hold_bound_percent"));
    }
    let report = folder.json(&format!("{random} --seed 3 --seeds 3"));
    assert_eq!((&report["seed"], &report["seeds"]), (&3.into(), &3.into()));
    let coupled = of_method(&report, "coupled");
    // Single values are those of the first seed.
    assert_eq!(number(coupled, "mean_force_error_percent"), values[0][0]);
    let over = &coupled["over_seeds"];
    for (values, spread) in values.iter_mut().zip([
        &over["mean_force_error_percent"],
        &over["leak_held_j"],
        &report["hold_bound_over_seeds"],
    ]) {
        values.sort_by(f64::total_cmp);
        assert_eq!(
            ["least", "median", "largest"].map(|name| number(spread, name)),
            values[..]
        );
        assert!(values[0] < values[2], "{values:?}");
    }
    let text = folder.succeed(&format!("{random} --seed 3 --seeds 3"));
    let shown = format!(
        "{:.1} ({:.1} to {:.1})",
        values[0][1], values[0][0], values[0][2]
    );
    assert!(
        text.contains("seeds 3 to 5") && text.contains(&shown),
        "{shown}\n{text}"
    );
    let one = folder.succeed(&format!("{random} --seed 3"));
    assert!(
        one.contains("one draw of seed 3") && one.contains("--seeds 20"),
        "{one}"
    );
    // Sensor noise is random in a perfect loop too.
    let text = folder
        .read("scene.toml")
        .replace("[[device]]\n", "[[device]]\nnoise_m = 1e-6\n");
    folder.write("noisy.toml", text);
    let noisy = folder.json("simulate noisy.toml --seeds 2");
    assert_eq!((&noisy["seed"], &noisy["seeds"]), (&0.into(), &2.into()));
    for command in [
        "compare noisy.toml",
        "paper heights noisy.toml --method basic",
    ] {
        let text = folder.succeed(command);
        assert!(text.contains("one draw of seed 0"), "{command}: {text}");
    }
    // Without randomness there are no repetitions.
    let perfect = folder.json("simulate scene.toml");
    assert!(perfect.get("seed").is_none());
    folder.fail(
        "simulate scene.toml --seeds 2",
        2,
        &["--seeds 2: nothing is random"],
    );
    folder.fail("simulate noisy.toml --seeds 2 --out run.csv", 2, &["--out"]);
    folder.write("world.toml", experiment_text("worlds/paddle"));
    folder.fail(
        "simulate world.toml --seeds 2",
        2,
        &["nothing is random in this scene"],
    );
}

#[test]
fn a_recorded_intention_is_looked_for_beside_the_scene() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("deep")).unwrap();
    let text = experiment_text("fig2").replace(
        "[device.hand]\n",
        "[device.hand]\nstiffness_n_per_m = 50\ndamping_n_s_per_m = 1\n\
         rest_file = \"hand.csv\"\nrelease_s = 0.5\n",
    );
    folder.write("deep/scene.toml", text);
    let answer = folder.palpate("simulate deep/scene.toml");
    assert_eq!(answer.code, 3);
    assert!(
        answer.stderr.contains("hand.csv cannot be read: "),
        "{}",
        answer.stderr
    );
    folder.write("deep/hand.csv", "t_s,position_m\n0,0\n0.1,0.005\n0.8,0\n");
    let report = folder.json("simulate deep/scene.toml --method basic,hfcr");
    assert!(number(of_method(&report, "hfcr"), "mean_force_error_percent") < 60.0);
    folder.succeed("simulate deep/scene.toml --out run.csv");
    assert!(
        folder
            .read("run.csv")
            .contains("\"\"hand_release_s\"\":\"\"0.5\"\"")
    );
}
