//! Standard input and output instead of files.

use crate::common::{Folder, parse, taps, trace_text};

const FLAGS: &str = "--stiffness 400 --mass 0.1 --period 0.01 --force -0.981";

fn with_taps() -> Folder {
    let folder = Folder::new();
    folder.write("tap.csv", trace_text(&taps(0.001, 1.5)));
    folder
}

#[test]
fn standard_input_gives_the_run_of_the_file() {
    let folder = with_taps();
    let text = folder.read("tap.csv");
    let of_file = folder.palpate(&format!("render tap.csv {FLAGS} --out -"));
    let of_input = folder.palpate_reading(&text, &format!("render - {FLAGS} --out -"));
    assert_eq!((of_file.code, of_input.code), (0, 0));
    let ticks = |text: &str| {
        let run = palpate_record::run::read(text.as_bytes(), "run").unwrap();
        (
            run.numbers("t_s").unwrap(),
            run.numbers("force_on_object_n").unwrap(),
        )
    };
    assert_eq!(ticks(&of_file.stdout), ticks(&of_input.stdout));
    assert!(
        of_input.stderr.contains("standard input"),
        "{}",
        of_input.stderr
    );
}

#[test]
fn ticks_on_standard_output_leave_the_report_to_standard_error() {
    let folder = with_taps();
    folder.succeed(&format!("render tap.csv {FLAGS} --out run.csv"));
    let answer = folder.palpate(&format!("render tap.csv {FLAGS} --out -"));
    assert_eq!(answer.code, 0);
    assert_eq!(answer.stdout, folder.read("run.csv"));
    assert!(answer.stderr.contains("FRE %"), "{}", answer.stderr);
    let answer = folder.palpate(&format!("render tap.csv {FLAGS} --out - --json"));
    assert_eq!(answer.stdout, folder.read("run.csv"));
    assert_eq!(parse(&answer.stderr)["format"], "palpate report 1");
}

#[test]
fn the_reader_of_standard_output_may_leave() {
    let folder = Folder::new();
    folder.write("tap.csv", trace_text(&taps(0.001, 20.0)));
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_palpate"))
        .current_dir(folder.path("."))
        .args(format!("render tap.csv {FLAGS} --method all --out -").split_whitespace())
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{stderr}");
    assert!(!stderr.contains("panicked"), "{stderr}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_standard_output_is_a_failure_of_help_too() {
    for arguments in ["--help", "simulate --help", "--version", "completions bash"] {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full");
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_palpate"))
            .args(arguments.split_whitespace())
            .stdout(full.unwrap())
            .output()
            .unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{arguments}: {said}");
        assert!(
            said.contains("standard output cannot be written: No space left"),
            "{arguments}: {said}"
        );
    }
}
