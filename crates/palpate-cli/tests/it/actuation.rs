//! Delay, lag and gain of a loop: by flags, and from a calibrated device file.

#![allow(clippy::print_stdout)] // tests show what they measured

use crate::common::{Answer, Folder, experiment_text, number, of_method, parse, taps, trace_text};
use serde_json::Value;

const DEVICE: &str = "\
calibration_format = 1
period_s = 0.01
device_mass_kg = 0.1
delay_s = 0.005
lag_s = 0.002
gain = 0.9
sensor_quantum_m = 0

[standard_deviation]
delay_s = 0.0001
";

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("scene.toml", experiment_text("fig2"));
    folder.write("device.toml", DEVICE);
    folder.write("tap.csv", trace_text(&taps(0.001, 1.5)));
    folder
}

fn error(report: &Value, method: &str) -> f64 {
    number(of_method(report, method), "mean_force_error_percent")
}

/// Checks the words that a command wrote to standard error.
fn model(answer: &Answer, words: &[&str]) {
    assert_eq!(answer.code, 0, "{answer:?}");
    for word in words {
        assert!(answer.stderr.contains(word), "{word}: {answer:?}");
    }
}

const PIPE: &str = "pipe --stiffness 400 --mass 0.1 --period 0.001 --device-mass 0.2 \
                    --object-position 0.005 --soft-start 0 --force-limit inf";

/// Returns the forces of a press of 50 mm/s.
fn piped(folder: &Folder, flags: &str) -> Vec<f64> {
    let lines: String = (0..120)
        .map(|i| format!("{}\n", 5e-5 * f64::from(i)))
        .collect();
    let answer = folder.palpate_reading(&lines, &format!("{PIPE} {flags}"));
    assert_eq!(answer.code, 0, "{flags}: {answer:?}");
    let forces = answer.stdout.lines().map(|line| line.parse().unwrap());
    forces.collect()
}

/// A sensor whose noise exceeds that of its steps has a model value with steps of that noise.
#[test]
fn calibrated_sensor_noise_sets_equivalent_encoder_quantum() {
    let folder = folder();
    let file = "calibration_format = 1\nperiod_s = 0.001\nsensor_quantum_m = 1e-6\n";
    folder.write("steps.toml", file);
    folder.write("noisy.toml", format!("{file}sensor_noise_m = 5e-6\n"));
    let of = |flags: &str| piped(&folder, &format!("--method coupled {flags}"));
    let noisy = of("--device-file noisy.toml");
    assert_ne!(noisy, of("--device-file steps.toml"));
    assert_eq!(noisy, of("--encoder-quantum 0.000017320508075688773"));
}

#[test]
fn a_pipe_commands_what_the_actuator_is_to_get() {
    let folder = folder();
    let plain = piped(&folder, "--method basic");
    let weak = piped(&folder, "--method basic --gain 0.5");
    assert!(plain.iter().any(|force| *force < -0.1), "{plain:?}");
    for (plain, weak) in plain.iter().zip(&weak) {
        assert!((2.0 * plain - weak).abs() <= 1e-12, "{plain} {weak}");
    }
    let at_once = piped(&folder, "");
    assert_eq!(
        piped(&folder, "--delay-periods 0 --lag 0 --gain 1"),
        at_once
    );
    let all = piped(&folder, "--delay-periods 0.5 --lag 0.0003 --gain 0.98");
    for (flags, other) in [
        ("none", &at_once),
        ("delay", &piped(&folder, "--delay-periods 0.5")),
        (
            "delay and lag",
            &piped(&folder, "--delay-periods 0.5 --lag 0.0003"),
        ),
    ] {
        assert_ne!(&all, other, "{flags}");
    }
    assert!(all.iter().all(|force| force.is_finite()));
    // A delayed force has to begin before the device touches.
    let begins = |forces: &[f64]| forces.iter().position(|force| *force < -1e-6);
    assert!(begins(&all) < begins(&at_once), "{all:?} {at_once:?}");
}

