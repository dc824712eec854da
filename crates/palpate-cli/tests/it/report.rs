//! `palpate report`: the page about a device, and the JSON that it is made from.

use crate::common::{Folder, experiment_text, number, parse, schema};
use serde_json::Value;

const DEVICE: &str = "\
calibration_format = 1
date = \"2026-11-20\"
command = \"a <b>person</b>\"

period_s = 0.01
device_mass_kg = 0.25
delay_s = 0.004
delay_plus_lag_s = 0.006
lag_s = 0.002
viscous_friction_n_s_per_m = 1.5
coulomb_friction_n = 0.05
sensor_quantum_m = 1e-5

[standard_deviation]
device_mass_kg = 0.003
delay_plus_lag_s = 0.0015

[found_by]
device_mass_kg = \"weighed & <measured>\"
";

const FIT: &str = r#"{"format":"palpate calibrate 1","samples":4,"excursion_m":0.001,"fit_s":0.1,"found":{},
"motion":{"t_s":[0,0.01,0.02,0.03],"measured_m":[0,0.001,0.002,0.001],"fitted_m":[0,0.0011,0.0019,0.001],
"command_n":[0.5,0.5,-0.5,-0.5]}}"#;

/// A device file, the report of its calibration, and a recording of a loop.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("device.toml", DEVICE).write("fit.json", FIT);
    folder.write("wall.toml", experiment_text("wall"));
    folder
}

fn record(folder: &Folder, name: &str) {
    let answer = folder.palpate(&format!(
        "run wall.toml --record {name} --duration 0.3 --fast --period 0.005"
    ));
    assert_eq!(answer.code, 0, "{answer:?}");
}

/// Checks that the page has no external resources, no scripts, and no duplicate identifiers.
fn assert_self_contained(page: &str) {
    for elsewhere in [
        "http", "//", "src=", "href=", "<script", "<link", "<img", "<iframe", "@import", "onload",
    ] {
        assert!(!page.contains(elsewhere), "{elsewhere}");
    }
    let urls = page.matches("url(").count();
    assert_eq!(urls, page.matches("url(#").count());
    let mut names: Vec<&str> = page
        .split(" id=\"")
        .skip(1)
        .map(|rest| rest.split('"').next().unwrap())
        .collect();
    let count = names.len();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), count, "{names:?}");
    for name in names {
        assert!(page.contains(&format!("#{name}")), "{name}");
    }
}

fn checks<'a>(report: &'a Value, name: &str) -> &'a Value {
    let all = report["checks"].as_array().unwrap();
    all.iter()
        .find(|check| check["name"] == name)
        .unwrap_or_else(|| panic!("{name}: {all:?}"))
}

