//! `palpate info`, `convert` and `replay`: what becomes of a recording.

use crate::common::{Folder, number, of_method, parse};
use crate::recordings::{append, loop_of, record, row, write};
use palpate_record::recording::{LoopCount, Receipt, RecordingWriter};
use palpate_rt::{Note, Noted};
use palpate_scene::method::MethodName;

#[test]
fn info_says_what_is_in_a_recording() {
    let folder = Folder::new();
    let run = record(&folder.path("tap.mcap"));
    let text = folder.succeed("info tap.mcap");
    let ticks = format!("\n{} ticks over ", run.ticks.len());
    for words in [
        "tap.mcap, recorded by palpate 0.1.0\ncomplete, nothing lost\n",
        &ticks,
        " Hz\n",
        "\n  latest sample: 0.0600 ms\n",
        "\n  longest tick: 0.0200 ms\n",
        "\n  contact: ",
        "\n2 events\n  end: 1\n  safety: 1\n",
        "\n1 text in the receipt\n  scene: ",
    ] {
        assert!(text.contains(words), "no {words:?} in:\n{text}");
    }
    // What the device did not say is not said.
    assert!(!text.contains("answer of the device"), "{text}");
    let report = folder.json("info tap.mcap");
    assert_eq!(report["format"], "palpate info 1");
    assert_eq!(
        (&report["whole"], &report["ticks_lost"]),
        (&true.into(), &0.into())
    );
    assert_eq!(report["complete"], true);
    assert_eq!(report["ticks_made"], report["ticks"]);
    let size = std::fs::metadata(folder.path("tap.mcap")).unwrap().len();
    assert_eq!(report["bytes"], size);
    assert_eq!(number(&report, "ticks"), run.ticks.len() as f64);
    let rate = number(&report, "rate_hz");
    let expected = (run.ticks.len() - 1) as f64 / (run.last().time - run.ticks[0].time);
    assert_eq!(rate, expected);
    let longest = run
        .ticks
        .windows(2)
        .map(|pair| pair[1].time - pair[0].time)
        .fold(0.0, f64::max);
    assert_eq!(number(&report, "longest_period_s"), longest);
    let touching = run
        .ticks
        .iter()
        .filter(|tick| tick.output.penetration > 0.0)
        .count();
    assert_eq!(report["flags"]["contact"], touching);
}

/// A loop of late ticks misses several deadlines at once, and what held forces have created passes again.
#[test]
fn info_counts_missed_deadlines_and_says_the_most_energy_that_was_created() {
    let folder = Folder::new();
    let (text, run) = loop_of("experiment1", MethodName::Hfcr);
    let receipt = Receipt::new("0.1.0").with("scene", &text);
    let mut writer = RecordingWriter::create(&folder.path("late.mcap"), &receipt).unwrap();
    for (at, created_energy) in [0.0, 0.001, 0.0042, 0.002].into_iter().enumerate() {
        let mut late = row(&run, at);
        late.tick.created_energy = created_energy;
        append(&mut writer, &late);
    }
    for missed in [3, 1, 20] {
        let noted = Noted {
            sequence: 3,
            time: run.ticks[3].time,
            device: None,
            note: Note::MissedDeadlines(missed),
        };
        writer.event(&noted.event()).unwrap();
    }
    writer.finish().unwrap();
    let report = folder.json("info late.mcap");
    assert_eq!(report["events"]["missed-deadline"], 3);
    assert_eq!(report["missed_deadlines"], 24);
    assert_eq!(report["most_created_energy_j"], 0.0042);
    let text = folder.succeed("info late.mcap");
    for words in [
        "\n  missed deadlines: 24\n",
        "\n  held forces created: at most 4.20 mJ, if the loop is as modelled\n",
    ] {
        assert!(text.contains(words), "no {words:?} in:\n{text}");
    }
}

#[test]
fn the_scene_of_a_recording_can_be_had_again() {
    let folder = Folder::new();
    record(&folder.path("tap.mcap"));
    let scene = folder.succeed("info tap.mcap --text scene");
    assert_eq!(scene, crate::common::experiment_text("experiment1"));
    folder.fail(
        "info tap.mcap --text device",
        2,
        &["--text", "called device; it has scene"],
    );
}

