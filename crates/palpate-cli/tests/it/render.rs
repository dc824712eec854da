//! `palpate render`: recorded motion in, forces and a report out.

use crate::common::{Folder, METHODS, default_params, number, of_method, taps, trace_text};
use palpate_core::{AnyRenderer, Contact, LoopParams, ObjectState, Renderer, Sample, State};

const FLAGS: &str = "--stiffness 400 --mass 0.1 --period 0.01 --force -0.981 --object-position 0";
const STIFFNESS: f64 = 400.0;
const PERIOD: f64 = 0.01;

fn with_taps() -> Folder {
    let folder = Folder::new();
    folder.write("tap.csv", trace_text(&taps(0.001, 1.5)));
    folder
}

#[test]
fn every_tick_of_every_method_is_the_library_s_bit_for_bit() {
    let folder = with_taps();
    folder.succeed(&format!(
        "render tap.csv {FLAGS} --method all --out run.csv"
    ));
    let run = folder.run_file("run.csv");
    let methods = run.texts("method").unwrap();
    let column = |name: &str| run.numbers(name).unwrap();
    let columns = [
        "t_s",
        "device_position_m",
        "object_position_m",
        "object_velocity_m_per_s",
        "force_on_object_n",
        "leak_original_j",
        "leak_held_j",
        "force_on_device_n",
        "penetration_m",
    ]
    .map(column);
    let decimated: Vec<f64> = taps(0.001, 1.5)
        .iter()
        .step_by(10)
        .map(|&(_, x)| x)
        .collect();

    let mut row = 0;
    for method in METHODS {
        let renderer: AnyRenderer<f64> = Renderer::new(
            Contact::object(STIFFNESS, 0.1),
            LoopParams::new(PERIOD),
            // Forces do not move a recorded device.
            default_params(method, STIFFNESS, PERIOD, f64::INFINITY),
        )
        .unwrap();
        let mut state: State<f64, _> = renderer.start(ObjectState::at_rest(0.0)).unwrap();
        let mut pressed = 0;
        for (i, &position) in decimated.iter().enumerate() {
            let sample = Sample::at(position).with_virtual_force(-0.981);
            let output = renderer.step(&mut state, sample);
            let expected = [
                i as f64 * PERIOD,
                position,
                output.object_position,
                output.object_velocity,
                output.force_on_object,
                state.ledger().original_leak.accumulated,
                state.ledger().held_leak.accumulated,
                output.force_on_device,
                output.penetration,
            ];
            let found = columns.each_ref().map(|column| column[row]);
            assert_eq!(found, expected, "{method}, sample {i}");
            assert_eq!(methods[row], method);
            pressed += usize::from(output.force_on_object > 0.0);
            row += 1;
        }
        assert!(
            pressed > 10,
            "{method} was in contact for {pressed} samples"
        );
    }
    assert_eq!(row, run.len());
}

/// A column has the virtual force of each sample. A constant one is --force, and the ideal has it too.
#[test]
fn each_sample_may_have_a_virtual_force() {
    let folder = with_taps();
    let with_force = |force: &dyn Fn(usize) -> f64| {
        let mut text = "t_s,position_m,virtual_force_n\n".to_owned();
        for (i, (time, position)) in taps(0.001, 1.5).into_iter().enumerate() {
            text += &format!("{time:?},{position:?},{:?}\n", force(i));
        }
        text
    };
    folder.write("constant.csv", with_force(&|_| -0.981));
    let flags = FLAGS.replace("--force -0.981", "--force 0");
    let methods =
        |command: &str| folder.json(&format!("{command} --method coupled,hfcr"))["methods"].clone();
    let constant = methods(&format!("render tap.csv {FLAGS}"));
    assert_eq!(methods(&format!("render constant.csv {flags}")), constant);
    // 0.2 N on 0.1 kg for 10 ms: 0.1 mm, far from the device.
    let pushed = with_force(&|i| if i < 10 { 0.2 } else { 0.0 });
    folder.write("pushed.csv", pushed);
    let far = flags.replace("--object-position 0", "--object-position 0.5");
    folder.succeed(&format!(
        "render pushed.csv {far} --method hfcr --out run.csv"
    ));
    let run = folder.run_file("run.csv");
    let object = run.numbers("object_position_m").unwrap();
    for (found, expected) in object.iter().zip([0.5, 0.5001, 0.5003]) {
        assert!((found - expected).abs() < 1e-12, "{found} {expected}");
    }
    folder.fail(
        &format!("render constant.csv {flags} --replay hand --device-mass 0.2"),
        3,
        &["virtual_force_n", "--replay motion"],
    );
    folder.write(
        "infinite.csv",
        "t_s,position_m,virtual_force_n\n0,0,0\n0.01,0,inf\n0.02,0,0\n",
    );
    folder.fail(&format!("render infinite.csv {flags}"), 3, &["inf"]);
}

