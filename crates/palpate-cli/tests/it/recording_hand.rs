//! `palpate replay --replay hand`: the hand of a recording, its loop closed again.

use crate::common::{Folder, in_a_line, number, of_method};
use crate::recordings::{append, loop_in, record, row, write};
use palpate_record::recording::{Flags, RecordingMetadata, RecordingWriter, Row};
use palpate_scene::method::MethodName;
use palpate_study::sim::run::Run;

/// A scene and its mirror image, on the device's other side.
fn both_sides() -> [String; 2] {
    let text = crate::common::experiment_text("experiment1");
    let mut mirrored = text.clone();
    for (from, to) in [
        ("position_m = [0.05,", "position_m = [-0.05,"),
        ("normal = [-1.0,", "normal = [1.0,"),
        ("force_n = [-0.981,", "force_n = [0.981,"),
        ("force_n = [1.0,", "force_n = [-1.0,"),
    ] {
        assert_eq!(mirrored.matches(from).count(), 1, "{from}");
        mirrored = mirrored.replace(from, to);
    }
    [text, mirrored]
}

/// Records a run after `change` has edited every row.
fn write_changed(folder: &Folder, text: &str, run: &Run, change: impl Fn(usize, &mut Row)) {
    let metadata = RecordingMetadata::new("0.1.0").with("scene", text);
    let mut writer = RecordingWriter::create(&folder.path("tap.mcap"), &metadata).unwrap();
    for at in 0..run.ticks.len() {
        let mut row = row(run, at);
        change(at, &mut row);
        append(&mut writer, &row);
    }
    writer.finish().unwrap();
}

/// Returns the difference between the run that a replay by hfcr wrote and the recorded one: motion `[m]`, force `[N]`.
fn apart(folder: &Folder, run: &Run) -> (f64, f64) {
    let table = folder.run_file("r.csv");
    let column = |name: &str| table.numbers(name).unwrap();
    let (times, positions) = (column("t_s"), column("device_position_m"));
    let forces = column("force_on_object_n");
    assert_eq!(times.len(), run.ticks.len());
    let mut farthest = (0.0_f64, 0.0_f64);
    for (at, tick) in run.ticks.iter().enumerate() {
        assert!((times[at] - tick.time).abs() < 1e-9);
        let (x, f) = (tick.device_position, tick.output.force_on_object);
        farthest.0 = farthest.0.max((positions[at] - x).abs());
        farthest.1 = farthest.1.max((forces[at] - f).abs());
    }
    farthest
}

#[test]
fn the_recorded_method_gives_motion_and_force_back_on_both_sides() {
    for text in both_sides() {
        let folder = Folder::new();
        let run = loop_in(&text, MethodName::Hfcr);
        write(&folder.path("tap.mcap"), &text, &run, |_| true);
        let arguments = "replay tap.mcap --replay hand";
        let report = folder.json(&format!("{arguments} --out r.csv --plot r.svg"));
        let (moved, pushed) = apart(&folder, &run);
        assert!(moved < 1e-5, "{moved} m");
        assert!(pushed < 1e-3 * run.force.peak_force, "{pushed} N");

        assert_eq!(report["title"], "Hand replay: tap.mcap");
        let replay = &report["replay"];
        assert_eq!(replay["kind"], "hand");
        assert_eq!(replay["force_recorded"], true);
        assert_eq!(number(replay, "moved_mass_kg"), 0.25);
        // A hand that pushes with 1 N.
        assert!((number(replay, "hand_force_n") - 1.0).abs() < 1e-3);
        let deviation = number(replay, "hand_force_deviation_n");
        assert!(deviation > 0.0 && deviation < 0.01, "{deviation}");
        assert_eq!(report["recording"]["recorded_method"], "hfcr");
        assert_eq!(of_method(&report, "hfcr")["diverged"], false);

        let table = folder.run_file("r.csv");
        let said = |key: &str| {
            let entry = table.metadata().iter().find(|(name, _)| name == key);
            entry.unwrap_or_else(|| panic!("no {key}")).1.clone()
        };
        assert_eq!(said("replay"), "hand");
        assert_eq!(said("recording"), "tap.mcap");
        assert_eq!(said("hand_force_deviation_n"), deviation.to_string());
        let figure = folder.read("r.svg");
        for words in [
            "Hand replay: tap.mcap, hand force",
            "known to ±",
            "recorded",
        ] {
            assert!(figure.contains(words), "no {words:?} in the figure");
        }
        let text = folder.succeed(arguments);
        for words in [
            "Hand replay: tap.mcap\nrecorded by hfcr in ",
            "hand replay (recorded force): the hand's force on 0.25 kg",
            "1 sigma",
        ] {
            assert!(text.contains(words), "no {words:?} in:\n{text}");
        }
    }
}