#[test]
fn what_is_lost_is_said_and_has_an_exit_code() {
    let folder = Folder::new();
    let (text, run) = loop_of("experiment1", MethodName::Hfcr);
    let last = run.ticks.len() - 1;
    let keeps = |at| at != 0 && !(20..25).contains(&at) && at != last;
    write(&folder.path("tap.mcap"), &text, &run, keeps);
    let lost = format!(
        "7 of {} ticks lost: 1 before the first, 5 after tick 19, 1 after tick {}",
        run.ticks.len(),
        last - 1
    );
    let answer = folder.palpate("info tap.mcap");
    assert_eq!((answer.code, answer.stderr.as_str()), (4, ""));
    assert!(answer.stdout.contains(&lost), "{}", answer.stdout);
    let report = folder.palpate("info tap.mcap --json");
    let report = parse(&report.stdout);
    assert_eq!(report["gaps"][1]["after_tick"], 19);
    assert_eq!(report["gaps"][1]["ticks"], 5);
    for command in ["convert tap.mcap", "replay tap.mcap --method basic"] {
        let answer = folder.palpate(command);
        assert_eq!(answer.code, 4, "{command}: {answer:?}");
        assert_eq!(
            answer.stderr,
            format!("warning: tap.mcap: {lost}\n"),
            "{command}"
        );
        assert!(!answer.stdout.is_empty(), "{command} does what it can");
    }
    // A replay says so, too.
    let report = folder.palpate("replay tap.mcap --method basic --json");
    assert_eq!(parse(&report.stdout)["recording"]["ticks_lost"], 7);
}

/// The last ticks are lost, and so is the event of the end: only the count of the loop says so.
#[test]
fn a_tail_that_is_lost_is_said_and_has_an_exit_code() {
    let folder = Folder::new();
    let (text, run) = loop_of("experiment1", MethodName::Hfcr);
    let receipt = Receipt::new("0.1.0").with("scene", &text);
    let write = |name: &str, count: Option<LoopCount>| {
        let mut writer = RecordingWriter::create(&folder.path(name), &receipt).unwrap();
        for at in 0..30 {
            append(&mut writer, &row(&run, at));
        }
        if let Some(count) = count {
            writer.count(&count).unwrap();
        }
        writer.finish().unwrap();
    };
    let count = LoopCount {
        ticks: 36,
        events: 2,
        motors_off: 9,
        time: None,
        ending: None,
    };
    write("late.mcap", Some(count));
    let answer = folder.palpate("info late.mcap");
    assert_eq!(answer.code, 4, "{answer:?}");
    for words in [
        "6 of 36 ticks lost: 6 after tick 29\n",
        "2 of 2 events lost\n",
        "safety had the motors off for 9 of 36 ticks (25.0 %)\n",
    ] {
        assert!(answer.stdout.contains(words), "{words}: {}", answer.stdout);
    }
    assert!(!answer.stdout.contains("complete"), "{}", answer.stdout);
    let report = parse(&folder.palpate("info late.mcap --json").stdout);
    let said = ["ticks", "ticks_made", "ticks_lost", "events_lost"].map(|key| number(&report, key));
    assert_eq!(said, [30.0, 36.0, 6.0, 2.0]);
    assert_eq!(
        (&report["complete"], &report["finished"]),
        (&false.into(), &true.into())
    );
    assert_eq!(folder.palpate("convert late.mcap").code, 4);
    let table = folder.run_file("late.csv");
    let said = |key: &str| {
        let found = table.receipt().iter().find(|(name, _)| name == key);
        found.unwrap().1.clone()
    };
    assert_eq!(
        (said("complete"), said("ticks_lost")),
        ("false".into(), "6".into())
    );
    // One that an older version has made: nobody knows.
    write("old.mcap", None);
    let text = folder.succeed("info old.mcap");
    assert!(
        text.contains("nothing is known to be lost; it does not say how many ticks the loop made"),
        "{text}"
    );
    assert!(!text.contains("complete"), "{text}");
    let report = folder.json("info old.mcap");
    assert_eq!(
        (&report["complete"], &report["whole"]),
        (&false.into(), &true.into())
    );
    assert!(report["ticks_made"].is_null());
}