#[test]
fn the_leaks_are_those_of_the_intervals_before_the_sample() {
    // Into a wall at 10 mm per sample, a force held from the previous sample is K d too small at the end of the
    // interval, so each interval leaks K d^2 / 2, and the first sample leaks nothing.
    let folder = Folder::new();
    folder.write(
        "ramp.csv",
        "t_s,position_m\n0,0\n0.01,0.01\n0.02,0.02\n0.03,0.03\n",
    );
    folder.succeed(
        "render ramp.csv --stiffness 400 --mass inf --period 0.01 --method basic --out run.csv",
    );
    let run = folder.run_file("run.csv");
    let (original, held) = (run.numbers("leak_original_j"), run.numbers("leak_held_j"));
    for (i, (original, held)) in original.unwrap().iter().zip(held.unwrap()).enumerate() {
        let expected = i as f64 * 0.5 * 400.0 * 0.01 * 0.01;
        assert!(
            (original - expected).abs() < 1e-15,
            "{i}: {original} for {expected}"
        );
        assert!(
            (held - expected).abs() < 1e-15,
            "{i}: {held} for {expected}"
        );
    }
}

#[test]
fn all_methods_stand_in_table_json_run_file_and_figure() {
    let folder = with_taps();
    let arguments = format!("render tap.csv {FLAGS} --method all");
    let table = folder.succeed(&format!("{arguments} --out run.csv --plot run.svg"));
    let report = folder.json(&arguments);
    let figure = folder.read("run.svg");
    let run = folder.run_file("run.csv");
    let mut in_run = run.texts("method").unwrap();
    in_run.dedup();
    assert_eq!(in_run, METHODS);
    let names: Vec<_> = report["methods"].as_array().unwrap().iter().collect();
    assert_eq!(
        names
            .iter()
            .map(|entry| &entry["method"])
            .collect::<Vec<_>>(),
        METHODS
    );
    for method in METHODS {
        let rows = table
            .lines()
            .filter(|line| line.split_whitespace().next() == Some(method));
        assert_eq!(rows.count(), 1, "{method} in\n{table}");
        assert!(
            figure.contains(&format!(">{method}: FRE ")),
            "{method} in the figure"
        );
    }
    assert!(table.contains("wrote run.csv\nwrote run.svg\n"), "{table}");
    // The same motion for all, but not the same force.
    let errors: std::collections::BTreeSet<String> = METHODS
        .map(|method| of_method(&report, method)["leak_held_j"].to_string())
        .into();
    // Without leak dissipation hfcr equals hfcr-mod-st.
    assert_eq!(errors.len(), 13, "{errors:?}");
}

#[test]
fn a_list_of_methods_is_run_in_its_own_order() {
    let report = with_taps().json(&format!("render tap.csv {FLAGS} --method hfcr,basic"));
    let methods = report["methods"].as_array().unwrap();
    assert_eq!(methods.len(), 2);
    assert_eq!(
        (&methods[0]["method"], &methods[1]["method"]),
        (&"hfcr".into(), &"basic".into())
    );
}

#[test]
fn a_period_that_is_a_multiple_of_the_recording_s_takes_its_samples_exactly() {
    let folder = Folder::new();
    let samples = taps(0.0005, 1.0);
    folder.write("tap.csv", trace_text(&samples));
    for (period, every) in [("0.0005", 1), ("0.0015", 3), ("0.02", 40)] {
        folder.succeed(&format!(
            "render tap.csv --stiffness 400 --mass 0.1 --period {period} --out run.csv --overwrite"
        ));
        let positions = folder
            .run_file("run.csv")
            .numbers("device_position_m")
            .unwrap();
        let expected: Vec<f64> = samples.iter().step_by(every).map(|&(_, x)| x).collect();
        assert_eq!(positions, expected, "--period {period}");
    }
}