#[test]
fn actuator_model_brings_coupled_near_the_hold_bound() {
    let folder = folder();
    let error = |flags: &str| {
        let flags = format!("simulate scene.toml --method coupled {flags}");
        error(&folder.json(&flags), "coupled")
    };
    let actuator = "--delay-periods 0.5 --lag 0.002 --gain 0.9";
    let model = error(actuator);
    for unmodelled in ["--model-delay 0", "--model-lag 0", "--model-gain 1"] {
        let other = error(&format!("{actuator} {unmodelled}"));
        println!("{unmodelled}: E {other:.2} %, told {model:.2} %");
        assert!(
            model < 1.0 && other > 5.0 * model,
            "{unmodelled}: {other} {model}"
        );
    }
    assert_eq!(error("--delay-periods 1.0"), error("--delay-periods 1"));
    // The period is 10 ms.
    assert_eq!(error("--delay 0.01"), error("--delay-periods 1"));
    assert_eq!(error("--delay 0.005"), error("--delay-periods 0.5"));
    let both = "simulate scene.toml --delay 0.01 --delay-periods 1";
    let words = ["--delay", "--delay-periods", "cannot be used with"];
    folder.fail(both, 2, &words);
    let too_long =
        "--delay is 20 s, 2000 periods of 0.01 s, but must be at most 1024 periods, 10.24 s";
    let in_periods = "--delay is in seconds, --delay-periods in periods";
    folder.fail("simulate scene.toml --delay 20", 2, &[too_long, in_periods]);
    let longer = folder.palpate("simulate scene.toml --delay 1").stderr;
    assert!(
        longer.contains("the other 92 of these 100 are unmodelled") && longer.contains(in_periods)
    );
    let pipe = "pipe --stiffness 400 --mass 0.1 --period 0.001 --device-mass 0.1";
    let too_long =
        "--delay is 1 s, 1000 periods of 0.001 s, but must be at most 8 periods, 0.008 s";
    folder.fail(&format!("{pipe} --delay 1"), 2, &[too_long, in_periods]);
    let too_long = "--delay-periods is 0.009 s, 9 periods";
    folder.fail(&format!("{pipe} --delay-periods 9"), 2, &[too_long]);
    let question = "--lag is 1 s; is it in milliseconds? A lag of 1 ms is --lag 0.001";
    let lagging = folder.palpate("simulate scene.toml --lag 1").stderr;
    assert!(lagging.contains(question), "{lagging}");
    let negative = &["--delay is -1 s, but must be finite and not below 0"];
    folder.fail("simulate scene.toml --delay -1", 2, negative);
}

#[test]
fn recording_is_rendered_with_actuator_from_flags() {
    let folder = folder();
    let render = "render tap.csv --stiffness 400 --mass 0.1 --period 0.01 --method basic";
    let error = |flags: &str| error(&folder.json(&format!("{render} {flags}")), "basic");
    let (none, whole) = (error(""), error("--delay-periods 1"));
    let half = error("--delay-periods 0.5");
    assert!(none < half && half < whole, "{none} {half} {whole}");
    // This method compensates the gain, but not a lag.
    assert!((error("--gain 0.7") / none - 1.0).abs() < 1e-9);
    assert!(error("--lag 0.003") > none);
    let shown = folder.palpate(&format!("{render} --delay-periods 0.5"));
    assert!(shown.stdout.contains("delay 0.5 periods"), "{shown:?}");
}

#[test]
fn a_device_file_says_what_flags_would() {
    let folder = folder();
    let by_flags = "--model-delay 0.005 --delay-deviation 0.0001 --model-lag 0.002 --model-gain 0.9 \
                    --model-device-mass 0.1";
    let report = |flags: &str| {
        let answer = folder.palpate(&format!("simulate scene.toml {flags} --json"));
        assert_eq!(answer.code, 0, "{answer:?}");
        parse(&answer.stdout)["methods"].take()
    };
    let by_file = report("--device-file device.toml");
    assert_eq!(by_file, report(by_flags));
    assert_ne!(by_file, report(""));
    let answer = folder.palpate("simulate scene.toml --device-file device.toml --gain 0.8");
    model(
        &answer,
        &[
            "taken from device.toml: device_mass_kg 0.1",
            "delay_s 0.005 ± 0.0001, lag_s 0.002",
            "--gain overrides gain",
        ],
    );
    // Delay and lag of one fit have opposite errors: their sum is more accurate than each.
    let sum = "delay_plus_lag_s = 0.007\n\n[standard_deviation]\ndelay_plus_lag_s = 0.0001\n\
               lag_s = 0.001\n";
    folder.write(
        "sum.toml",
        DEVICE
            .replace("\n[standard_deviation]\n", sum)
            .replace("delay_s = 0.0001", "delay_s = 0.001"),
    );
    assert_eq!(report("--device-file sum.toml"), by_file);
    // The file's mass is enough for `coupled`.
    let pipe = "pipe --stiffness 400 --mass 0.1 --period 0.01 --device-file device.toml";
    let answer = folder.palpate_reading("0\n0.001\n", pipe);
    assert_eq!(answer.code, 0, "{answer:?}");
    let other = pipe.replace("0.01", "0.001");
    let answer = folder.palpate_reading("0\n0.001\n", &other);
    model(
        &answer,
        &["measured at a period of 0.01 s, but this loop has 0.001 s"],
    );
}

