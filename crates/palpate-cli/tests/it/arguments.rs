//! Help, completions, and messages for unknown arguments.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use crate::common::{Answer, Folder, taps, trace_text};

const COMMANDS: [&str; 25] = [
    "render",
    "simulate",
    "compare",
    "pipe",
    "calibrate",
    "run",
    "devices",
    "devices emulate",
    "live",
    "doctor",
    "info",
    "convert",
    "replay",
    "report",
    "tune",
    "suite",
    "sweep",
    "map",
    "advise",
    "paper",
    "paper figure",
    "paper claims",
    "paper heights",
    "demo",
    "completions",
];

#[test]
fn every_command_explains_itself_with_examples() {
    let folder = Folder::new();
    for command in COMMANDS {
        for help in [
            format!("{command} --help"),
            format!("{command} -h"),
            format!("help {command}"),
        ] {
            let text = folder.succeed(&help);
            assert!(text.contains("Example"), "{help}:\n{text}");
            assert!(
                text.contains(&format!("palpate {command} ")),
                "{help}:\n{text}"
            );
            assert!(
                text.contains(&format!("Usage: palpate {command} ")),
                "{help}:\n{text}"
            );
            assert!(
                !text.contains('\x1b'),
                "{help} has colours without a terminal"
            );
            let widest = text.lines().map(|line| line.chars().count()).max();
            assert!(widest <= Some(100), "{help} is {widest:?} wide");
        }
    }
    let top = folder.succeed("--help");
    assert!(
        top.contains("Examples:") && top.contains("Exit codes:"),
        "{top}"
    );
}

/// Returns a folder with exactly the files that the examples of a command read: the output of one command would
/// obstruct another.
fn with_what_examples_read(command: &str) -> Folder {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("experiments")).unwrap();
    let scenes = [
        "fig2",
        "experiment1",
        "experiment1_in_a_hand",
        "experiment2",
        "fig4",
        "fig5",
        "wall",
    ];
    for name in scenes {
        let file = format!("experiments/{name}.toml");
        folder.write(&file, crate::common::experiment_text(name));
    }
    for (kind, name) in [
        ("worlds", "paddle"),
        ("worlds", "pushed-block"),
        ("worlds-on-devices", "ball-on-table"),
    ] {
        let _ = std::fs::create_dir(folder.path(&format!("experiments/{kind}")));
        let file = format!("experiments/{kind}/{name}.toml");
        folder.write(
            &file,
            crate::common::experiment_text(&format!("{kind}/{name}")),
        );
    }
    std::fs::create_dir(folder.path("experiments/users")).unwrap();
    folder.write(
        "experiments/users/wall.toml",
        crate::common::experiment_text("wall"),
    );
    std::fs::create_dir(folder.path("figures")).unwrap();
    // A table of tap.mcap would have the same name as this trace.
    if command != "convert" {
        folder.write("tap.csv", trace_text(&taps(0.001, 0.5)));
    }
    folder.write("motion.csv", "t,x,y,z\n0,0,0,0.1\n0.05,0,0,0.1\n");
    folder.write("hand.csv", trace_text(&taps(0.001, 0.5)));
    crate::recordings::record(&folder.path("tap.mcap"));
    folder
}

/// An example of a help text: its command, arguments and input.
struct Example {
    command: &'static str,
    arguments: String,
    input: String,
}

impl Example {
    /// Whether safety watches a real-time loop, in which a missed deadline of the machine counts.
    fn is_in_real_time(&self) -> bool {
        ["run", "live"].contains(&self.command) && !self.arguments.contains("--fast")
    }

    fn answer(&self) -> Answer {
        let folder = with_what_examples_read(self.command);
        folder.palpate_reading(self.input.clone(), &self.arguments)
    }
}

/// Returns the examples in the help of a command, or of the program.
fn examples_of(command: &'static str) -> Vec<Example> {
    let taps = trace_text(&taps(0.001, 0.5));
    let help = Folder::new().succeed(&format!("{command} --help"));
    let examples = help.split("Example").last().unwrap();
    let lines = examples.lines().filter(|line| line.contains("palpate "));
    let examples = lines.map(|line| {
        let example = line.split("palpate ").nth(1).unwrap();
        // A wide gap precedes a remark.
        let arguments = example.split("   ").next().unwrap();
        let arguments = arguments.split(" > ").next().unwrap();
        // A shell would find this file. Fewer plants and cells are understood as well, in a tenth of the time.
        let mut arguments = arguments
            .replace("users/*.toml", "users/wall.toml")
            .replace("--plants 40 --seeds 7", "--plants 4 --seeds 7")
            .replace("--cells 9", "--cells 3");
        if command == "live" {
            // Until ctrl-C, and on a port that no other test uses.
            arguments += " --listen 127.0.0.1:0";
            if !arguments.contains("--duration") {
                arguments += " --duration 0.2";
            }
        }
        let input = if example.contains(" - ") {
            taps.clone()
        } else {
            "0\n".into()
        };
        Example {
            command,
            arguments,
            input,
        }
    });
    examples.collect()
}