#[test]
fn another_method_moves_the_device_elsewhere() {
    let folder = Folder::new();
    record(&folder.path("tap.mcap"));
    let departure = |arguments: &str| {
        let arguments = format!("replay tap.mcap --replay hand --method basic {arguments}");
        let report = folder.json(&arguments);
        assert_eq!(of_method(&report, "basic")["method"], "basic");
        report["replay"]["largest_departure_m"][0].as_f64().unwrap()
    };
    let free = departure("");
    assert!(free > 1e-3, "{free}");
    let held = departure("--hand-stiffness 500 --hand-damping 10");
    assert!(held < 0.5 * free, "{held} of {free}");
}

#[test]
fn what_was_lost_is_bridged_and_said() {
    let folder = Folder::new();
    let text = &both_sides()[0];
    let run = loop_in(text, MethodName::Hfcr);
    write(&folder.path("tap.mcap"), text, &run, |at| {
        at % 20 != 11 && !(5..8).contains(&at)
    });
    let answer = folder.palpate("replay tap.mcap --replay hand --json --out r.csv");
    assert_eq!(answer.code, 4, "{answer:?}");
    assert!(answer.stderr.contains("ticks lost"), "{}", answer.stderr);
    let report = crate::common::parse(&answer.stdout);
    let lost = (0..run.ticks.len()).filter(|at| at % 20 == 11 || (5..8).contains(at));
    let lost = lost.count();
    assert_eq!(report["recording"]["ticks_lost"], lost);
    assert_eq!(report["replay"]["bridged_samples"], lost);
    // The loop sampled there all the same.
    assert_eq!(report["samples"], run.ticks.len());
    let words = folder.palpate("replay tap.mcap --replay hand").stdout;
    let said = format!("{lost} samples without a position bridged");
    assert!(
        in_a_line(&words).contains(&said),
        "no {said:?} in:\n{words}"
    );
}

#[test]
fn a_device_that_did_not_answer_was_not_where_it_was_before() {
    let folder = Folder::new();
    let text = &both_sides()[0];
    let run = loop_in(text, MethodName::Hfcr);
    let is_missing = |at: usize| at % 10 == 3;
    // A loop repeats its last sample.
    write_changed(&folder, text, &run, |at, row| {
        if is_missing(at) {
            let before = &run.ticks[at - 1];
            row.tick.time = before.time;
            row.contact.device_position = before.device_position;
            row.tick.flags = row.tick.flags.with(Flags::DEVICE_FAULT, true);
        }
    });
    let missing = (0..run.ticks.len()).filter(|at| is_missing(*at)).count();
    let report = folder.json("replay tap.mcap --method hfcr");
    assert_eq!(report["recording"]["ticks_without_position"], missing);
    assert_eq!(report["samples"], run.ticks.len() - missing);
    let report = folder.json("replay tap.mcap --replay hand");
    assert_eq!(report["replay"]["bridged_samples"], missing);
    assert_eq!(report["samples"], run.ticks.len());
    // A lost sample with its time is bridged by the motion under the force that was sent; so is a glitch that the
    // renderer rejected.
    write_again(&folder, text, &run, |at, row| {
        if at % 20 == 3 {
            row.contact.device_position = f64::NAN;
        } else if is_missing(at) {
            row.contact.device_position = 1.0;
            row.tick.flags = row.tick.flags.with(Flags::FAULT, true);
        }
    });
    let report = folder.json("replay tap.mcap --replay hand --out r.csv");
    assert_eq!(report["replay"]["bridged_samples"], missing);
    let (moved, pushed) = apart(&folder, &run);
    assert!(moved < 1e-5, "{moved} m");
    assert!(pushed < 1e-3 * run.force.peak_force, "{pushed} N");
}

fn write_again(folder: &Folder, text: &str, run: &Run, change: impl Fn(usize, &mut Row)) {
    std::fs::remove_file(folder.path("tap.mcap")).unwrap();
    write_changed(folder, text, run, change);
}