#[test]
fn a_flag_stands_in_place_of_the_value_of_a_device_file() {
    let folder = folder();
    let render = "render tap.csv --stiffness 400 --mass 0.1 --period 0.01 --method basic --json";
    let error = |flags: &str| {
        let answer = folder.palpate(&format!("{render} {flags}"));
        assert_eq!(answer.code, 0, "{answer:?}");
        error(&parse(&answer.stdout), "basic")
    };
    let own = "--delay-periods 0.25 --lag 0.001 --gain 0.8";
    let beside = error(&format!("--device-file device.toml {own}"));
    assert_eq!(beside, error(own));
    assert_ne!(beside, error("--device-file device.toml"));
    // Unused values are not checked: by itself that delay would be too long.
    let fast = "pipe --stiffness 400 --mass 0.1 --period 0.0005 --device-file device.toml --delay-periods 1";
    let answer = folder.palpate_reading("0\n", fast);
    assert_eq!(answer.code, 0, "{answer:?}");
}

#[test]
fn invalid_device_file_is_reported_with_position() {
    let folder = folder();
    folder.write(
        "key.toml",
        DEVICE.replace("delay_s = 0.005", "delay_ms = 5"),
    );
    folder.write("value.toml", DEVICE.replace("gain = 0.9", "gain = 0"));
    for (file, code, said) in [
        ("key.toml", 3, "key.toml:4:1: unknown key delay_ms"),
        ("value.toml", 3, "value.toml:6:8: gain is 0, but must be"),
        ("none.toml", 1, "none.toml: "),
    ] {
        for command in [
            "simulate scene.toml",
            "render tap.csv --stiffness 400 --mass 0.1 --period 0.01",
            "pipe --stiffness 400 --mass 0.1 --period 0.01",
        ] {
            folder.fail(&format!("{command} --device-file {file}"), code, &[said]);
        }
    }
    let fast = "pipe --stiffness 400 --mass 0.1 --period 0.0005 --device-file device.toml";
    let said = ["device.toml: the delay is 0.005 s, 10 periods", "at most 8"];
    folder.fail(fast, 3, &said);
}

#[test]
fn what_only_a_simulated_actuator_can_differ_in_is_refused_elsewhere() {
    let folder = folder();
    for (flag, own) in [
        ("--model-delay", "--delay"),
        ("--model-lag", "--lag"),
        ("--model-gain", "--gain"),
    ] {
        for command in ["render tap.csv", "pipe"] {
            let command = format!("{command} --stiffness 400 --mass 0.1 --period 0.01 {flag} 0.5");
            let said = format!("{flag} is for simulate and tune");
            folder.fail(&command, 2, &[&said, own]);
        }
    }
    for (flags, said) in [
        (
            "--model-delay 0.085",
            "--model-delay is 0.085 s, 8.5 periods of 0.01 s, but must be at most 8 periods",
        ),
        ("--model-lag -1", "--model-lag is -1 s, but must be"),
        ("--model-gain 0", "--model-gain is 0, but must be"),
        ("--delay-deviation 9", "9 s, but must be 0 to 8 periods"),
        ("--gain-deviation 9", "but must be from 0 to the gain"),
    ] {
        folder.fail(&format!("simulate scene.toml {flags}"), 2, &[said]);
    }
    let map = "map --cells 2 --delay-deviation-periods 9";
    folder.fail(map, 2, &["is 9 periods, but must be 0 to 8"]);
}

