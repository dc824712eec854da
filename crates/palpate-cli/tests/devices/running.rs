//! Loops in real time, from the command line.

#![cfg(unix)]

use std::io::{BufRead, BufReader};
use std::process::Stdio;
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::common::running::{Running, program};
use crate::common::{Folder, experiment_text, in_a_line, number, parse};
use palpate_record::recording::{Entry, Recording, Row};
use serde_json::Value;

fn folder_with_scenes() -> Folder {
    let folder = Folder::new();
    for name in ["fig2", "experiment1", "wall"] {
        folder.write(&format!("{name}.toml"), experiment_text(name));
    }
    folder
}

fn rows(folder: &Folder, name: &str) -> Vec<Row> {
    Recording::open(&folder.path(name))
        .unwrap()
        .rows()
        .unwrap()
        .map(Result::unwrap)
        .collect()
}

/// In a fast run the recorder keeps up: a simulated clock can wait for the disk.
#[test]
fn a_fast_run_loses_nothing_of_its_recording() {
    let folder = folder_with_scenes();
    folder.succeed("run wall.toml --record long.mcap --fast --duration 300 --period 0.001");
    let info = parse(&folder.succeed("info long.mcap --json"));
    assert_eq!(info["ticks"], 300_000);
}

/// A fast run on the simulated device equals a simulation.
#[test]
fn a_fast_run_is_a_simulation() {
    let folder = folder_with_scenes();
    for (method, flags) in [
        ("hfcr", "--method hfcr"),
        ("coupled", "--method coupled"),
        ("line", "--method coupled --set loop.hold=line"),
    ] {
        folder.succeed(&format!(
            "run fig2.toml --record {method}.mcap --fast --duration 1 {flags}"
        ));
        folder.succeed(&format!("simulate fig2.toml {flags} --out {method}.csv"));
        let csv = folder.read(&format!("{method}.csv"));
        let mut lines = csv.lines().skip_while(|line| line.starts_with('#'));
        let header: Vec<&str> = lines.next().unwrap().split(',').collect();
        let column = header
            .iter()
            .position(|name| name.contains("force_on_object_n"))
            .unwrap_or_else(|| panic!("{header:?}"));
        let simulated: Vec<f64> = lines
            .map(|line| line.split(',').nth(column).unwrap().parse().unwrap())
            .collect();
        let rows = rows(&folder, &format!("{method}.mcap"));
        assert_eq!(rows.len(), 100);
        let sloped = |row: &Row| row.tick.delivered_slope[0] != 0.0;
        assert_eq!(rows.iter().any(sloped), method == "line");
        assert!(simulated.iter().any(|force| *force > 1.0));
        for (row, force) in rows.iter().zip(&simulated) {
            assert!(
                (row.contact.force_on_object - force).abs() < 1e-6,
                "{} s",
                row.tick.time
            );
        }
    }
}

#[test]
fn every_fast_run_is_the_same() {
    let folder = folder_with_scenes();
    for name in ["a", "b"] {
        folder.succeed(&format!(
            "run experiment1.toml --fast --duration 5 --record {name}.mcap"
        ));
    }
    // Compared as text: the first tick has no period, and NaN is not equal to NaN.
    let text = |name| format!("{:?}", rows(&folder, name));
    assert!(text("a.mcap") == text("b.mcap"));
}

/// A busy machine misses some periods, and the run does not get longer.
#[track_caller]
fn all_periods(timing: &Value, periods: u64) {
    let of = |name: &str| timing[name].as_u64().unwrap();
    assert!(of("ticks") <= periods, "{timing}");
    assert!(of("ticks") + of("missed_deadlines") >= periods, "{timing}");
}

#[test]
fn a_run_in_real_time_takes_its_time_and_reports() {
    let folder = folder_with_scenes();
    let begun = Instant::now();
    let answer = folder.succeed("run wall.toml --duration 0.5 --json");
    assert!(begun.elapsed() >= Duration::from_millis(499));
    let report = parse(&answer);
    all_periods(&report["timing"], 500);
    assert_eq!(report["ending"], "the duration is over");
    assert!(number(&report["timing"]["lateness_s"], "longest") >= 0.0);
    let asked = |index: usize| report["realtime"][index]["asked"].as_str();
    assert_eq!(asked(0), Some("SCHED_FIFO, priority 80"));
    assert_eq!(asked(1), Some("memory locked"));
    // If both were denied, one report suffices.
    let supervisor = "supervisor: SCHED_FIFO, priority 81";
    assert!(asked(2).is_none_or(|asked| asked == supervisor));
    let text = folder.succeed("run wall.toml --duration 0.1 --priority 0");
    assert!(text.contains(" ticks; "), "{text}");
    assert!(!text.contains("SCHED_FIFO"), "{text}");
}