#[test]
fn what_was_sent_acts_after_the_delay_of_the_recorded_loop() {
    let folder = Folder::new();
    let text = both_sides()[0].replace("period_s = 0.02", "period_s = 0.005\ndelay_samples = 2");
    let scene = palpate_scene::ContactFile::parse("scene", &text)
        .unwrap()
        .scene;
    let bench = palpate_study::sim::closed_loop::Bench::new(&scene).unwrap();
    let run = bench.run(MethodName::Hfcr).unwrap();
    write(&folder.path("tap.mcap"), &text, &run, |_| true);
    folder.succeed("replay tap.mcap --replay hand --out r.csv");
    let (moved, pushed) = apart(&folder, &run);
    assert!(moved < 1e-5, "{moved} m");
    assert!(pushed < 1e-3 * run.force.peak_force, "{pushed} N");
    // Another delay gives another loop of the same hand.
    let force = |arguments: &str| {
        let report = folder.json(&format!("replay tap.mcap --replay hand {arguments}"));
        let departure = report["replay"]["largest_departure_m"][0].as_f64().unwrap();
        (number(&report["replay"], "hand_force_n"), departure)
    };
    let ((as_was, near), (faster, far)) = (force(""), force("--delay-periods 0"));
    assert_eq!(as_was, faster);
    assert!(far > 10.0 * near, "{far} and {near}");
    // A fraction is in time: nearly two periods are nearly unchanged, and half of the rest half as far.
    let (nearly, between) = (
        force("--delay-periods 1.999").1,
        force("--delay-periods 1").1,
    );
    let half = force("--delay-periods 1.5").1;
    assert!(nearly < between / 10.0, "{nearly} and {between}");
    assert!(
        (0.3..0.7).contains(&(half / between)),
        "{half} and {between}"
    );
}

#[test]
fn the_device_has_the_mass_of_its_scene_or_of_a_flag() {
    let folder = Folder::new();
    let model = "[model]\ndevice_mass_kg = 0.4\n\n[render]\n";
    let text = both_sides()[0].replace("[render]\n", model);
    let run = loop_in(&text, MethodName::Coupled);
    write(&folder.path("tap.mcap"), &text, &run, |_| true);
    let masses = |arguments: &str| {
        let arguments = format!("replay tap.mcap --replay hand --method coupled {arguments}");
        let report = folder.json(&arguments);
        let parameters = &of_method(&report, "coupled")["parameters"];
        [
            number(&report["replay"], "moved_mass_kg"),
            number(parameters, "device_mass_kg"),
        ]
    };
    // The model value of the renderer does not affect the true mass.
    assert_eq!(masses(""), [0.25, 0.4]);
    assert_eq!(masses("--device-mass 0.3"), [0.3, 0.4]);
    assert_eq!(masses("--model-device-mass 0.5"), [0.25, 0.5]);
    folder.fail(
        "replay tap.mcap --replay hand --device-mass 0",
        2,
        &["--device-mass is 0"],
    );
}

#[test]
fn what_shows_no_hand_is_refused() {
    let folder = Folder::new();
    let text = &both_sides()[0];
    let run = loop_in(text, MethodName::Hfcr);
    write(&folder.path("tap.mcap"), text, &run, |at| {
        !(8..30).contains(&at)
    });
    folder.fail(
        "replay tap.mcap --replay hand",
        3,
        &[
            "tap.mcap: no position between tick 7 at ",
            " s and tick 30 at ",
            "across at most 0.4 s: pass a longer --largest-gap",
            "--replay motion",
        ],
    );
    let answer = folder.palpate("replay tap.mcap --replay hand --largest-gap 1");
    assert_eq!(answer.code, 4, "{answer:?}");
    write_again(&folder, text, &run, |_, row| {
        row.contact.force_on_device = f64::NAN
    });
    folder.fail(
        "replay tap.mcap --replay hand",
        3,
        &["tap.mcap: no tick contains the sent force"],
    );
    write_again(&folder, text, &run, |at, row| {
        if at > 6 {
            row.contact.device_position = f64::NAN;
        }
    });
    folder.fail(
        "replay tap.mcap --replay hand",
        3,
        &["tap.mcap: the force of a hand needs at least 8 samples with a position, not 7"],
    );
    write_again(&folder, text, &run, |_, _| {});
    for flag in [
        "--hand-bandwidth 9",
        "--hand-stiffness 1",
        "--hand-damping 1",
    ] {
        let name = flag.split(' ').next().unwrap();
        folder.fail(
            &format!("replay tap.mcap {flag}"),
            2,
            &[name, "for --replay hand"],
        );
    }
    for (flags, said) in [
        ("--hand-bandwidth 0", "--hand-bandwidth is 0"),
        ("--hand-damping -1", "--hand-damping is -1"),
        ("--stiffness -1", "--stiffness is -1"),
        ("--encoder-quantum -1", "--encoder-quantum is -1"),
        ("--object-position nan", "--object-position is NaN"),
    ] {
        let command = format!("replay tap.mcap --replay hand {flags}");
        folder.fail(&command, 2, &[said]);
    }
    let period = "replay tap.mcap --replay hand --period 9";
    folder.fail(period, 3, &["tap.mcap: ", "less than one period of 9 s"]);
}
