//! The program on emulated motor drives.

#![cfg(unix)]

use std::io::{BufRead, BufReader};
use std::process::Stdio;
use std::time::{Duration, Instant};

use palpate_drivers::emulator::drive::{Emulator, Fault, Maker, Settings};
use palpate_drivers::emulator::inverse3::holding;
use palpate_drivers::emulator::port::PortSettings;

use crate::common::running::{Running, program};
use crate::common::{Folder, experiment_text, number, parse};

const MAKERS: [(Maker, &str); 2] = [(Maker::Moteus, "moteus"), (Maker::Odrive, "odrive")];
const MASS: f64 = 0.15;

struct Bench {
    folder: Folder,
    emulator: Emulator,
    /// `--device` with its text.
    on_it: String,
}

/// A drive whose handle starts at `start` and is pulled to `hold` `[m]`.
fn bench((maker, name): (Maker, &str), [start, hold]: [f64; 2]) -> Bench {
    let folder = Folder::new();
    folder.write("wall.toml", experiment_text("wall"));
    let settings = Settings {
        mass: MASS,
        start,
        hand: holding(hold, 200.0, 4.0),
        port: PortSettings::Socket {
            path: folder.path("port"),
        },
        ..Settings::new(maker)
    };
    Bench {
        emulator: Emulator::start(&settings).unwrap(),
        folder,
        on_it: format!("--device {name}:port,radius_m=0.02,torque_nm=0.2"),
    }
}

/// It starts 2 mm before the wall, and the hand is 10 mm behind its surface.
fn in_the_wall(maker: (Maker, &str)) -> Bench {
    bench(maker, [-0.002, 0.010])
}