#[test]
fn a_recording_of_a_run_is_whole_and_can_be_replayed() {
    let folder = folder_with_scenes();
    let answer =
        folder.palpate("run experiment1.toml --record tap.mcap --duration 2 --method coupled");
    // On a stalled machine safety disables the force, and the recording is still complete.
    let stood_still = answer.code == 5 && answer.stdout.contains("safety-stop-stalled");
    assert!(answer.code == 0 || stood_still, "{answer:?}");
    let info = parse(&folder.succeed("info tap.mcap --json"));
    let ticks = info["ticks"].as_u64().unwrap();
    assert!((50..=100).contains(&ticks), "{info}");
    assert_eq!(info["ticks_lost"], 0);
    assert_eq!(info["events"]["ended"], 1);
    let scene = folder.succeed("info tap.mcap --text scene");
    assert!(scene.contains("\"coupled\""), "{scene}");
    folder.write("back.toml", scene);
    folder.succeed("simulate back.toml");
    let replayed = parse(&folder.succeed("replay tap.mcap --method hfcr --json"));
    assert_eq!(replayed["recording"]["recorded_method"], "coupled");
    folder.succeed("convert tap.mcap");
}

#[test]
fn a_recorded_motion_is_a_device() {
    let folder = folder_with_scenes();
    let line = |i: u32| format!("{},{}\n", f64::from(i) * 0.01, -0.01 + 1e-3 * f64::from(i));
    let trace: String = (0..21).map(line).collect();
    folder.write("push.csv", format!("t_s,position_m\n{trace}"));
    folder.succeed(
        "run wall.toml --record push.mcap --fast --device replay --motion push.csv --method basic",
    );
    let ticks = rows(&folder, "push.mcap");
    let at = |time: f64| {
        ticks
            .iter()
            .find(|tick| tick.tick.time >= time - 1e-9)
            .unwrap()
    };
    // At 0.15 s it is 5 mm in a wall of 1000 N/m.
    assert!(
        (at(0.15).contact.force_on_device + 5.0).abs() < 1e-6,
        "{:?}",
        at(0.15)
    );
    // After its end the device is gone, and so is the force.
    assert_eq!(ticks.last().unwrap().contact.force_on_device, 0.0);
    let info = folder.succeed("info push.mcap");
    assert!(info.contains("safety-stop-device-lost"), "{info}");
    // A motion recorded by a loop gives the same forces.
    folder.succeed(
        "run wall.toml --record again.mcap --fast --device replay --motion push.mcap --method basic",
    );
    let again = rows(&folder, "again.mcap");
    assert!(again.len() >= 200);
    for (before, after) in ticks.iter().zip(&again).take(200) {
        let off = before.contact.force_on_device - after.contact.force_on_device;
        assert!(off.abs() < 1e-9, "{before:?}, {after:?}");
    }
    // A truncated recording is replayed up to its end, with a message.
    let bytes = std::fs::read(folder.path("push.mcap")).unwrap();
    folder.write("cut.mcap", &bytes[..bytes.len() * 9 / 10]);
    let answer =
        folder.palpate("run wall.toml --fast --device replay --motion cut.mcap --method basic");
    assert_eq!(answer.code, 4, "{answer:?}");
    assert!(
        answer.stderr.contains("cut.mcap: not complete"),
        "{answer:?}"
    );
}

/// The pointer's device is the scene's: its motor is limited as in the scene, and it has the delay that the renderer
/// models.
#[test]
fn a_pointer_leads_the_device_of_the_scene() {
    let folder = folder_with_scenes();
    let live =
        experiment_text("live").replace("period_s = 0.01", "period_s = 0.005\ndelay_samples = 4");
    folder.write("late.toml", &live);
    let rests = "run late.toml --record late.mcap --device pointer --object-position 0 --stiffness 1000 \
                 --fast --duration 10 --json";
    let report = parse(&folder.succeed(rests));
    assert!(report["safety_stop"].is_null(), "{report}");
    assert!(number(&report, "leak_held_j") < 5e-3, "{report}");
    let weak = live.replace(
        "[device.hand]\n",
        "[device.drivetrain]\nmotor_limit_n = 0.5\n\n[device.hand]\n",
    );
    assert_ne!(weak, live);
    folder.write("weak.toml", weak);
    let report =
        parse(&folder.succeed(
            "run weak.toml --device pointer --object-position 0 --fast --duration 1 --json",
        ));
    assert!(number(&report, "peak_force_n") <= 0.5, "{report}");
}