#[test]
fn recording_contains_model_values_and_is_replayed_with_them() {
    let folder = folder();
    let actuator = "--delay-periods 0.5 --delay-deviation 0.0001 --lag 0.002 --gain 0.9";
    folder.succeed(&format!(
        "run scene.toml --record rec.mcap --method coupled --fast --duration 0.7 {actuator}"
    ));
    let info = folder.json("info rec.mcap");
    for (key, value) in [
        ("device_mass_kg", 0.1),
        ("delay_s", 0.005),
        ("delay_deviation_s", 0.0001),
        ("lag_s", 0.002),
        ("lag_deviation_s", 0.0),
        ("gain", 0.9),
        ("gain_deviation", 0.0),
    ] {
        assert!(
            (number(&info["model"], key) - value).abs() < 1e-15,
            "{key}: {info}"
        );
    }
    let shown = folder.succeed("info rec.mcap");
    let line =
        "the renderer's model: device 0.100 kg, delay 5.00 ± 0.100 ms, lag 2.00 ms, gain 0.900\n";
    assert!(shown.contains(line), "{shown}");
    // The same motion, rendered with the model values: as it was recorded, and with a method that ignores them.
    let replayed = |flags: &str| {
        let report = folder.json(&format!("replay rec.mcap --method basic {flags}"));
        (error(&report, "basic"), report["actuator"].clone())
    };
    let (recorded, model) = replayed("");
    assert_eq!(number(&model, "model_lag_s"), 0.002);
    assert_eq!(replayed(actuator).0, recorded);
    assert_ne!(replayed("--delay-periods 0 --lag 0 --gain 1").0, recorded);
    // A perfect loop is reported too.
    folder.succeed("run scene.toml --record perfect.mcap --method coupled --fast --duration 0.1");
    let info = folder.json("info perfect.mcap");
    assert_eq!(
        (
            number(&info["model"], "delay_s"),
            number(&info["model"], "gain")
        ),
        (0.0, 1.0)
    );
}

const FLEXIBLE: &str = "\
calibration_format = 1
period_s = 0.001
device_mass_kg = 0.2
delay_s = 0.0005
lag_s = 0.0002
resonance_hz = 100.0
flexible_mass_fraction = 0.5
";

/// A resonance of 10 Hz allows 4 Hz: 63 N/m with the 0.1 kg of the motor's side and a wall. All times are ten times
/// those of `FLEXIBLE`, so that the bounces of an advice take fewer ticks.
#[test]
fn a_contact_beyond_the_resonance_of_a_device_file_is_warned_of_once_and_not_advised() {
    let folder = folder();
    let slow = FLEXIBLE
        .replace("period_s = 0.001", "period_s = 0.01")
        .replace("delay_s = 0.0005", "delay_s = 0.005")
        .replace("lag_s = 0.0002", "lag_s = 0.002")
        .replace("resonance_hz = 100.0", "resonance_hz = 10.0");
    folder.write("flexible.toml", slow);
    for (stiffness, is_beyond) in [(60, false), (70, true)] {
        let answer = folder.palpate_reading(
            "0\n",
            &format!(
                "pipe --stiffness {stiffness} --mass inf --period 0.01 --device-file flexible.toml"
            ),
        );
        assert_eq!(answer.code, 0, "{answer:?}");
        let warned = answer.stderr.matches("a resonance of 10 Hz").count();
        assert_eq!(warned, usize::from(is_beyond), "{answer:?}");
        assert_eq!(answer.stderr.contains("63.2 N/m"), is_beyond, "{answer:?}");
    }
    let advised = |flags: &str| {
        let asked = "--stiffness 70 --viscous-friction 0.2 --method coupled";
        folder.json(&format!("advise --period 0.01 {flags} {asked}"))
    };
    let rigid = "--device-mass 0.2 --delay-periods 0.5 --lag 0.002";
    assert_eq!(advised(rigid)["verdict"]["answer"], "yes");
    let flexible = advised("--device-file flexible.toml");
    assert_eq!(flexible["verdict"]["answer"], "too-flexible");
    let device = &flexible["device"];
    assert_eq!(number(device, "delay_fraction"), 0.5);
    assert_eq!(number(device, "lag_s"), 0.002);
    assert_eq!(number(device, "mass_kg"), 0.2);
    assert!((number(device, "stiffest_by_resonance_n_per_m") - 63.165).abs() < 0.001);
    folder.fail("advise --period 0.001", 2, &["--device-mass"]);
}

#[test]
fn a_map_takes_fractions_of_delay_and_a_lag() {
    let folder = folder();
    let map = |flags: &str| folder.succeed(&format!("map --cells 2 --method coupled {flags}"));
    assert!(map("--delay-periods 0.5 --out half.csv").contains("0.5"));
    let text = |file: &str| std::fs::read_to_string(folder.path(file)).unwrap();
    assert!(text("half.csv").contains("\"\"delay_samples\"\":\"\"0.5\"\""));
    map("--delay-periods 1.0 --out one.csv");
    map("--delay-periods 1 --lag-periods 0 --out whole.csv");
    assert_eq!(text("one.csv"), text("whole.csv"));
    map("--delay-periods 1 --lag-periods 0.3 --out lag.csv");
    assert!(text("lag.csv").contains("\"\"lag_periods\"\":\"\"0.3\"\""));
    folder.fail(
        "map --lag-periods 101 --out x.csv",
        2,
        &["--lag-periods is 101 periods", "0 to 100"],
    );
    folder.fail(
        "map --delay-periods 1025 --out x.csv",
        2,
        &["a number of periods"],
    );
}

