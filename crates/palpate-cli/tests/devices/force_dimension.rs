//! The program on an emulated device of Force Dimension.

#![cfg(unix)]

use std::io::{BufRead, BufReader};
use std::process::Stdio;
use std::time::{Duration, Instant};

use palpate_device::clock::MonotonicClock;
use palpate_drivers::emulator::force_dimension::{Emulator, EmulatorOptions};
use palpate_drivers::emulator::inverse3::{Body, holding};
use palpate_drivers::force_dimension::Kind;

use crate::common::running::{Running, program};
use crate::common::{Folder, experiment_text, number, parse};

struct Bench {
    folder: Folder,
    emulator: Emulator,
    clock: MonotonicClock,
}

/// A device of this type at `start`, pulled along x and z to `hold` `[m]`.
fn bench(kind: &str, [start, hold]: [[f64; 3]; 2]) -> Bench {
    let mut body = Body {
        start,
        ..Body::default()
    };
    for (hand, place) in body.hands.iter_mut().zip(hold) {
        *hand = holding(place, 200.0, 4.0);
    }
    let options = EmulatorOptions {
        kind: Kind::of_name(kind).unwrap(),
        body,
        ..EmulatorOptions::default()
    };
    let (folder, clock) = (Folder::new(), MonotonicClock::new());
    folder.write("wall.toml", experiment_text("wall"));
    let emulator = Emulator::start(&folder.path("."), &options, &clock).unwrap();
    Bench {
        folder,
        emulator,
        clock,
    }
}

/// An omega.3 in the wall: it starts 2 mm before it, and the hand is 10 mm behind its surface.
fn in_the_wall() -> Bench {
    bench("omega.3", [[-0.002, 0.0, 0.0], [0.010, 0.0, 0.0]])
}

const ON_IT: &str =
    "--device force-dimension --library libdrd.so --priority 0 --stall-after-periods 50";

impl Bench {
    fn force(&self) -> [f64; 3] {
        self.emulator.held(&self.clock).0
    }