#[test]
fn a_recording_that_was_cut_off_is_read_as_far_as_it_goes() {
    let folder = Folder::new();
    let (text, run) = loop_of("experiment1", MethodName::Hfcr);
    let receipt = Receipt::new("0.1.0").with("scene", &text);
    let mut writer = RecordingWriter::create(&folder.path("tap.mcap"), &receipt).unwrap();
    for at in 0..30 {
        append(&mut writer, &row(&run, at));
    }
    drop(writer);
    folder.fail(
        "info tap.mcap",
        1,
        &[
            "tap.mcap: cannot be read: ",
            "there is an unfinished one: read tap.mcap.part",
        ],
    );
    let answer = folder.palpate("convert tap.mcap.part");
    assert_eq!(answer.code, 4);
    assert_eq!(answer.stdout, "wrote tap.csv: 30 ticks\n");
    let readable = format!(
        "30 ticks can be read, up to tick 29 at {:.3} s",
        run.ticks[29].time
    );
    assert_eq!(
        answer.stderr,
        format!(
            "warning: tap.mcap.part: not complete: never finished: it ends with its last flush; \
             {readable}\n"
        )
    );
    let info = folder.palpate("info tap.mcap.part");
    assert_eq!(info.code, 4);
    assert!(info.stdout.contains(&readable), "{}", info.stdout);
    assert_eq!(folder.run_file("tap.csv").len(), 30);
    assert_eq!(folder.palpate("replay tap.mcap.part --method hfcr").code, 4);
}

#[test]
fn a_recording_becomes_a_table_and_its_events_another() {
    let folder = Folder::new();
    let run = record(&folder.path("tap.mcap"));
    let count = run.ticks.len();
    assert_eq!(
        folder.succeed("convert tap.mcap"),
        format!("wrote tap.csv: {count} ticks\nwrote tap-events.csv: 2 events\n")
    );
    let table = folder.run_file("tap.csv");
    let forces = table.numbers("force_on_object_n").unwrap();
    for (force, tick) in forces.iter().zip(&run.ticks) {
        assert_eq!(force.to_bits(), tick.output.force_on_object.to_bits());
    }
    assert_eq!(table.len(), count);
    assert_eq!(
        folder.run_file("tap-events.csv").texts("kind").unwrap(),
        ["safety", "end"]
    );
    folder.succeed("convert tap.mcap --to csv --out other.csv");
    assert_eq!(folder.read("other.csv"), folder.read("tap.csv"));
    let answer = folder.palpate("convert tap.mcap --out -");
    assert_eq!((answer.code, answer.stdout), (0, folder.read("tap.csv")));
    assert!(
        answer.stderr.contains("2 events left out"),
        "{}",
        answer.stderr
    );
}

#[test]
fn parquet_is_a_feature() {
    let folder = Folder::new();
    record(&folder.path("tap.mcap"));
    let arguments = "convert tap.mcap --to parquet";
    if cfg!(feature = "parquet") {
        folder.succeed(arguments);
        let bytes = std::fs::read(folder.path("tap.parquet")).unwrap();
        assert_eq!(
            (&bytes[..4], &bytes[bytes.len() - 4..]),
            (&b"PAR1"[..], &b"PAR1"[..])
        );
    } else {
        folder.fail(arguments, 2, &["--to parquet", "--features parquet"]);
    }
}

#[test]
fn a_replay_by_the_recorded_method_gives_the_recorded_forces() {
    let folder = Folder::new();
    let run = record(&folder.path("tap.mcap"));
    let arguments = "replay tap.mcap --method hfcr,basic --out replay.csv --plot replay.svg";
    let report = folder.json(arguments);
    assert_eq!(report["replay"]["kind"], "motion");
    assert_eq!(report["recording"]["recorded_method"], "hfcr");
    assert_eq!(report["title"], "Motion replay: tap.mcap");
    let table = folder.run_file("replay.csv");
    let forces = table.numbers("force_on_object_n").unwrap();
    assert_eq!(forces.len(), 2 * run.ticks.len());
    for (force, tick) in forces.iter().zip(&run.ticks) {
        assert!(
            (force - tick.output.force_on_object).abs() < 1e-9,
            "{force} N"
        );
    }
    let said = |key: &str| {
        table
            .receipt()
            .iter()
            .find(|(name, _)| name == key)
            .unwrap()
            .1
            .clone()
    };
    assert_eq!(
        (said("replay"), said("recording")),
        ("motion".into(), "tap.mcap".into())
    );
    let peak = number(&report["recording"], "recorded_peak_force_n");
    let replayed = number(of_method(&report, "hfcr"), "peak_force_n");
    assert!(
        (peak / replayed - 1.0).abs() < 1e-9,
        "{peak} and {replayed}"
    );
    let leak = |method| number(of_method(&report, method), "absolute_leak_held_j");
    assert!(leak("basic") > 5.0 * leak("hfcr"));
    let figure = folder.read("replay.svg");
    for words in ["Motion replay: tap.mcap", "whatever the force", "recorded"] {
        assert!(figure.contains(words), "no {words} in the figure");
    }
    let text = folder.succeed("replay tap.mcap --method basic");
    assert!(
        text.contains("motion replay: the device goes where it went, whatever the force"),
        "{text}"
    );
}