/// Flags of a flexible transmission, in a loop in which `coupled` uses it.
const TRANSMISSION: &str =
    "--resonance 100 --resonance-damping-ratio 0.03 --flexible-mass-fraction 0.5";

fn flexible_folder() -> Folder {
    let folder = folder();
    folder.write("flexible.toml", experiment_text("coupled/flexible"));
    let keys = "resonance_damping_ratio = 0.03\n";
    folder.write("whole.toml", format!("{FLEXIBLE}{keys}"));
    folder.write("part.toml", FLEXIBLE);
    let model = "[model]\nresonance_hz = 100\nresonance_damping_ratio = 0.03\nflexible_mass_fraction = 0.5\n";
    folder.write(
        "model.toml",
        format!("{}\n{model}", experiment_text("coupled/flexible")),
    );
    folder
}

#[test]
fn transmission_flags_match_scene_and_device_file() {
    let folder = flexible_folder();
    let methods = |command: &str| {
        let answer = folder.palpate(&format!("{command} --json"));
        assert_eq!(answer.code, 0, "{command}: {answer:?}");
        parse(&answer.stdout)["methods"].take()
    };
    let simulate = "simulate flexible.toml --method coupled";
    let by_flags = methods(&format!("{simulate} {TRANSMISSION}"));
    assert_eq!(methods("simulate model.toml --method coupled"), by_flags);
    assert_ne!(methods(simulate), by_flags);
    // One flag overrides one key of a scene and of a file.
    let softer = format!("{simulate} {TRANSMISSION}").replace("100", "80");
    assert_eq!(
        methods("simulate model.toml --method coupled --resonance 80"),
        methods(&softer)
    );
    assert_ne!(methods(&softer), by_flags);
    let rest = "--model-delay 0.0005 --model-lag 0.0002 --model-device-mass 0.2";
    assert_eq!(
        methods(&format!(
            "{simulate} --device-file whole.toml --resonance 80"
        )),
        methods(&format!("{softer} {rest}"))
    );
    let answer = folder.palpate(&format!(
        "{simulate} --device-file whole.toml --resonance 80"
    ));
    model(
        &answer,
        &[
            "resonance_damping_ratio 0.03, flexible_mass_fraction 0.5",
            "--resonance overrides resonance_hz",
        ],
    );
    // A flag completes the file.
    let completed = "--device-file part.toml --resonance-damping-ratio 0.03";
    assert_eq!(
        methods(&format!("{simulate} {completed}")),
        methods(&format!("{simulate} --device-file whole.toml"))
    );
}

#[test]
fn a_part_of_a_transmission_is_refused_where_nothing_says_the_rest() {
    let folder = flexible_folder();
    let render = "render tap.csv --stiffness 400 --mass 0.1 --period 0.01";
    let pipe = "pipe --stiffness 400 --mass 0.1 --period 0.01 --device-mass 0.2";
    for command in ["simulate flexible.toml", render, pipe] {
        for (flags, missing) in [
            ("--resonance 100", "--resonance-damping-ratio is missing"),
            (
                "--resonance 100 --resonance-damping-ratio 0.03",
                "--flexible-mass-fraction is missing",
            ),
            ("--flexible-mass-fraction 0.5", "--resonance is missing"),
        ] {
            folder.fail(
                &format!("{command} {flags}"),
                2,
                &[missing, "a flexible transmission needs"],
            );
        }
    }
}

#[test]
fn pipe_uses_transmission_model_and_warns_above_its_stiffness_limit() {
    let folder = flexible_folder();
    let plain = piped(&folder, "");
    assert_ne!(piped(&folder, TRANSMISSION), plain);
    // If a period of the resonance has twenty samples, one mass is rendered, with or without a model of the
    // transmission.
    assert_eq!(piped(&folder, &TRANSMISSION.replace("100", "40")), plain);
    // 40 Hz with the 0.1 kg of the motor's side.
    for (stiffness, is_beyond) in [(6000, false), (7000, true)] {
        let pipe = format!(
            "pipe --stiffness {stiffness} --mass inf --period 0.001 --device-mass 0.2 {TRANSMISSION}"
        );
        let answer = folder.palpate_reading("0\n", &pipe);
        assert_eq!(answer.code, 0, "{answer:?}");
        let warned = answer
            .stderr
            .matches("--resonance is 100 Hz, which allows 6317 N/m")
            .count();
        assert_eq!(warned, usize::from(is_beyond), "{answer:?}");
    }
}

