//! The `--json` output of every command conforms to its schema in `docs/schema`.

use std::collections::BTreeSet;

use crate::common::{Folder, experiment_text, parse, schema, taps, trace_text};
use serde_json::{Value, json};

/// A folder with a scene, its recording and a trace of a hand.
fn folder() -> Folder {
    let folder = Folder::new();
    for name in ["fig2", "wall", "fig4"] {
        folder.write(&format!("{name}.toml"), experiment_text(name));
    }
    folder.write("world.toml", experiment_text("worlds/paddle"));
    folder.write("taps.csv", trace_text(&taps(1e-3, 0.5)));
    folder
}

const SETUP: &str = "--stiffness 400 --mass 0.1 --period 0.01";

#[test]
fn every_report_is_as_its_schema_says() {
    let folder = folder();
    let hand = "--replay hand --device-mass 0.25";
    let mut met = BTreeSet::new();
    for arguments in [
        "run fig2.toml --record rec.mcap --duration 0.2 --fast",
        "run wall.toml --duration 0.05",
        "info rec.mcap",
        "simulate fig2.toml --method all",
        "simulate wall.toml --jitter 0.0002 --drop 0.01 --delay-periods 1",
        "simulate fig4.toml --method virtual-damper",
        "simulate fig2.toml --jitter 0.0002 --seeds 3",
        "simulate world.toml --method all",
        &format!("render taps.csv {SETUP} --method basic,popc-ref,coupled --device-mass 0.2"),
        &format!("render taps.csv {SETUP} --method hfcr {hand}"),
        "replay rec.mcap --method hfcr",
        "replay rec.mcap --method hfcr --replay hand",
        "compare fig2.toml wall.toml",
        "tune fig2.toml --method hfcr --from 0.01 --to 0.02 --steps 2 --plot tune.svg",
        "paper heights fig2.toml --method basic,hfcr",
        "sweep fig2.toml --over damping --values 0.01,100 --method hfcr",
        "sweep fig2.toml --over damping --values 0.01 --method hfcr --heights",
        "suite --plants 2 --method basic,coupled",
        "suite --set desk --plants 1 --method coupled",
        "suite --set worlds --plants 1 --seeds 2",
        "suite --set worlds-free --plants 2",
        "compare world.toml",
        "tune world.toml --method god-object --plot tune-world.svg",
        "map --cells 2 --method basic,coupled",
        "map --cells 2 --method basic --shard 1/2 --out part.csv",
        "report rec.mcap --method basic",
        "advise --device-mass 0.25 --period 0.01 --method hfcr",
        "advise --device-mass 0.25 --period 0.01 --stiffness 400 --mass inf --method hfcr,coupled",
        "paper figure fig1",
        "paper figure fig2",
        "devices",
        "calibrate --device simulated --fast --seconds 2",
        "doctor --priority 0",
        "doctor --bench --rate 200,1000 --duration 0.05 --priority 0",
        "demo",
    ] {
        let answer = folder.palpate(&format!("{arguments} --json"));
        assert_eq!(answer.code, 0, "palpate {arguments}: {answer:?}");
        met.insert(schema::check(&parse(&answer.stdout)));
    }
    let pipe = folder.palpate_reading("0\n0.001\n", &format!("pipe {SETUP} --method basic --json"));
    met.insert(schema::check(&parse(pipe.stderr.lines().last().unwrap())));
    let pipe = folder.palpate_reading("0,0,0\n", "pipe world.toml --json");
    met.insert(schema::check(&parse(pipe.stderr.lines().last().unwrap())));
    // These take long or need a device; tests/sweep_and_claims.rs and tests/two_diy.rs check them.
    met.extend(["claims", "devices-check"].map(String::from));
    let all = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/schema")).unwrap();
    let all: BTreeSet<String> = all
        .map(|entry| {
            let path = entry.unwrap().path();
            path.file_stem().unwrap().to_string_lossy().into_owned()
        })
        .collect();
    assert_eq!(met, all);
}

#[test]
fn a_report_that_is_not_as_its_schema_says_is_noticed() {
    let folder = folder();
    let report = folder.json("tune fig2.toml --method hfcr --from 0.01 --to 0.02 --steps 2");
    let text = include_str!("../../../../docs/schema/tune.json");
    let rules: Value = serde_json::from_str(text).unwrap();
    let fits = |report: &Value| schema::fits(report, &rules, &rules, "");
    assert_eq!(fits(&report), Ok(()));
    for (pointer, value) in [
        ("/format", json!("palpate tune 2")),
        ("/start_heights", json!(21.5)),
        ("/start_heights", json!(-1)),
        ("/title", Value::Null),
        ("/curve", json!({})),
        ("/curve/0/value_n_s_per_m", json!("0.01")),
        ("/best", json!({ "value_n_s_per_m": 0.01 })),
    ] {
        let mut wrong = report.clone();
        *wrong.pointer_mut(pointer).unwrap() = value.clone();
        assert!(fits(&wrong).is_err(), "{pointer}: {value}");
    }
}