/// A delay beyond the renderer's model is reported.
#[test]
fn delay_above_model_limit_is_reported() {
    let folder = folder_with_scenes();
    let words = "the other 4 of these 12 are unmodelled";
    let answer = folder.palpate("simulate wall.toml --delay-periods 12 --method hfcr");
    assert!(answer.stderr.contains(words), "{answer:?}");
    let answer = folder.palpate("simulate wall.toml --delay-periods 8 --method hfcr");
    assert!(!answer.stderr.contains("warning"), "{answer:?}");
    folder.fail(
        "pipe --stiffness 1000 --mass inf --period 0.001 --device-mass 0.2 --delay-periods 12",
        2,
        &["--delay-periods is 0.012 s, 12 periods", "at most 8"],
    );
}

#[test]
fn what_cannot_be_run_is_named() {
    let folder = folder_with_scenes();
    let cases = [
        (
            "run wall.toml --method hfcr,basic",
            2,
            "a loop runs one method",
        ),
        ("run wall.toml --device replay", 2, "--motion"),
        (
            "run wall.toml --safe-force 0",
            2,
            "largest force is 0; allowed",
        ),
        (
            "run wall.toml --safe-range 0.1,-0.1",
            2,
            "extent of the range",
        ),
        ("run wall.toml --safe-range 0.1", 2, "two numbers"),
        ("run wall.toml --spin=-1", 2, "--spin: -1 s is out of range"),
        ("run wall.toml --duration nan", 2, "--duration"),
        ("run wall.toml --priority 100", 2, "100"),
        ("run wall.toml --motion x.csv", 2, "--device replay"),
        ("run wall.toml --period 11", 3, "a nanosecond to 10 s"),
        (
            "run fig2.toml --device pointer --method coupled --set loop.hold=line",
            3,
            "this device holds constants; use a device that holds lines",
        ),
        ("run nowhere.toml", 1, "nowhere.toml"),
        (
            "run wall.toml --record wall.toml --fast",
            1,
            "there is a file of that name",
        ),
        ("doctor --bench --rate 0", 2, "--rate 0"),
        ("doctor --rate 500", 2, "--bench"),
    ];
    for (arguments, code, words) in cases {
        let answer = folder.palpate(arguments);
        assert_eq!(answer.code, code, "{arguments}: {}", answer.stderr);
        assert!(
            answer.stderr.contains(words),
            "{arguments}: {}",
            answer.stderr
        );
    }
    assert_eq!(folder.read("wall.toml"), experiment_text("wall"));
}

#[test]
fn the_doctor_and_the_bench_answer_programs() {
    let folder = folder_with_scenes();
    let doctor = parse(&folder.succeed("doctor --json"));
    for asked in doctor["asked"].as_array().unwrap() {
        let is_granted = asked["granted"].as_bool().unwrap();
        assert_eq!(is_granted, asked["why_not"].is_null());
        assert_eq!(is_granted, asked["remedy"].is_null());
    }
    all_periods(&doctor["loop_at_1000_hz"]["timing"], 2000);
    let bench = parse(&folder.succeed("doctor --bench --rate 200,1000 --duration 0.2 --json"));
    all_periods(&bench[0]["timing"], 40);
    all_periods(&bench[1]["timing"], 200);
}

fn started(folder: &Folder, arguments: &str) -> Running {
    let mut program = program(folder, arguments);
    Running::start(program.stdout(Stdio::null()).stderr(Stdio::null()))
}

/// Waits until a running recording has flushed ticks.
fn wait_for_ticks(part: &std::path::Path) {
    let begun = Instant::now();
    while Recording::open(part).map_or(0, |recording| recording.ticks) == 0 {
        assert!(
            begun.elapsed() < Duration::from_secs(60),
            "no tick in {}",
            part.display()
        );
        sleep(Duration::from_millis(5));
    }
}

#[test]
fn a_signal_ends_a_run_without_force_and_completes_the_recording() {
    let folder = folder_with_scenes();
    let names = [
        "INT", "TERM", "HUP", "QUIT", "TSTP", "TTIN", "TTOU", "USR1", "ALRM", "XCPU",
    ];
    for name in names {
        let file = format!("{name}.mcap");
        let mut child = started(
            &folder,
            &format!("run wall.toml --record {file} --duration inf --soft-start 0"),
        );
        wait_for_ticks(&folder.path(&format!("{file}.part")));
        child.signal(name);
        assert!(child.wait().unwrap().success(), "{name}");
        let recording = Recording::open(&folder.path(&file)).unwrap();
        assert!(recording.is_complete());
        let ended = recording.entries().unwrap().any(|entry| {
            matches!(entry.unwrap(), Entry::Event(event)
                if event.kind == "ended" && event.text.contains("stopped on request"))
        });
        assert!(ended, "{name}");
    }
}

