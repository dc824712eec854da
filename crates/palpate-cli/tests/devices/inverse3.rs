//! The program on an emulated Haply Inverse3.

use std::io::{BufRead, BufReader};
use std::process::Stdio;
use std::time::{Duration, Instant};

use crate::common::running::{Running, program};
use crate::common::{Folder, experiment_text, number, parse};
use palpate_drivers::emulator::inverse3::{Body, Emulator, EmulatorOptions, Fault, holding};

const ID: &str = "049D";

/// A device 100 mm along z, pulled 12 mm further by a hand.
fn emulator() -> Emulator {
    let mut body = Body {
        start: [0.0, 0.0, 0.1],
        ..Body::default()
    };
    body.hands[2] = holding(0.112, 200.0, 4.0);
    Emulator::start(&EmulatorOptions {
        body,
        ..EmulatorOptions::default()
    })
    .unwrap()
}

fn folder() -> Folder {
    let folder = Folder::new();
    // The scene's device starts 2 mm before the wall, and so does this one.
    folder.write("wall.toml", experiment_text("wall"));
    folder
}

fn run(emulator: &Emulator, rest: &str) -> String {
    format!(
        "run wall.toml --device inverse3 --service {} --normal 0,0,1 --method basic --priority 0 \
         --service-priority 0 --stall-after-periods 50 --json {rest}",
        emulator.url()
    )
}