#[test]
fn another_period_is_interpolated_on_straight_lines() {
    let folder = Folder::new();
    folder.write(
        "bend.csv",
        "t_s,position_m\n1,0\n1.01,0.002\n1.02,0\n1.03,-0.006\n",
    );
    folder.succeed(
        "render bend.csv --stiffness 400 --mass 0.1 --period 0.0075 --out run.csv --overwrite",
    );
    let run = folder.run_file("run.csv");
    let expected = [
        (1.0, 0.0),
        (1.0075, 0.0015),
        (1.015, 0.001),
        (1.0225, -0.0015),
        (1.03, -0.006),
    ];
    assert_eq!(run.len(), expected.len());
    let (times, positions) = (run.numbers("t_s"), run.numbers("device_position_m"));
    for ((t, x), expected) in times.unwrap().iter().zip(positions.unwrap()).zip(expected) {
        assert!(
            (t - expected.0).abs() < 1e-12 && (x - expected.1).abs() < 1e-12,
            "{t}, {x}"
        );
    }
}

#[test]
fn the_report_has_its_fields_with_finite_numbers() {
    let report = with_taps().json(&format!("render tap.csv {FLAGS} --method all"));
    assert_eq!(report["format"], "palpate report 1");
    assert_eq!(report["stiffness_n_per_m"], STIFFNESS);
    assert_eq!(report["period_s"], PERIOD);
    assert_eq!(report["window_periods"], 150);
    assert_eq!(report["delay_samples"], 0);
    assert!(report["device_mass_kg"].is_null() && report["kappa"].is_null());
    assert!((number(&report, "object_kappa") - 0.4).abs() < 1e-12);
    assert!(number(&report, "hold_bound_percent") > 0.0);
    assert!(report["files"].is_null(), "nothing was written");
    for method in METHODS {
        let entry = of_method(&report, method);
        for field in [
            "mean_force_error_percent",
            "force_rendering_error_percent",
            "error_over_bound",
            "peak_force_n",
            "strongest_pull_n",
            "leak_original_j",
            "leak_held_j",
            "absolute_leak_original_j",
            "absolute_leak_held_j",
            "stored_energy_j",
            "port_work_j",
            "virtual_force_work_j",
            "outside_work_j",
        ] {
            assert!(number(entry, field).is_finite(), "{method}: {field}");
        }
        assert_eq!(
            (&entry["faults"], &entry["limited"]),
            (&0.into(), &0.into())
        );
        let collisions = entry["collisions"].as_array().unwrap();
        assert_eq!(
            collisions.len() as u64,
            report["ideal_collisions"].as_u64().unwrap()
        );
        for open_loop in ["energy_drift_percent", "diverged", "bench_port_work_j"] {
            assert!(
                entry.get(open_loop).is_none(),
                "a recording has no {open_loop}"
            );
        }
    }
}

#[test]
fn the_report_s_leaks_are_those_of_the_last_tick() {
    let folder = with_taps();
    let report = folder.json(&format!(
        "render tap.csv {FLAGS} --method seh --out run.csv"
    ));
    let run = folder.run_file("run.csv");
    for (field, column) in [
        ("leak_held_j", "leak_held_j"),
        ("stored_energy_j", "stored_energy_j"),
    ] {
        let last = *run.numbers(column).unwrap().last().unwrap();
        // The JSON reader of these tests may be off by a bit.
        let reported = number(of_method(&report, "seh"), field);
        assert!(
            (reported - last).abs() <= 1e-15 * last.abs(),
            "{field}: {reported}, {last}"
        );
        assert_ne!(last, 0.0, "{field}");
    }
    assert_eq!(report["files"], serde_json::json!(["run.csv"]));
}

#[test]
fn run_file_metadata_records_parameters_and_version() {
    let folder = with_taps();
    folder.succeed(&format!(
        "render tap.csv {FLAGS} --method hfcr --damping 0.25 --delay-periods 1 --out run.csv"
    ));
    let run = folder.run_file("run.csv");
    let entry = |key: &str| {
        let found = run.metadata().iter().find(|(name, _)| name == key);
        found
            .map(|(_, value)| value.clone())
            .unwrap_or_else(|| panic!("no {key}"))
    };
    assert_eq!(entry("stiffness_n_per_m"), "400");
    assert_eq!(entry("object_mass_kg"), "0.1");
    assert_eq!(entry("virtual_force_n"), "-0.981");
    assert_eq!(entry("delay_samples"), "1");
    assert_eq!(entry("trace"), "tap.csv");
    assert_eq!(entry("palpate_version"), env!("CARGO_PKG_VERSION"));
    assert_eq!(entry("hfcr.damping_n_s_per_m"), "0.25");
    assert!(
        folder
            .read("run.csv")
            .starts_with("t_s,device_position_m,object_position_m,")
    );
}