/// The run ended before its requested duration.
#[test]
fn a_run_that_is_stopped_before_its_time_has_an_exit_code() {
    let folder = folder_with_scenes();
    for name in ["INT", "TERM"] {
        let file = format!("{name}.mcap");
        let arguments = format!("run wall.toml --record {file} --duration 1000 --priority 0");
        let mut command = program(&folder, &arguments);
        let child = Running::start(command.stdout(Stdio::piped()).stderr(Stdio::piped()));
        wait_for_ticks(&folder.path(&format!("{file}.part")));
        child.signal(name);
        let output = child.output();
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(130), "{name}: {said}");
        assert!(said.contains("stopped before the end of 1000 s"), "{said}");
        let report = String::from_utf8_lossy(&output.stdout);
        assert!(report.contains(": complete, "), "{report}");
        let recording = Recording::open(&folder.path(&file)).unwrap();
        assert!(recording.is_complete());
        let counted = recording.counted.unwrap();
        assert_eq!(counted.ending.as_deref(), Some("stopped on request"));
    }
}

/// A wall triggers the latched safety stop: the motors are off from then on. Report and recording agree on the numbers,
/// and no energy is recorded afterwards.
#[test]
fn a_run_whose_motors_were_off_says_so_and_has_an_exit_code() {
    let folder = folder_with_scenes();
    let run = "run wall.toml --record off.mcap --method basic --stiffness 20000 --period 0.002 --fast \
               --duration 5 --json";
    let answer = folder.palpate(run);
    assert_eq!(answer.code, 5, "{answer:?}");
    let report = parse(&answer.stdout);
    let off = number(&report, "motors_off_ticks");
    assert!((1000.0..2500.0).contains(&off), "{off}");
    // Of 5 s, the first period precedes the first tick; the motors are off from the end of a tick on.
    let off_s = number(&report, "motors_off_s");
    assert!((off_s - 0.002 * (off - 1.0)).abs() < 1e-9, "{off_s} s");
    assert!((number(&report, "lasted_s") - 4.998).abs() < 1e-9);
    let words = "the safety layer kept the motors off for ";
    for part in [
        words,
        " s of 5.00 s (",
        &format!(" %), and at the end of {off} of 2500 ticks; when it ended: held forces created"),
    ] {
        assert!(answer.stderr.contains(part), "{part}: {}", answer.stderr);
    }
    // All of it was generated before the safety stop: 50 mJ plus one period of a stiff wall.
    let created = number(&report, "leak_held_j");
    assert!((0.05..0.5).contains(&created), "{created} J");
    assert!(number(&report, "outside_work_j") != 0.0);
    // Without the energy that limits of the force explain, as the safety counts it.
    assert!(created <= number(&report, "most_created_energy_j"));
    // The recording itself is complete, with the same numbers.
    assert_eq!(report["recording"]["complete"], true);
    let info = folder.json("info off.mcap");
    for key in ["motors_off_ticks", "motors_off_s", "lasted_s"] {
        assert_eq!(info[key], report[key], "{key}");
    }
    assert_eq!(info["flags"]["safety-stopped"], report["motors_off_ticks"]);
    for (of_run, of_info) in [
        (&report["timing"]["ticks"], &info["ticks_made"]),
        (&report["recording"]["ticks_made"], &info["ticks_made"]),
        (&report["recording"]["ticks"], &info["ticks"]),
        (&report["recording"]["ticks_lost"], &info["ticks_lost"]),
        (&report["recording"]["bytes"], &info["bytes"]),
    ] {
        assert_eq!(of_run, of_info);
    }
    let text = folder.palpate(&run.replace(" --json", "").replace("off.mcap", "again.mcap"));
    assert!(
        in_a_line(&text.stdout).contains(&format!("the duration is over, but {words}")),
        "{}",
        text.stdout
    );
    assert!(
        text.stdout
            .contains("again.mcap: complete, 2500 ticks, 0 lost, ")
    );
}

