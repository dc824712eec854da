//! `palpate run` with a world of several devices.

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::common::running::Running;
use crate::common::{Folder, experiment_text, number, parse};
use palpate_drivers::emulator::inverse3::{Body, Emulator, EmulatorOptions, Fault};
use palpate_record::recording::{Entry, Recording};
use palpate_testbed::hand::{Hand as LeadingHand, IntendedPath, Intention, Sinusoid};

const ID: &str = "049D";
/// Longest wait; only a fully loaded machine needs that long.
const PATIENCE: Duration = Duration::from_secs(60);

fn wait_for(what: &str, mut is_so: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !is_so() {
        assert!(begun.elapsed() < PATIENCE, "waiting for {what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("pinch.toml", experiment_text("worlds/pinch"));
    folder
}

/// The program with arguments separated by blanks, and a `--device` for each of `devices`.
fn program(folder: &Folder, arguments: &str, devices: &[String]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_palpate"));
    command.args(arguments.split_whitespace());
    for device in devices {
        command.args(["--device", device]);
    }
    command.current_dir(folder.path("."));
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// Exit code, standard output and standard error.
fn answer(mut command: Command) -> (i32, String, String) {
    let output = command.output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    let code = output.status.code().unwrap_or(-1);
    (code, text(output.stdout), text(output.stderr))
}

#[test]
fn a_pinch_is_run_recorded_read_back_and_replayed() {
    let folder = folder();
    let command = "run pinch.toml --record pinch.mcap --fast --duration 0.5 --json";
    let report = parse(&folder.succeed(command));
    assert_eq!(report["device"], "left: simulated, right: simulated");
    assert_eq!(report["safety_stop"], serde_json::Value::Null);
    let recording = &report["recording"];
    assert!(
        recording["complete"] == true && recording["ticks"] == 500,
        "{report}"
    );

    let mut pinching = 0;
    let path = folder.path("pinch.mcap");
    for entry in Recording::open(&path).unwrap().entries().unwrap() {
        let Entry::Tick(tick, _, bodies, devices) = entry.unwrap() else {
            continue;
        };
        // The cube, and the proxies of both tools after cube and table.
        let numbers: Vec<u32> = bodies.iter().map(|body| body.body).collect();
        assert_eq!(numbers, [0, 2, 3]);
        let [left, right] = &devices[..] else {
            panic!("{devices:?}");
        };
        assert_eq!(tick.delivered_force, left.delivered_force);
        assert!(
            left.axes[0] < -0.019 && right.axes[0] > 0.019,
            "{devices:?}"
        );
        pinching += usize::from(left.delivered_force[0] < -0.3 && right.delivered_force[0] > 0.3);
    }
    assert!(pinching > 200, "{pinching} ticks of 500");

    let info = parse(&folder.succeed("info pinch.mcap --json"));
    let names = info["devices"].as_array().unwrap().iter();
    let names: Vec<_> = names
        .map(|device| device["name"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["left", "right"]);
    for text in ["device left", "safety right", "frame left"] {
        assert!(info["metadata_bytes"][text].as_u64() > Some(20), "{info}");
    }
    let said = folder.succeed("info pinch.mcap");
    assert!(said.contains("device left: "), "{said}");

    let said = folder.succeed("convert pinch.mcap");
    assert!(
        said.contains("pinch-devices.csv: 2 devices of each tick"),
        "{said}"
    );
    let table = folder.read("pinch-devices.csv");
    assert_eq!(table.lines().count(), 1 + 2 * 500);
    assert!(
        table.starts_with("sequence,device,devices,flags,t_s"),
        "{table:.80}"
    );

    let replayed =
        folder.json_of_a_loop("replay pinch.mcap --method basic,coupled --out replayed.csv");
    let samples = replayed["samples"].as_u64().unwrap();
    assert!((490..500).contains(&samples), "{samples}");
    // Two methods on two devices.
    let rows = folder.read("replayed.csv").lines().count() as u64;
    assert_eq!(rows, 1 + 4 * samples);
    let methods = replayed["methods"].as_array().unwrap();
    let error = |place: usize| number(&methods[place]["sum"], "mean_force_error_percent");
    assert!(error(1) < error(0), "{} {}", error(1), error(0));
}

#[test]
fn a_device_that_is_not_named_as_it_must_be_is_refused() {
    let folder = folder();
    for (devices, words) in [
        (
            &["inverse3"][..],
            "one device is given for all; the world has left and right",
        ),
        (&["left=simulated"], "right is not assigned"),
        (
            &["left=simulated", "thumb=simulated"],
            "no device is called thumb",
        ),
        (
            &["left=simulated", "left=pointer"],
            "left is assigned twice",
        ),
        (&["left=simulated", "simulated"], "a device without a name"),
        (
            &["left=simulated", "right=simulated --port x"],
            "--device right=: --port is for",
        ),
        (
            &["left=simulated", "right=nonsense"],
            "invalid value 'nonsense'",
        ),
        (
            &["left=simulated", "right=pointer --what"],
            "unexpected argument '--what'",
        ),
        (
            &["left=simulated", "right=left=pointer"],
            "which has no name of its own",
        ),
        (&["left="], "NAME=DEVICE FLAGS"),
        (
            &["left=simulated", "right=null"],
            "--device right=: --device: a world runs on",
        ),
        (
            &["left=simulated", "right=inverse3"],
            "--fast is for devices without a motor",
        ),
    ] {
        let devices: Vec<String> = devices.iter().map(|device| (*device).to_owned()).collect();
        let run = "run pinch.toml --fast --duration 0.1";
        let (code, _, said) = answer(program(&folder, run, &devices));
        assert_eq!(code, 2, "{devices:?}: {said}");
        assert!(said.contains(words), "{devices:?}: {said}");
    }
    let devices = ["left=simulated", "right=simulated"].map(str::to_owned);
    let run = "run pinch.toml --fast --duration 0.1";
    let (code, _, said) = answer(program(&folder, &format!("{run} --origin 0,0,0"), &devices));
    assert_eq!(code, 2, "{said}");
    assert!(said.contains("--origin must follow the name"), "{said}");
    let (code, messages, said) = answer(program(&folder, run, &devices));
    assert_eq!(code, 0, "{said}");
    assert!(
        messages.contains("on the devices `left: simulated, right: simulated`"),
        "{messages}"
    );
    // A scene of one contact rejects several devices.
    folder.write("wall.toml", experiment_text("wall"));
    let (code, _, said) = answer(program(&folder, "run wall.toml --fast", &devices));
    assert!(
        code == 2 && said.contains("--device: this command takes one device"),
        "{said}"
    );
}

#[test]
fn a_page_has_several_devices_each_by_its_name() {
    let folder = folder();
    let live = "live pinch.toml --listen 127.0.0.1:0 --duration 0.2 --stall-after-periods 1000 --priority 0";
    // 5 if a busy machine kept the motors off for most of the time.
    for (devices, device) in [
        (&[][..], "`left: pointer, right: pointer`"),
        (
            &["left=pointer", "right=simulated"],
            "`left: pointer, right: simulated`",
        ),
    ] {
        let devices: Vec<String> = devices.iter().map(|device| (*device).to_owned()).collect();
        let (code, messages, said) = answer(program(&folder, live, &devices));
        assert!(matches!(code, 0 | 5), "{code}: {said}");
        assert!(messages.contains(device), "{messages}");
    }
    let refused = |devices: &[&str], flags: &str, words: &str| {
        let devices: Vec<String> = devices.iter().map(|device| (*device).to_owned()).collect();
        let command = program(&folder, &format!("{live} {flags}"), &devices);
        let (code, _, said) = answer(command);
        assert!(code == 2 && said.contains(words), "{code}: {said}");
    };
    refused(&["left=pointer"], "", "right is not assigned");
    refused(
        &["left=pointer", "right=inverse3"],
        "--method basic,coupled",
        "can be in one loop only",
    );
}

/// Two Inverse3 on separate services, each moved to and fro by a hand: within 2 s 3 mm towards the cube between them,
/// which gives 0.6 N. The motion begins slowly, because each hand starts when its device is opened, and the loop starts
/// when both are open.
fn two_fingers() -> [Emulator; 2] {
    [1.0, -1.0].map(|towards| {
        let mut body = Body::default();
        body.hands[0] = LeadingHand::Impedance {
            mass: 0.0,
            stiffness: 200.0,
            damping: 4.0,
            intention: Intention {
                path: IntendedPath::Sinusoid {
                    centre: 0.0,
                    swing: Sinusoid {
                        amplitude: 0.003 * towards,
                        frequency_hz: 0.125,
                        phase: 0.0,
                    },
                },
                tremor: None,
            },
            force: 0.0,
            tremor: None,
        };
        Emulator::start(&EmulatorOptions {
            body,
            ..EmulatorOptions::default()
        })
        .unwrap()
    })
}

fn on(emulators: &[Emulator; 2]) -> Vec<String> {
    let named = ["left", "right"].iter().zip(emulators);
    let device = named.map(|(name, emulator)| {
        let service = emulator.url();
        format!("{name}=inverse3 --service {service} --service-priority 0")
    });
    device.collect()
}

const LOOP: &str = "pinch.toml --record pinch.mcap --priority 0 --stall-after-periods 50 --json";

/// Returns the number of ticks in the recording that push both fingers back.
fn ticks_of_a_pinch(folder: &Folder) -> usize {
    let recording = Recording::open(&folder.path("pinch.mcap")).unwrap();
    assert_eq!(recording.devices, 2);
    let mut ticks = 0;
    for entry in recording.entries().unwrap() {
        if let Entry::Tick(.., devices) = entry.unwrap() {
            let [left, right] = [0, 1].map(|device: usize| devices[device].delivered_force[0]);
            ticks += usize::from(left < -0.2 && right > 0.2);
            assert!(devices[1].round_trip > 0.0);
        }
    }
    ticks
}

#[test]
fn two_inverse3_pinch_a_cube() {
    // A busy machine sometimes stalls the loop beyond its limit, which disables the motors.
    let report = (0..10)
        .map(|_| {
            let (folder, emulators) = (folder(), two_fingers());
            let run = format!("run {LOOP} --duration 2.5");
            let (code, messages, said) = answer(program(&folder, &run, &on(&emulators)));
            // 5 if the motors were off for most of the ticks.
            assert!(matches!(code, 0 | 5), "{code}: {said}");
            for (emulator, sign) in emulators.iter().zip([-1.0, 1.0]) {
                let received = emulator.received();
                let forces = received.iter().filter_map(|message| message.force);
                let forces: Vec<[f64; 3]> = forces.collect();
                assert_eq!(forces.last(), Some(&[0.0; 3]));
                // Outwards on average: `coupled` corrects the excess impulse of a long interval between samples.
                let impulse: f64 = forces.iter().map(|[x, ..]| sign * x).sum();
                assert!(impulse > 0.0, "{said}");
            }
            (parse(&messages), ticks_of_a_pinch(&folder))
        })
        .find(|(_, ticks)| *ticks > 20)
        .expect("the loop was stopped in each of ten runs")
        .0;
    let device = "left: Haply Inverse3, right: Haply Inverse3";
    assert_eq!(report["device"], device);
    assert!(number(&report, "peak_force_n") > 0.2, "{report}");
}

/// Neither a lost device nor a signal leaves the other one with a force.
#[test]
fn what_ends_a_loop_takes_the_force_off_both() {
    let folder = folder();
    for (of, ends, code, words) in [
        ("run", "right", 1, "device right: the device was lost"),
        ("run", "left", 1, "device left: the device was lost"),
        ("run", "TERM", 130, "stopped before the end of"),
        // With a page on it.
        (
            "live --listen 127.0.0.1:0",
            "right",
            1,
            "device right: the device was lost",
        ),
        (
            "live --listen 127.0.0.1:0",
            "TERM",
            130,
            "stopped before the end of",
        ),
    ] {
        let emulators = two_fingers();
        let run = format!("{of} pinch.toml --priority 0 --stall-after-periods 50 --duration 100");
        let mut command = program(&folder, &run, &on(&emulators));
        let running = Running::start(&mut command);
        let force = |emulator: &Emulator| emulator.force(ID).unwrap_or_default()[0];
        wait_for("two forces", || {
            force(&emulators[0]) < -0.2 && force(&emulators[1]) > 0.2
        });
        match ends {
            "left" => emulators[0].inject(Fault::Disconnect),
            "right" => emulators[1].inject(Fault::Disconnect),
            signal => running.signal(signal),
        }
        let output = running.output();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "{ends}: {said}");
        assert!(said.contains(words), "{ends}: {said}");
        wait_for("no force", || {
            emulators
                .iter()
                .all(|emulator| emulator.force(ID) == Some([0.0; 3]))
        });
        // The loop commanded zero force to the connected device.
        for (name, emulator) in ["left", "right"].iter().zip(&emulators) {
            let received = emulator.received();
            let last = received.iter().rev().find_map(|message| message.force);
            assert!(*name == ends || last == Some([0.0; 3]), "{ends}: {last:?}");
        }
    }
}

/// Each board holds its last torque and has its own watchdog process: no torque stays on after the program is killed,
/// or beyond the timeout while it is stopped.
#[cfg(target_os = "linux")]
#[test]
fn the_watchdog_of_each_board_takes_its_torque_off() {
    use palpate_drivers::emulator::port::PortSettings;
    use palpate_drivers::emulator::two_diy::{Emulator, Hand, Settings};
    use palpate_drivers::two_diy::{Board, Generation};
    let folder = Folder::new();
    folder.write("walls.toml", TWO_WALLS);
    for signal in ["KILL", "STOP"] {
        let ports = ["left", "right"].map(|name| folder.path(&format!("{name}-{signal}")));
        let emulators = ports.clone().map(|path| {
            let settings = Settings {
                angles: Some([130.0, 50.0]),
                hand: Hand::at([0.019, 0.1169]),
                port: PortSettings::Socket { path },
                ..Settings::new(Generation::Three, Board::M0)
            };
            Emulator::start(&settings).unwrap()
        });
        let devices = ["left", "right"].iter().zip(&ports).map(|(name, port)| {
            let port = port.display();
            format!(
                "{name}=haply-2diy --port {port} --board m0 --start-pose 130,50 --origin 0.019,0.11"
            )
        });
        let devices: Vec<String> = devices.collect();
        let press = || {
            let run = "run walls.toml --priority 0 --stall-after-periods 50 --soft-start 0 --duration inf";
            let mut running = Running::start(&mut program(&folder, run, &devices));
            let mut has_ended = false;
            wait_for("two torques", || {
                has_ended = running.try_wait().unwrap().is_some();
                has_ended || emulators.iter().all(|board| board.torques() != [0.0; 2])
            });
            (!has_ended).then_some(running)
        };
        // On a stalled machine a loop loses the boards before the signal or with it. It has then disabled the force
        // itself, and a watchdog process reports nothing.
        let is_seen = (0..10).filter_map(|_| press()).any(|running| {
            running.signal(signal);
            wait_for("no torque", || {
                emulators.iter().all(|board| board.torques() == [0.0; 2])
            });
            if signal == "STOP" {
                running.signal("CONT");
                running.signal("TERM");
            }
            let output = running.output();
            let said = String::from_utf8(output.stderr).unwrap();
            for board in &emulators {
                assert_eq!(board.torques(), [0.0; 2], "{said}");
            }
            // Each watchdog process reports if the loop has ended for good.
            signal == "STOP" || said.matches("the force is now 0").count() >= 2
        });
        assert!(is_seen, "{signal}: not one of ten loops left two forces on");
    }
}

/// Two devices, each 7 mm in its own wall.
const TWO_WALLS: &str = r#"
format = 2
[loop]
period_s = 0.001
[[device]]
name = "left"
mass_kg = 0.2
tool = { sphere = { radius_m = 0.0 } }
[[device]]
name = "right"
mass_kg = 0.2
tool = { sphere = { radius_m = 0.0 } }
[[body]]
name = "wall"
fixed = true
shape = { half_space = { normal = [0.0, -1.0, 0.0], offset_m = 0.0 } }
[[contact]]
between = ["left", "wall"]
stiffness_n_per_m = 300.0
[[contact]]
between = ["right", "wall"]
stiffness_n_per_m = 300.0
[render]
method = "basic"
"#;

#[test]
fn one_device_is_not_two() {
    let (folder, [emulator, _]) = (folder(), two_fingers());
    let url = emulator.url();
    let localhost = url.replace("127.0.0.1", "localhost");
    let devices = [("left", &url), ("right", &localhost)]
        .map(|(name, url)| format!("{name}=inverse3 --service {url} --service-priority 0"));
    let run = "run pinch.toml --priority 0 --duration 1";
    let (code, _, said) = answer(program(&folder, run, &devices));
    assert_eq!(code, 2, "{said}");
    assert!(
        said.contains("left and right are the same device"),
        "{said}"
    );
    assert!(
        emulator
            .received()
            .iter()
            .all(|message| { message.force.is_none_or(|force| force == [0.0; 3]) })
    );
}