#[test]
fn a_mirrored_contact_gives_mirrored_forces() {
    let folder = with_taps();
    let mirrored: Vec<_> = taps(0.001, 1.5).iter().map(|&(t, x)| (t, -x)).collect();
    folder.write("mirrored.csv", trace_text(&mirrored));
    let common = "--stiffness 400 --mass 0.1 --period 0.01 --method all";
    let plus = "--force -0.981 --object-position 0.002 --object-velocity -0.1";
    let minus = "--side negative --force 0.981 --object-position -0.002 --object-velocity 0.1";
    folder.succeed(&format!("render tap.csv {common} {plus} --out plus.csv"));
    folder.succeed(&format!(
        "render mirrored.csv {common} {minus} --out minus.csv"
    ));
    let (plus, minus) = (folder.run_file("plus.csv"), folder.run_file("minus.csv"));
    for name in [
        "force_on_device_n",
        "force_on_object_n",
        "object_position_m",
    ] {
        let negated: Vec<f64> = minus.numbers(name).unwrap().iter().map(|x| -x).collect();
        assert_eq!(plus.numbers(name).unwrap(), negated, "{name}");
    }
    for name in ["penetration_m", "leak_held_j"] {
        assert_eq!(
            plus.numbers(name).unwrap(),
            minus.numbers(name).unwrap(),
            "{name}"
        );
    }
    assert!(
        plus.numbers("force_on_device_n")
            .unwrap()
            .iter()
            .any(|&force| force < -1.0)
    );
}

#[test]
fn a_delay_holds_each_force_so_many_samples_later() {
    let folder = with_taps();
    folder.succeed(&format!(
        "render tap.csv {FLAGS} --method basic --delay-periods 2 --out run.csv"
    ));
    let run = folder.run_file("run.csv");
    let asked = run.numbers("force_on_object_n").unwrap();
    let held = run.numbers("held_force_on_object_n").unwrap();
    assert_eq!(held[..2], [0.0, 0.0]);
    assert_eq!(held[2..], asked[..asked.len() - 2]);
    assert_ne!(held, asked);
}

#[test]
fn limits_act_and_are_counted() {
    let folder = with_taps();
    let arguments = format!("render tap.csv {FLAGS} --force-limit 1.5");
    let report = folder.json(&format!("{arguments} --out run.csv"));
    let coupled = of_method(&report, "coupled");
    assert_eq!(number(coupled, "peak_force_n"), 1.5);
    let limited = coupled["limited"].as_u64().unwrap();
    let run = folder.run_file("run.csv");
    let marked = run
        .texts("limited")
        .unwrap()
        .iter()
        .filter(|&&text| text == "force")
        .count();
    assert!(
        limited > 0 && limited == marked as u64,
        "{limited}, {marked}"
    );
    assert!(
        folder
            .succeed(&arguments)
            .contains(&format!("{limited} forces limited"))
    );
}

/// The default method corrects with a small force after contact has ended. Each collision is still compared with its
/// own ideal, and a method with another number of collisions is reported.
#[test]
fn default_method_collisions_are_matched_and_other_counts_reported() {
    let folder = Folder::new();
    folder.write("long.csv", trace_text(&taps(0.001, 4.0)));
    let render = "render long.csv --stiffness 400 --mass 0.1 --period 0.01 --force -0.981";
    let report = folder.json(render);
    let coupled = of_method(&report, "coupled");
    let collisions = coupled["collisions"].as_array().unwrap();
    assert!(collisions.len() > 20, "{} collisions", collisions.len());
    for collision in collisions {
        let error = number(collision, "impulse_error_percent");
        assert!(error.abs() < 2.0, "{collision}");
    }
    let surplus = number(coupled, "rendered_collisions") - collisions.len() as f64;
    assert!((0.0..=1.0).contains(&surplus), "{surplus}");
    assert!(
        !folder
            .succeed(render)
            .contains("compares different collisions")
    );
    let basic = folder.succeed(&format!("{render} --method basic"));
    assert!(
        basic.contains("collisions rendered for")
            && basic.contains("compares different collisions"),
        "{basic}"
    );
}