#[test]
fn the_examples_of_the_help_are_understood() {
    // A calibration needs a device in a loop, and a page about a device needs a calibration. `paper claims` has a
    // separate test, and takes seconds.
    let not_tried = ["completions", "calibrate", "report", "paper claims"];
    let is_tried =
        |example: &Example| !not_tried.iter().any(|it| example.arguments.starts_with(it));
    let examples: Vec<Example> = COMMANDS
        .iter()
        .chain([&""])
        .flat_map(|command| examples_of(command))
        .filter(is_tried)
        .collect();
    assert!(examples.len() >= 45, "{} examples", examples.len());
    let (real_time, others): (Vec<&Example>, Vec<&Example>) = examples
        .iter()
        .partition(|example| example.is_in_real_time());
    let next = AtomicUsize::new(0);
    let try_some = || {
        while let Some(example) = others.get(next.fetch_add(1, Ordering::Relaxed)) {
            let answer = example.answer();
            assert_eq!(answer.code, 0, "palpate {}: {answer:?}", example.arguments);
        }
    };
    // Examples with deadlines run alone.
    assert!(real_time.len() >= 8, "{} in real time", real_time.len());
    for example in real_time {
        let answer = example.answer();
        // Safety may end a loop that missed its deadlines on a busy machine; this does not concern the arguments.
        let stopped_late = answer.code == 5 && answer.stdout.contains("missed-deadline");
        let arguments = &example.arguments;
        assert!(
            answer.code == 0 || stopped_late,
            "palpate {arguments}: {answer:?}"
        );
    }
    // Most of the others use one processor.
    thread::scope(|threads| {
        for _ in 0..thread::available_parallelism().map_or(1, usize::from) {
            threads.spawn(try_some);
        }
    });
}

#[test]
fn the_help_of_the_pipe_draws_the_sign_of_the_force() {
    let help = Folder::new().succeed("pipe --help");
    assert!(help.contains("force ON THE DEVICE in newtons"), "{help}");
    assert!(help.contains("----------->|      |=========|"), "{help}");
    assert!(
        help.contains("force on the device: negative while the object pushes back"),
        "{help}"
    );
}

#[test]
fn what_is_needed_stands_in_the_usage() {
    for command in ["render", "pipe"] {
        let help = Folder::new().succeed(&format!("{command} --help"));
        let usage = help
            .lines()
            .find(|line| line.starts_with("Usage:"))
            .unwrap();
        for flag in ["--stiffness <N/m>", "--mass <kg|inf>", "--period <s>"] {
            assert!(usage.contains(flag), "{usage}");
        }
    }
}

#[test]
fn every_shell_gets_completions() {
    let folder = Folder::new();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = folder.succeed(&format!("completions {shell}"));
        for word in ["simulate", "stiffness", "encoder-quantum"] {
            assert!(script.contains(word), "{shell} does not know {word}");
        }
        folder.write(shell, script);
    }
    folder.fail(
        "completions tcsh",
        2,
        &["tcsh", "bash, elvish, fish, powershell, zsh"],
    );
    let check = std::process::Command::new("bash")
        .arg("-n")
        .arg(folder.path("bash"))
        .output();
    if let Ok(check) = check {
        assert!(
            check.status.success(),
            "{}",
            String::from_utf8_lossy(&check.stderr)
        );
    }
}

#[test]
fn the_version_is_the_package_s() {
    let version = format!("palpate {}\n", env!("CARGO_PKG_VERSION"));
    assert_eq!(Folder::new().succeed("--version"), version);
    assert_eq!(Folder::new().succeed("-V"), version);
}

#[test]
fn what_is_not_known_is_answered_by_what_is() {
    let folder = Folder::new();
    folder.fail("rendr", 2, &["rendr", "'render'"]);
    folder.fail(
        "render x.csv --stifness 4",
        2,
        &["--stifness", "'--stiffness'"],
    );
    folder.fail("paper figure fig7", 2, &["fig7", "fig5"]);
    folder.fail("simulate", 2, &["<SCENE.toml>"]);
    folder.fail("devices --json emulate inverse3", 2, &["emulate"]);
    folder.fail("render", 2, &["<TRACE.csv>"]);
    folder.fail(
        "render x.csv --mass 1 --mass 2",
        2,
        &["--mass", "multiple times"],
    );
}

#[test]
fn without_arguments_the_help_is_shown() {
    let answer = Folder::new().palpate("");
    assert_eq!((answer.code, answer.stdout.as_str()), (2, ""));
    assert!(
        answer.stderr.contains("Usage: palpate <COMMAND>"),
        "{answer:?}"
    );
}

#[test]
fn work_over_a_second_is_silent_without_a_terminal() {
    let folder = Folder::new();
    folder.write("long.csv", trace_text(&taps(0.001, 6.0)));
    let arguments = "render long.csv --stiffness 400 --mass 0.1 --period 0.001 --method all";
    let table = folder.succeed(&format!("{arguments} --out run.csv --plot run.svg"));
    assert!(!table.contains('\x1b') && !table.contains('\r'), "{table}");
}