#[test]
fn flags_change_the_scene_of_a_recording() {
    let folder = Folder::new();
    record(&folder.path("tap.mcap"));
    let report =
        folder.json("replay tap.mcap --method virtual-damper --damping 1.5 --stiffness 50");
    assert_eq!(report["stiffness_n_per_m"], 50.0);
    let damper = of_method(&report, "virtual-damper");
    assert_eq!(damper["parameters"]["damping_n_s_per_m"], 1.5);
    folder.fail("replay tap.mcap --stiffness -1", 2, &["--stiffness is -1"]);
}

#[test]
fn the_object_starts_where_it_was_at_the_first_tick() {
    let folder = Folder::new();
    let (text, run) = loop_of("experiment1", MethodName::Hfcr);
    write(&folder.path("tap.mcap"), &text, &run, |at| at >= 30);
    let first = |arguments: &str| {
        let answer = folder.palpate(&format!(
            "replay tap.mcap --method hfcr --out r.csv --overwrite {arguments}"
        ));
        assert_eq!(answer.code, 4, "{answer:?}");
        folder
            .run_file("r.csv")
            .numbers("object_position_m")
            .unwrap()[0]
    };
    assert_eq!(first(""), run.ticks[30].output.object_position);
    assert_eq!(first("--object-position 0.3"), 0.3);
}

#[test]
fn ticks_without_a_position_are_passed_over_and_counted() {
    let folder = Folder::new();
    let (text, run) = loop_of("experiment1", MethodName::Hfcr);
    let receipt = Receipt::new("0.1.0").with("scene", &text);
    let mut writer = RecordingWriter::create(&folder.path("tap.mcap"), &receipt).unwrap();
    for at in 0..run.ticks.len() {
        let mut row = row(&run, at);
        if at % 10 == 3 {
            row.contact.device_position = f64::NAN;
        }
        append(&mut writer, &row);
    }
    writer.finish().unwrap();
    let without = (0..run.ticks.len()).filter(|at| at % 10 == 3).count();
    let report = folder.json("replay tap.mcap --method hfcr");
    assert_eq!(report["recording"]["ticks_without_position"], without);
    assert_eq!(report["samples"], run.ticks.len() - without);
}

#[test]
fn what_cannot_be_read_or_replayed_is_refused() {
    let folder = Folder::new();
    folder.write("other.mcap", "t_s,position_m\n0,0\n");
    for command in ["info", "convert", "replay"] {
        folder.fail(
            &format!("{command} other.mcap"),
            3,
            &["other.mcap: not an MCAP file, so no recording"],
        );
        folder.fail(
            &format!("{command} none.mcap"),
            1,
            &["none.mcap: cannot be read"],
        );
    }
    let begin = |name: &str, receipt: &Receipt| {
        RecordingWriter::create(&folder.path(name), receipt).unwrap()
    };
    begin("empty.mcap", &Receipt::new("0.1.0"))
        .finish()
        .unwrap();
    folder.fail(
        "convert empty.mcap",
        3,
        &["empty.mcap: the recording has no tick"],
    );
    folder.fail("replay empty.mcap", 3, &["no text called scene"]);
    let wrong = Receipt::new("0.1.0").with("scene", "scene_format = 1\ntitle = 3\n");
    begin("wrong.mcap", &wrong).finish().unwrap();
    folder.fail("replay wrong.mcap", 3, &["wrong.mcap (scene):2:9"]);
    let scene = crate::common::experiment_text("experiment1");
    let no_tick = Receipt::new("0.1.0").with("scene", &scene);
    begin("no_tick.mcap", &no_tick).finish().unwrap();
    folder.fail(
        "replay no_tick.mcap",
        3,
        &["no_tick.mcap: a path needs at least two samples"],
    );
    folder.fail(
        "replay no_tick.mcap --replay hand",
        3,
        &["no_tick.mcap: a path needs at least two samples"],
    );
    record(&folder.path("tap.mcap"));
    folder.fail(
        "convert tap.mcap --out tap.mcap",
        2,
        &["overwrite the input tap.mcap"],
    );
    folder.fail(
        "replay tap.mcap --out tap.mcap",
        2,
        &["--out would overwrite the input"],
    );
}