fn wait_for(what: &str, mut is_so: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !is_so() {
        assert!(begun.elapsed() < Duration::from_secs(20), "{what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn a_wall_is_felt_2_mm_before_where_the_device_was_opened() {
    let (folder, emulator) = (folder(), emulator());
    let answer = folder.palpate(&run(&emulator, "--duration 2"));
    assert_eq!(answer.code, 0, "{answer:?}");
    let report = parse(&answer.stdout);
    assert_eq!(report["device"], "Haply Inverse3");
    // 1000 x = 200 (0.010 - x): 1.67 mm and 1.67 N, and more during the approach. If a busy machine disables the force
    // now and then, the hand swings further.
    let (force, depth) = (
        number(&report, "peak_force_n"),
        number(&report, "deepest_penetration_m"),
    );
    assert!(force > 1.0 && (1e-3..17e-3).contains(&depth), "{report}");
    let received = emulator.received();
    assert_eq!(received.last().unwrap().force, Some([0.0; 3]));
    // Along z, and against the hand.
    let pushed = received.iter().filter_map(|message| message.force);
    assert!(
        pushed
            .clone()
            .all(|[x, y, z]| x == 0.0 && y == 0.0 && z <= 0.0)
    );
    assert!(pushed.clone().any(|[_, _, z]| z < -1.0));
}

#[test]
fn a_connection_that_is_cut_ends_a_run_with_a_word_or_is_waited_for() {
    let (folder, emulator) = (folder(), emulator());
    for (flags, code, words) in [
        ("--duration 30", 1, "the device was lost"),
        ("--duration 4 --reconnect", 0, "the device is back"),
    ] {
        let answer = std::thread::scope(|scope| {
            let running = scope.spawn(|| folder.palpate(&run(&emulator, flags)));
            wait_for("a force", || emulator.force(ID).unwrap()[2] < -0.5);
            emulator.inject(Fault::Disconnect);
            running.join().unwrap()
        });
        assert_eq!(answer.code, code, "{answer:?}");
        assert!(answer.stderr.contains(words), "{answer:?}");
        assert!(answer.stderr.contains("connection"), "{answer:?}");
        wait_for("no force", || emulator.force(ID) == Some([0.0; 3]));
    }
}

#[test]
fn what_a_service_has_is_listed() {
    let (folder, emulator) = (folder(), emulator());
    let url = emulator.url();
    let said = folder.succeed(&format!("devices --service {url}"));
    assert!(said.contains("049D  inverse3: ready"), "{said}");
    assert!(said.contains(&format!(
        "--device inverse3 --device-id 049D --service {url}"
    )));
    emulator.set_status(ID, |status| status.calibrated = Some(false));
    let listed = parse(&folder.succeed(&format!("devices --service {url} --json")));
    let device = &listed["inverse_service"]["devices"][0];
    assert!(
        device["why_not"]
            .as_str()
            .unwrap()
            .contains("calibration pose")
    );
    drop(emulator);
    let said = folder.succeed(&format!("devices --service {url}"));
    assert!(said.contains("no answer from"), "{said}");
    folder.fail(
        &format!("run wall.toml --device inverse3 --service {url}"),
        1,
        &["no answer from", "palpate devices emulate inverse3"],
    );
}

#[test]
fn an_emulated_service_says_where_it_is_and_what_it_was_commanded() {
    let folder = folder();
    let emulate = "devices emulate inverse3 --port 0 --events-port 0 --form 3.1 --hold 0.012,0,0 \
                   --fault twice@0.1 --duration 3";
    let mut emulate = program(&folder, emulate);
    let emulate = emulate.stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = Running::start(emulate);
    let mut url = String::new();
    BufReader::new(child.stdout.take().unwrap())
        .read_line(&mut url)
        .unwrap();
    let answer = folder.palpate(&format!(
        "run wall.toml --device inverse3 --service {} --priority 0 --service-priority 0 --duration 1",
        url.trim()
    ));
    assert_eq!(answer.code, 0, "{answer:?}");
    let ended = child.output();
    let said = String::from_utf8(ended.stderr).unwrap();
    assert!(ended.status.success(), "{said}");
    assert!(
        said.contains("at 0.1 s: the next answer is sent twice"),
        "{said}"
    );
    assert!(
        said.contains("1 sessions") && said.contains("in the end 0.000, 0.000, 0.000 N"),
        "{said}"
    );
}

#[test]
fn what_makes_no_sense_is_refused() {
    let folder = folder();
    for (arguments, words) in [
        (
            "run wall.toml --device-id 049D",
            "--device-id is for --device inverse3",
        ),
        (
            "run wall.toml --device inverse3 --fast",
            "--fast is for devices without a motor",
        ),
        (
            "run wall.toml --device inverse3 --service wss://localhost:1",
            "only ws:// is supported",
        ),
        (
            "run wall.toml --reconnect",
            "haply-2diy, inverse3, force-dimension, moteus, odrive, process and udp",
        ),
        (
            "devices emulate inverse3 --fault stall@1",
            "KIND=SECONDS@SECONDS",
        ),
        (
            "devices emulate inverse3 --hold 1,2",
            "three numbers are needed",
        ),
        (
            "devices emulate inverse3 --port 0 --events-port 0 --mass 0",
            "mass",
        ),
        (
            "devices emulate inverse3 --sway-period 0",
            "--sway-period is 0",
        ),
    ] {
        folder.fail(arguments, 2, &[words]);
    }
}

#[test]
fn a_period_that_is_no_time_is_refused() {
    let (folder, emulator) = (folder(), emulator());
    let run = format!(
        "run wall.toml --device inverse3 --service {}",
        emulator.url()
    );
    for period in ["1e30", "1e300"] {
        let words = ["--period", "is out of range", "allowed: 0 to 1e19"];
        folder.fail(&format!("{run} --period {period}"), 2, &words);
    }
}

fn live(emulator: &Emulator, rest: &str) -> String {
    format!(
        "live --device inverse3 --service {} --normal 0,0,1 --priority 0 --service-priority 0 \
         --stall-after-periods 50 --listen 127.0.0.1:0 {rest}",
        emulator.url()
    )
}

/// Two sessions would command the device alternately.
#[test]
fn a_page_has_it_in_one_loop() {
    let (folder, emulator) = (folder(), emulator());
    let live = live(&emulator, "--duration 0.5");
    folder.fail(
        &format!("{live} --method basic,coupled"),
        2,
        &["--method: 2 methods", "in one loop only"],
    );
    let answer = folder.palpate(&live);
    assert_eq!(answer.code, 0, "{answer:?}");
    let said = answer.stdout;
    assert!(said.contains("coupled on the device"), "{said}");
    assert!(!said.contains("basic on the device"), "{said}");
}

#[test]
fn a_page_whose_device_is_lost_says_so_at_its_end() {
    let (folder, emulator) = (folder(), emulator());
    let live = live(&emulator, "--duration 4 --method basic wall.toml");
    let answer = std::thread::scope(|scope| {
        let running = scope.spawn(|| folder.palpate(&live));
        wait_for("a force", || emulator.force(ID).unwrap()[2] < -0.5);
        emulator.inject(Fault::Disconnect);
        running.join().unwrap()
    });
    assert_eq!(answer.code, 1, "{answer:?}");
    assert!(answer.stderr.contains("the device was lost"), "{answer:?}");
    assert!(answer.stdout.contains("basic on the device"), "{answer:?}");
    wait_for("no force", || emulator.force(ID) == Some([0.0; 3]));
}