#[test]
fn a_page_of_a_device_file_says_what_its_json_says() {
    let folder = folder();
    let arguments = "--device-file device.toml --calibration fit.json --method basic";
    let report = folder.json(&format!("report {arguments} --out page.html"));
    assert_eq!(schema::check(&report), "card");
    let page = folder.read("page.html");
    assert_self_contained(&page);
    let found = report["calibration"]["found"].as_array().unwrap();
    assert_eq!(found.len(), 8);
    for text in [
        "period</td><td>10.0\u{a0}ms",
        "device mass</td><td>0.250\u{a0}±\u{a0}0.00300\u{a0}kg",
        "delay</td><td>4.00\u{a0}ms",
        "viscous friction</td><td>1.50\u{a0}N s/m",
        "sensor quantum</td><td>10.0\u{a0}µm",
        "2026-11-20",
        "Weighed &amp; &lt;measured&gt;",
        "a &lt;b&gt;person&lt;/b&gt;",
        "measured - fitted",
        "A simulated contact",
    ] {
        assert!(page.contains(text), "{text}");
    }
    // The map was computed with the values of the file.
    let reach = &report["reach"];
    for (field, value) in [
        ("device_mass_kg", 0.25),
        ("period_s", 0.01),
        ("delay_s", 0.004),
        ("lag_s", 0.002),
        ("delay_deviation_s", 0.0015),
        ("lag_deviation_s", 0.0),
        ("viscous_friction_n_s_per_m", 1.5),
        ("sensor_quantum_m", 1e-5),
    ] {
        assert_eq!(number(reach, field), value, "{field}");
    }
    assert_eq!(reach["assumed"], serde_json::json!([]));
    let wall = number(&reach["methods"][0]["stable_wall_n_per_m"], "value");
    // The bound of Colgate and Schenkel without a delay; with one, the spring is stable up to less.
    assert!(wall > 10.0 && wall < 2.0 * 1.5 / 0.01, "{wall}");
    let in_words = palpate_study::text::digits(1e-3 * wall);
    assert!(page.contains(&format!("<td>{in_words}</td>")), "{in_words}");
    let contact = &report["contact"];
    assert_eq!(contact["is_recorded"], false);
    let squared = |field| number(contact, field).powi(2);
    let sum = squared("mean_force_error_percent") + squared("hold_bound_percent");
    assert!((sum - squared("force_rendering_error_percent")).abs() < 1e-6 * sum.max(1.0));
    // A deviation of 0.15 periods is too large; there is no recording to check.
    assert_eq!(checks(&report, "calibration")["outcome"], "warning");
    assert_eq!(checks(&report, "lost samples")["outcome"], "not-checked");
    assert!(page.contains("calibrate again with a larger --largest-force"));
}

#[test]
fn a_page_of_a_recording_has_its_timing_and_its_contact() {
    let folder = folder();
    record(&folder, "tap.mcap");
    let arguments = "report tap.mcap --method basic --name <i>mine</i>&co";
    let report = folder.json(&format!("{arguments} --out page.html"));
    let page = folder.read("page.html");
    assert_self_contained(&page);
    assert_eq!(report["device"]["name"], "<i>mine</i>&co");
    assert!(page.contains("&lt;i&gt;mine&lt;/i&gt;&amp;co") && !page.contains("<i>"));
    let info = folder.json("info tap.mcap");
    let timing = &report["timing"][0];
    assert_eq!(timing["ticks"], info["ticks"]);
    for (of_card, of_info) in [
        ("period_s", "longest_period_s"),
        ("lateness_s", "largest_lateness_s"),
        ("tick_s", "longest_tick_s"),
    ] {
        assert_eq!(timing[of_card]["largest"], info[of_info], "{of_card}");
        let counts = timing[of_card]["histogram"]["counts"].as_array().unwrap();
        let sum: u64 = counts.iter().map(|count| count.as_u64().unwrap()).sum();
        assert_eq!(timing[of_card]["count"], sum);
    }
    let contact = &report["contact"];
    assert_eq!(contact["is_recorded"], true);
    assert_eq!(contact["method"], "hfcr-mod-st");
    // This method generated the motion, so it reproduces the strongest force that was sent.
    let sent = number(contact, "recorded_peak_force_n");
    assert!((number(contact, "peak_force_n") / sent - 1.0).abs() < 0.05);
    let floor = number(contact, "hold_bound_percent");
    let error = palpate_study::text::percent(number(contact, "mean_force_error_percent"));
    assert!(floor > 0.0 && page.contains(&format!("<td>{error} %</td>")));
    assert_eq!(checks(&report, "lost samples")["outcome"], "in-order");
    assert_eq!(checks(&report, "calibration")["outcome"], "not-checked");
}