impl Bench {
    fn run(&self, flags: &str) -> String {
        format!(
            "run wall.toml {} --priority 0 --stall-after-periods 50 --method basic {flags}",
            self.on_it
        )
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

/// Torque of half a newton on the radius of the pulley.
const FELT: f64 = -0.5 * 0.02;

#[test]
fn a_wall_is_felt_and_recorded_and_ends_with_a_motor_that_is_off() {
    for maker in MAKERS {
        let bench = in_the_wall(maker);
        let answer = bench
            .folder
            .palpate(&bench.run("--duration 1 --json --record own.mcap"));
        assert_eq!(answer.code, 0, "{answer:?}");
        assert!(
            answer.stderr.contains("takes the torque off 50 ms after"),
            "{answer:?}"
        );
        let report = parse(&answer.stdout);
        crate::common::schema::check(&report);
        // 1000 x = 200 (0.010 - x): 1.67 mm and 1.67 N, and more during the approach.
        assert!(number(&report, "peak_force_n") > 1.0, "{report}");
        assert!(number(&report["connections"][0], "samples") > 100.0);
        assert!(report["watchdog"].is_null());
        let recorded = bench.folder.json_of_a_loop("info own.mcap");
        assert!(number(&recorded, "ticks") > 100.0);
        bench.wait_for("a motor that is off", |bench| bench.emulator.is_off());
        assert_eq!(bench.emulator.torque(), 0.0);
    }
}

/// No command follows: only the drive takes the torque off.
#[test]
fn a_killed_or_stopped_run_leaves_no_torque() {
    for maker in MAKERS {
        for signal in ["KILL", "STOP"] {
            let bench = in_the_wall(maker);
            let mut command = program(&bench.folder, &bench.run("--duration inf"));
            let running = Running::start(command.stdout(Stdio::null()).stderr(Stdio::null()));
            bench.wait_for("a torque", |bench| bench.emulator.torque() < FELT);
            running.signal(signal);
            bench.wait_for("no torque", |bench| bench.emulator.torque() == 0.0);
            assert!(bench.emulator.was_cut());
        }
    }
}

/// A loss is a second of silence, and the motors are on for most of a run that succeeds.
#[test]
fn a_drive_that_is_lost_ends_a_run_with_a_word_or_is_waited_for() {
    for maker in MAKERS {
        for (flags, code, words) in [
            ("--duration 60", 1, "has not answered for a second"),
            ("--duration 8 --reconnect", 0, "the device is back"),
        ] {
            let bench = in_the_wall(maker);
            let run = bench.run(flags);
            let answer = std::thread::scope(|scope| {
                let running = scope.spawn(|| bench.folder.palpate(&run));
                bench.wait_for("a torque", |bench| bench.emulator.torque() < FELT);
                bench
                    .emulator
                    .inject(Fault::Silence(Duration::from_millis(1500)));
                bench.wait_for("no torque", |bench| bench.emulator.torque() == 0.0);
                running.join().unwrap()
            });
            assert_eq!(answer.code, code, "{answer:?}");
            assert!(answer.stderr.contains(words), "{answer:?}");
            bench.wait_for("no torque", |bench| bench.emulator.torque() == 0.0);
        }
    }
}

/// A calibration takes 3 s of motion.
#[test]
fn a_calibration_finds_the_mass_that_was_put_in() {
    for maker in MAKERS {
        let bench = bench(maker, [0.0; 2]);
        // A machine that is too busy spoils a calibration, which then says so.
        let is_found = (0..3).any(|_| {
            let calibrate = format!(
                "calibrate {} --wait 0 --seconds 3 --out device.toml --json",
                bench.on_it
            );
            let answer = bench.folder.palpate(&calibrate);
            bench.wait_for("no torque", |bench| bench.emulator.torque() == 0.0);
            if answer.code == 0 {
                let found = parse(&answer.stdout)["found"]["device_mass_kg"]["value"].clone();
                let mass = found.as_f64().unwrap();
                assert!((mass / MASS - 1.0).abs() < 0.1, "{mass}");
                return true;
            }
            assert_eq!(answer.code, 6, "{answer:?}");
            let named = ["samples are missing", "times between samples vary"];
            named.iter().any(|words| answer.stderr.contains(words))
        });
        assert!(
            is_found,
            "three calibrations were declined although no sample was missing"
        );
    }
}

#[test]
fn an_emulated_drive_says_where_it_is_and_what_it_was_commanded() {
    let folder = Folder::new();
    folder.write("wall.toml", experiment_text("wall"));
    for (_, name) in MAKERS {
        let emulate = format!("devices emulate {name} --hold 0.012 --fault torn@0.1 --link tty");
        let mut emulate = program(&folder, &emulate);
        let emulate = emulate.stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = Running::start(emulate);
        let mut port = String::new();
        BufReader::new(child.stdout.take().unwrap())
            .read_line(&mut port)
            .unwrap();
        assert_eq!(port.trim(), "tty");
        let answer = folder.palpate(&format!(
            "run wall.toml --device {name}:tty,radius_m=0.02 --priority 0 --stall-after-periods 200 --duration 1"
        ));
        assert_eq!(answer.code, 0, "{answer:?}");
        child.signal("INT");
        let ended = child.output();
        let said = String::from_utf8(ended.stderr).unwrap();
        assert!(ended.status.success(), "{said}");
        assert!(said.contains("the next answer is torn"), "{said}");
        assert!(said.contains("in the end 0.0000 N m"), "{said}");
    }
}

#[test]
fn what_makes_no_sense_is_refused() {
    let bench = in_the_wall(MAKERS[0]);
    for (arguments, code, words) in [
        (
            "run wall.toml --device moteus:port",
            2,
            "needed: moteus:PORT",
        ),
        (
            "run wall.toml --device odrive:port,radius_m=0.02,id=1",
            2,
            "id: needed: odrive",
        ),
        (
            "run wall.toml --device moteus:port,radius_m=0",
            2,
            "the travel per turn is 0",
        ),
        (
            "run wall.toml --device moteus:none,radius_m=0.02",
            1,
            "none: ",
        ),
        (
            "run wall.toml --device moteus:port,radius_m=0.02,id=7",
            1,
            "moteus 7 does not answer",
        ),
        (
            "run wall.toml --device moteus:port,radius_m=0.02 --fast",
            2,
            "--fast is for devices without a motor",
        ),
        (
            "run wall.toml --device moteus:port,radius_m=0.02 --watchdog off",
            2,
            "haply-2diy, process and udp",
        ),
        ("devices emulate moteus --fault x@1", 2, "kinds: silence"),
        ("devices emulate odrive --radius 0", 2, "--radius is 0"),
    ] {
        bench.folder.fail(arguments, code, &[words]);
    }
}