    #[track_caller]
    fn wait_for(&self, what: &str, is_so: impl Fn(&Self) -> bool) {
        let begun = Instant::now();
        while !is_so(self) {
            assert!(begun.elapsed() < Duration::from_secs(60), "{what}");
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

#[test]
fn a_wall_is_felt_and_recorded_and_ends_with_zero() {
    let bench = in_the_wall();
    let run = format!("run wall.toml {ON_IT} --method basic --duration 1 --json --record own.mcap");
    let answer = bench.folder.palpate(&run);
    assert_eq!(answer.code, 0, "{answer:?}");
    for words in [
        "takes the force off 31.875 ms after",
        "mean mass at the present pose is 0.200 kg",
        "for a mass_table: [0.2000, 0.2000, 0.2000, 0.0000, 0.0000, 0.0000] kg at [-0.0020,",
    ] {
        assert!(answer.stderr.contains(words), "{answer:?}");
    }
    let report = parse(&answer.stdout);
    crate::common::schema::check(&report);
    assert_eq!(report["device"], "omega.3");
    // 1000 x = 200 (0.010 - x): 1.67 mm and 1.67 N, and more during the approach.
    assert!(number(&report, "peak_force_n") > 1.0, "{report}");
    assert!(number(&report["connections"][0], "samples") > 100.0);
    assert!(report["watchdog"].is_null());
    let recorded = bench.folder.json_of_a_loop("info own.mcap");
    assert!(number(&recorded, "ticks") > 100.0);
    assert_eq!(bench.force(), [0.0; 3]);
    assert!(!bench.emulator.is_open());
}

/// No command follows: only the firmware takes the force off.
#[test]
fn a_killed_or_stopped_run_leaves_no_force() {
    for signal in ["KILL", "STOP"] {
        let bench = in_the_wall();
        let run = format!("run wall.toml {ON_IT} --method basic --duration inf");
        let mut command = program(&bench.folder, &run);
        let running = Running::start(command.stdout(Stdio::null()).stderr(Stdio::null()));
        bench.wait_for("a force", |bench| bench.force()[0] < -0.5);
        running.signal(signal);
        bench.wait_for("no force", |bench| bench.force() == [0.0; 3]);
        assert!(bench.emulator.was_cut());
        if signal == "STOP" {
            running.signal("KILL");
        }
        bench.wait_for("the end", |bench| !bench.emulator.is_open());
    }
}

#[test]
fn a_device_that_is_unplugged_ends_a_run_with_a_word_or_is_waited_for() {
    for (flags, code, words) in [
        ("--duration 60", 1, "unplugged"),
        ("--duration 4 --reconnect", 0, "the device is back"),
    ] {
        let bench = in_the_wall();
        let run = format!("run wall.toml {ON_IT} --method basic {flags}");
        let answer = std::thread::scope(|scope| {
            let running = scope.spawn(|| bench.folder.palpate(&run));
            bench.wait_for("a force", |bench| bench.force()[0] < -0.5);
            bench
                .emulator
                .trouble(|trouble| trouble.is_unplugged = true);
            bench.wait_for("the watchdog", |bench| bench.force() == [0.0; 3]);
            bench
                .emulator
                .trouble(|trouble| trouble.is_unplugged = false);
            running.join().unwrap()
        });
        assert_eq!(answer.code, code, "{answer:?}");
        assert!(answer.stderr.contains(words), "{answer:?}");
        assert_eq!(bench.force(), [0.0; 3]);
    }
}

const LEVER: &str = r#"format = 2
title = "A lever on a table"
[loop]
period_s = 0.001
[[device]]
name = "tool"
mass_kg = 0.2
inertia_kg_m2 = [2e-4, 2e-4, 2e-4]
position_m = [0.0, 0.0, 0.02]
tool = { spheres = [{ centre_m = [0.04, 0.0, 0.0], radius_m = 0.005 }] }
[[body]]
name = "table"
fixed = true
shape = { half_space = { normal = [0.0, 0.0, 1.0] } }
[[contact]]
between = ["tool", "table"]
stiffness_n_per_m = 500.0
[render]
method = "basic"
[measure]
duration_s = 0.1
"#;

#[test]
fn a_world_turns_the_handle_of_six_axes() {
    let bench = bench("sigma.7-right", [[0.0, 0.0, 0.02], [0.0; 3]]);
    bench.folder.write("lever.toml", LEVER);
    let run = format!("run lever.toml {ON_IT} --duration 20 --json --record lever.mcap");
    let mut command = program(&bench.folder, &run);
    let running = Running::start(command.stdout(Stdio::piped()).stderr(Stdio::piped()));
    // The end of the lever is on the table, and its force times 40 mm turns it about -y.
    let torque = |bench: &Bench| bench.emulator.held(&bench.clock).1;
    bench.wait_for("a torque", |bench| torque(bench)[1] < -0.01);
    running.signal("INT");
    let ran = running.output();
    let said = String::from_utf8(ran.stderr).unwrap();
    assert_eq!(torque(&bench), [0.0; 3], "{said}");
    let report = parse(&String::from_utf8(ran.stdout).unwrap());
    crate::common::schema::check(&report);
    assert_eq!(report["device"], "sigma.7-right", "{said}");
    let recorded = bench.folder.json_of_a_loop("info lever.mcap");
    assert!(number(&recorded, "ticks") > 10.0, "{recorded}");
    let mut omega = program(&bench.folder, &run);
    // Its gripper has one axis, and no orientation.
    let refused = omega.arg("--gripper").output().unwrap();
    assert!(!refused.status.success());
}

#[test]
fn the_gripper_squeezes_a_wall() {
    let bench = bench("omega.7-left", [[0.0; 3]; 2]);
    let run = format!("run wall.toml {ON_IT} --gripper --method basic --duration 60");
    let mut command = program(&bench.folder, &run);
    let running = Running::start(command.stdout(Stdio::null()).stderr(Stdio::piped()));
    // A gap of 15 mm is in the wall from 0 on: the gripper closes.
    let grip = |bench: &Bench| bench.emulator.held(&bench.clock).2;
    bench.wait_for("a force of the gripper", |bench| grip(bench) < -0.5);
    assert_eq!(bench.force(), [0.0; 3]);
    running.signal("INT");
    let said = String::from_utf8(running.output().stderr).unwrap();
    assert!(grip(&bench).abs() < 1e-12, "{said}");
}

/// A calibration takes 3 s of motion.
#[test]
fn a_page_and_a_calibration_have_it() {
    let bench = in_the_wall();
    let live = format!("live wall.toml {ON_IT} --listen 127.0.0.1:0 --duration 0.5 --method basic");
    let answer = bench.folder.palpate(&live);
    assert_eq!(answer.code, 0, "{answer:?}");
    assert!(answer.stdout.contains("basic on the device"), "{answer:?}");
    let bench = self::bench("omega.3", [[0.0; 3]; 2]);
    // A machine that is too busy spoils a calibration, which then says so.
    for _ in 0..3 {
        let calibrate = "calibrate --device force-dimension --library libdrd.so --wait 0 --seconds 3 --out device.toml \
                         --json";
        let answer = bench.folder.palpate(calibrate);
        assert_eq!(bench.force(), [0.0; 3]);
        if answer.code == 0 {
            let found = parse(&answer.stdout)["found"]["device_mass_kg"]["value"].clone();
            let mass = found.as_f64().unwrap();
            assert!((mass / 0.2 - 1.0).abs() < 0.1, "{mass}");
            return;
        }
        assert_eq!(answer.code, 6, "{answer:?}");
        let named = ["samples are missing", "times between samples vary"];
        if named.iter().any(|words| answer.stderr.contains(words)) {
            return;
        }
    }
    panic!("three calibrations were declined although no sample was missing");
}

#[test]
fn the_emulated_library_says_where_it_is_and_what_it_was_commanded() {
    let folder = Folder::new();
    folder.write("wall.toml", experiment_text("wall"));
    let emulate = "devices emulate force-dimension --hold 0.012,0,0 --fault saturate=1@0";
    let mut emulate = program(&folder, emulate);
    let emulate = emulate.stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = Running::start(emulate);
    let mut library = String::new();
    BufReader::new(child.stdout.take().unwrap())
        .read_line(&mut library)
        .unwrap();
    let library = library.trim();
    let answer = folder.palpate(&format!(
        "run wall.toml --device force-dimension --library {library} --priority 0 --stall-after-periods 50 --duration 2"
    ));
    assert_eq!(answer.code, 0, "{answer:?}");
    assert!(
        answer.stderr.contains("commands saturated motors"),
        "{answer:?}"
    );
    child.signal("INT");
    let ended = child.output();
    let said = String::from_utf8(ended.stderr).unwrap();
    assert!(ended.status.success(), "{said}");
    assert!(said.contains("in the end 0.000, 0.000, 0.000 N"), "{said}");
    assert!(!std::path::Path::new(library).exists());
}

#[test]
fn what_makes_no_sense_is_refused() {
    let bench = in_the_wall();
    for (arguments, code, words) in [
        (
            "run wall.toml --library x.so",
            2,
            "--library is for --device force-dimension",
        ),
        (
            "run wall.toml --gripper",
            2,
            "--gripper is for --device force-dimension",
        ),
        (
            &format!("run wall.toml {ON_IT} --gripper"),
            2,
            "has no gripper",
        ),
        (
            &format!("run wall.toml {ON_IT} --period 0.05"),
            2,
            "at most 21.25 ms",
        ),
        (
            &format!("run wall.toml {ON_IT} --fast"),
            2,
            "--fast is for devices without a motor",
        ),
        (
            &format!("run wall.toml {ON_IT} --watchdog off"),
            2,
            "haply-2diy, process and udp",
        ),
        (
            "run wall.toml --device force-dimension --library none.so",
            1,
            "the library none.so: none.so: cannot open",
        ),
        (
            "devices emulate force-dimension --type falcon",
            2,
            "allowed: omega.3",
        ),
        (
            "devices emulate force-dimension --fault x@1",
            2,
            "kinds: unplug, plug-in",
        ),
    ] {
        bench.folder.fail(arguments, code, &[words]);
    }
    bench.emulator.set_status(|status| status[3] = 1);
    bench
        .folder
        .fail(&format!("run wall.toml {ON_IT}"), 1, &["is not calibrated"]);
}