#[test]
fn a_session_is_recorded_beside_the_page() {
    let folder = folder();
    let arguments = "report --device simulated --fast --duration 1 --period 0.005 --device-file device.toml \
                     --method basic --out page.html";
    let answer = folder.palpate(&format!("{arguments} --json"));
    assert_eq!(answer.code, 0, "{answer:?}");
    assert!(answer.stderr.contains("session of 1 s"), "{answer:?}");
    let report = parse(&answer.stdout);
    schema::check(&report);
    assert_eq!(report["timing"][0]["recording"], "page.mcap");
    assert_eq!(report["timing"][0]["ticks"], 200);
    assert_eq!(report["contact"]["is_recorded"], true);
    // The loop used the file's model values, at another period.
    let model = folder.json("info page.mcap");
    assert_eq!(model["model"]["delay_s"], 0.004);
    assert_eq!(checks(&report, "modelled delay")["outcome"], "in-order");
    assert_eq!(checks(&report, "calibrated period")["outcome"], "warning");
    // A second recording would replace the first, which is never done.
    let again = folder.palpate(&format!("{arguments} --overwrite"));
    assert_eq!(again.code, 1, "{again:?}");
    assert!(again.stderr.contains("page.mcap exists"), "{again:?}");
}

#[test]
fn what_is_missing_in_a_loop_is_warned_of() {
    let folder = folder();
    let mut text = experiment_text("wall").replace("period_s = 0.001", "period_s = 0.005");
    text = text.replace("hfcr-mod-st", "basic");
    folder.write("slow.toml", text);
    let answer =
        folder.palpate("run slow.toml --record cut.mcap --duration 0.5 --fast --oscillation 1e-9");
    assert!([0, 5].contains(&answer.code), "{answer:?}");
    let bytes = std::fs::read(folder.path("cut.mcap")).unwrap();
    folder.write("torn.mcap", &bytes[..bytes.len() - 100]);
    let answer = folder.palpate("report torn.mcap --json --method basic");
    assert_eq!(answer.code, 4, "{answer:?}");
    let report = parse(&answer.stdout);
    schema::check(&report);
    let lost = checks(&report, "lost samples");
    assert_eq!(lost["outcome"], "warning");
    assert!(
        lost["finding"].as_str().unwrap().contains("not complete"),
        "{lost}"
    );
    assert!(lost["remedy"].as_str().is_some());
    let off = checks(&report, "motors off");
    assert_eq!(off["outcome"], "warning", "{off}");
}

#[test]
fn what_cannot_be_is_refused_before_anything_is_computed() {
    let folder = folder();
    record(&folder, "tap.mcap");
    folder
        .write("mine.html", "mine")
        .write("wrong.toml", "calibration_format = 1\ndelay_s = -1\n")
        .write("wrong.json", "{}");
    for (arguments, code, said) in [
        ("--out page.html", 2, "needs a source"),
        ("tap.mcap", 2, "--out PAGE.html"),
        ("tap.mcap --out mine.html", 1, "--overwrite"),
        ("tap.mcap --out nowhere/page.html", 1, "nowhere"),
        (
            "tap.mcap --out tap.mcap --overwrite",
            2,
            "would overwrite the input",
        ),
        ("none.mcap --json", 1, "none.mcap"),
        ("wall.toml --json", 3, "wall.toml"),
        ("--device-file wrong.toml --json", 3, "delay_s is -1"),
        (
            "--device-file device.toml --calibration wrong.json --json",
            3,
            "not a calibration report",
        ),
        ("tap.mcap --calibration fit.json --json", 2, "--device-file"),
        ("tap.mcap tap.mcap tap.mcap tap.mcap --json", 2, "at most 3"),
        ("tap.mcap --device simulated --json", 2, "not both"),
        (
            "tap.mcap --scene wall.toml --json",
            2,
            "--scene is for a session",
        ),
        (
            "tap.mcap --port /dev/null --json",
            2,
            "--port is for --device haply-2diy",
        ),
        ("--device simulated --fast --json", 2, "--record"),
        ("tap.mcap --stiffness 0 --json", 2, "--stiffness is 0"),
    ] {
        let answer = folder.palpate(&format!("report {arguments}"));
        assert_eq!(answer.code, code, "{arguments}: {answer:?}");
        assert!(answer.stderr.contains(said), "{arguments}: {answer:?}");
        assert_eq!(answer.stdout, "", "{arguments}");
    }
    assert_eq!(folder.read("mine.html"), "mine");
}