#[test]
fn recording_contains_transmission_model_from_flags() {
    let folder = flexible_folder();
    folder.succeed(&format!(
        "run flexible.toml --record rec.mcap --method coupled --fast --duration 0.2 {TRANSMISSION}"
    ));
    let info = folder.json("info rec.mcap");
    for (key, value) in [
        ("resonance_hz", 100.0),
        ("resonance_damping_ratio", 0.03),
        ("flexible_mass_fraction", 0.5),
    ] {
        assert_eq!(number(&info["model"], key), value, "{info}");
    }
    assert!(folder.succeed("info rec.mcap").contains("100 Hz"));
    let report = folder.json(&format!("replay rec.mcap --method coupled {TRANSMISSION}"));
    assert_eq!(number(&report["actuator"], "model_resonance_hz"), 100.0);
}

#[test]
fn a_resonance_by_flag_bounds_what_is_advised() {
    let folder = folder();
    // As slow as in the test of a device file above.
    let advise = "advise --period 0.01 --device-mass 0.2 --delay-periods 0.5 --stiffness 70 \
                  --viscous-friction 0.2 --method coupled";
    let advised = |flags: &str| folder.json(&format!("{advise} {flags}"));
    let flexible = advised("--resonance 10 --flexible-mass-fraction 0.5");
    assert_eq!(flexible["verdict"]["answer"], "too-flexible");
    let stiffest = number(&flexible["device"], "stiffest_by_resonance_n_per_m");
    assert!((stiffest - 63.165).abs() < 0.001, "{stiffest}");
    assert_eq!(advised("--resonance 30")["verdict"]["answer"], "yes");
    for (flags, said) in [
        ("--resonance 0", "--resonance is 0 Hz"),
        (
            "--resonance 100 --flexible-mass-fraction 1",
            "must be from 0 to below 1",
        ),
        ("--flexible-mass-fraction 0.5", "--resonance is missing"),
    ] {
        folder.fail(&format!("{advise} {flags}"), 2, &[said]);
    }
}

/// A wall pressed by a hand, in a loop with an unmodelled delay of half a period; only its standard deviation is
/// modelled.
const LATE: &str = "\
format = 2
title = \"A pressed wall with an untold delay\"
loop = { period_s = 0.001, delay_s = 0.0005 }
model = { delay_s = 0, delay_deviation_s = 0.0003 }
render = { method = \"coupled\" }
measure = { duration_s = 1 }

[[device]]
name = \"device\"
axes = [\"x\"]
mass_kg = 0.2

[device.hand]
mass_kg = 0.05
stiffness_n_per_m = 300
damping_n_s_per_m = 3
force_n = [2, 0, 0]

[[body]]
name = \"wall\"
fixed = true
position_m = [0.001, 0, 0]
shape = { half_space = { normal = [-1, 0, 0] } }

[[contact]]
between = [\"device\", \"wall\"]
stiffness_n_per_m = 20000
";

#[test]
fn a_lateness_that_was_learned_is_said() {
    let folder = folder();
    folder.write("late.toml", LATE);
    let ran = folder.succeed("run late.toml --record rec.mcap --fast --duration 2.5");
    let last = ran.lines().rfind(|line| line.contains("learned-lateness"));
    let words: Vec<&str> = last.unwrap().split_whitespace().collect();
    let at = words.iter().position(|word| *word == "begin").unwrap();
    let milliseconds: f64 = words[at + 1].parse().unwrap();
    assert_eq!(words[at + 2..at + 6], ["ms", "later", "than", "the"]);
    assert!((milliseconds - 0.5).abs() < 0.1, "{ran}");
    let info = folder.succeed("info rec.mcap");
    assert!(info.contains("learned-lateness: "), "{info}");
    let certain = LATE.replace("delay_deviation_s = 0.0003", "delay_deviation_s = 0");
    folder.write("certain.toml", certain);
    let certain = folder.succeed("run certain.toml --record certain.mcap --fast --duration 2.5");
    assert!(!certain.contains("learned-lateness"), "{certain}");
}