/// Repeatedly stopped for some 30 ms and continued for some 60 ms: each time the force would be ramping up.
#[test]
fn a_loop_that_is_frozen_again_and_again_ends_with_its_motors_off() {
    let folder = folder_with_scenes();
    let arguments = "run wall.toml --period 0.001 --duration 6 --json --priority 0";
    let mut command = program(&folder, arguments);
    let mut run = Running::start(command.stdout(Stdio::piped()).stderr(Stdio::piped()));
    while run.try_wait().unwrap().is_none() {
        run.signal("STOP");
        sleep(Duration::from_millis(30));
        run.signal("CONT");
        sleep(Duration::from_millis(60));
    }
    let output = run.output();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(5), "{said}");
    assert!(in_a_line(&said).contains("too many recoveries"), "{said}");
    let report = parse(&String::from_utf8(output.stdout).unwrap());
    assert_eq!(report["safety_stop"], "too-many-recoveries", "{report}");
}

/// As with a full disk: the loop continues, and the user is warned at once.
#[test]
fn recording_write_failure_is_reported_at_once_and_loop_continues() {
    let folder = folder_with_scenes();
    let record =
        "run wall.toml --record full.mcap --duration inf --period 0.001 --json --priority 0";
    let limited = format!(
        "ulimit -f 100; exec '{}' {record}",
        env!("CARGO_BIN_EXE_palpate")
    );
    let mut shell = std::process::Command::new("sh");
    shell.args(["-c", &limited]).current_dir(folder.path("."));
    let mut run = Running::start(shell.stdout(Stdio::piped()).stderr(Stdio::piped()));
    let said = BufReader::new(run.stderr.take().unwrap()).lines();
    let warning = said
        .map(Result::unwrap)
        .find(|line| line.starts_with("warning: cannot write"));
    let warning = warning.expect("it ended without a word");
    assert!(
        warning.contains("full.mcap") && warning.contains("the loop continues"),
        "{warning}"
    );
    sleep(Duration::from_millis(300));
    assert!(run.try_wait().unwrap().is_none(), "the loop has ended");
    run.signal("INT");
    let output = run.output();
    assert_eq!(output.status.code(), Some(1));
    let report = parse(&String::from_utf8(output.stdout).unwrap());
    // The remaining ticks were still received.
    assert!(number(&report, "peak_force_n") > 0.0, "{report}");
    let events = report["events"].as_array().unwrap();
    assert_eq!(events.last().unwrap()["kind"], "ended", "{report}");
    assert!(report["recording"].is_null());
}

/// Killed at fifty instants: all flushed ticks are readable.
#[test]
fn a_run_that_is_killed_leaves_a_recording_up_to_its_last_flush() {
    let folder = folder_with_scenes();
    // From the first flush on, spread over a second and over the flushes, which occur every quarter of it.
    let instants = (0..50_u64).map(|i| Duration::from_millis((i * 619) % 1000));
    let (mut fewest, mut with_gaps) = (u64::MAX, 0);
    for (batch, instants) in instants.collect::<Vec<_>>().chunks(5).enumerate() {
        let mut children = Vec::new();
        for (index, instant) in instants.iter().enumerate() {
            let file = format!("{batch}-{index}.mcap");
            let arguments = format!("run wall.toml --record {file} --duration inf --priority 0");
            children.push((started(&folder, &arguments), file, *instant));
        }
        for (_, file, _) in &children {
            wait_for_ticks(&folder.path(&format!("{file}.part")));
        }
        let begun = Instant::now();
        children.sort_by_key(|(_, _, instant)| *instant);
        for (mut child, file, instant) in children {
            sleep(instant.saturating_sub(begun.elapsed()));
            child.kill().unwrap();
            child.wait().unwrap();
            let recording = Recording::open(&folder.path(&format!("{file}.part"))).unwrap();
            assert!(!recording.finished);
            // If the disk stalls for seconds, the loop continues and the ring is full: dropped ticks form a gap.
            with_gaps += u32::from(!recording.missing.is_empty());
            assert!(recording.damage.is_empty(), "{:?}", recording.damage);
            fewest = fewest.min(recording.ticks);
        }
    }
    assert!(fewest > 0, "not even the first flush is there");
    assert!(with_gaps < 25, "{with_gaps} of 50 have gaps");
}

#[test]
fn a_device_with_one_axis_has_no_place_for_the_contact() {
    let folder = folder_with_scenes();
    let run = "run wall.toml --fast";
    for (flags, words) in [
        ("--origin 0,0.1", ["--origin 0,0.1", "one axis"]),
        ("--normal 0,1", ["--normal 0,1", "one axis"]),
        ("--normal 1", ["--normal", "two or three numbers"]),
        ("--origin 0,nan", ["--origin", "two or three numbers"]),
        ("--motion x.csv", ["--motion", "--device replay"]),
    ] {
        folder.fail(&format!("{run} {flags}"), 2, &words);
    }
}
