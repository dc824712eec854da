//! `palpate render` with errors in the trace, the flags, or the output path.

use crate::common::{Folder, taps, trace_text};

const FLAGS: &str = "--stiffness 400 --mass 0.1 --period 0.01";

#[test]
fn a_fault_of_the_trace_is_shown_in_its_line_and_column() {
    let cases: [(&[u8], &str, &str); 12] = [
        (b"time,position_m\n0,0\n1,0\n", "1:1", "no column `t_s`"),
        (b"t_s,x\n0,0\n1,0\n", "1:1", "no column `position_m`"),
        (b"t_s,position_m\n0,0\n0.01,nan\n", "3:6", "not finite"),
        (b"t_s,position_m\n0,0\n0.01,inf\n", "3:6", "not finite"),
        (b"t_s,position_m\n0,0\n0.01,1 mm\n", "3:6", "not a number"),
        (
            b"t_s,position_m\n0,0\n0.01,0\n0.01,0\n",
            "4:1",
            "must increase",
        ),
        (
            b"t_s,position_m\n0,0\n0.01\n",
            "3:1",
            "1 fields, the header 2",
        ),
        (
            b"t_s,position_m\n0,0\n0.01,\xff\n",
            "3:6",
            "0xFF is not UTF-8",
        ),
        (b"", "1:1", "empty"),
        (b"t_s,position_m\n", "1:15", "at least 2 samples"),
        (b"t_s,position_m\n0,0\n", "2:4", "at least 2 samples"),
        (b"t_s,position_m,t_s\n0,0,0\n", "1:16", "`t_s` twice"),
    ];
    let folder = Folder::new();
    for (text, place, fault) in cases {
        folder.write("bad.csv", text);
        let place = format!("error: bad.csv:{place}: ");
        folder.fail(&format!("render bad.csv {FLAGS}"), 3, &[&place, fault]);
        let from_input = folder.palpate_reading(text, &format!("render - {FLAGS}"));
        let place = place.replace("bad.csv", "standard input");
        from_input.failed("the same from standard input", 3, &[&place, fault]);
    }
}

#[test]
fn the_line_at_fault_is_drawn() {
    let folder = Folder::new();
    folder.write("bad.csv", "t_s,position_m\n0,0\n0.01,oops\n");
    let drawing = [
        "bad.csv:3:6\n",
        "2 │ 0,0\n3 │ 0.01,oops\n",
        "  ╰╴     ━━━━ here",
    ];
    folder.fail(&format!("render bad.csv {FLAGS}"), 3, &drawing);
}

#[test]
fn a_recording_shorter_than_a_period_is_refused() {
    let folder = Folder::new();
    folder.write("short.csv", "t_s,position_m\n0,0\n0.005,0\n");
    let words = ["short.csv: ", "lasts 0.005 s", "period of 0.01 s"];
    folder.fail(&format!("render short.csv {FLAGS}"), 3, &words);
}

#[test]
fn a_period_that_would_fill_the_memory_is_refused() {
    let folder = Folder::new();
    folder.write("tap.csv", trace_text(&taps(0.01, 2.0)));
    folder.fail(
        "render tap.csv --stiffness 400 --mass 0.1 --period 1e-12",
        2,
        &["--period is too short", "at most 2000000 are allowed"],
    );
}

#[test]
fn a_trace_that_is_not_there_or_no_file_is_a_failure_of_the_system() {
    let folder = Folder::new();
    folder.fail(
        &format!("render no.csv {FLAGS}"),
        1,
        &["no.csv: ", "No such file"],
    );
    std::fs::create_dir(folder.path("folder")).unwrap();
    folder.fail(&format!("render folder {FLAGS}"), 1, &["folder: "]);
}

#[test]
fn a_result_without_a_place_to_go_says_so() {
    let folder = Folder::new();
    folder.write("tap.csv", trace_text(&taps(0.01, 0.5)));
    let render = format!("render tap.csv {FLAGS}");
    let missing = ["cannot write `no/run.csv`", "no directory `no`"];
    folder.fail(&format!("{render} --out no/run.csv"), 1, &missing);
    let missing = ["cannot write `no/run.svg`", "no directory `no`"];
    folder.fail(&format!("{render} --plot no/run.svg"), 1, &missing);
    folder.fail(&format!("{render} --out ."), 1, &["cannot write `.`"]);
    assert_eq!(folder.names(), ["tap.csv"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_named() {
    let folder = Folder::new();
    folder.write("tap.csv", trace_text(&taps(0.01, 0.5)));
    let words = ["cannot write `/dev/full`", "no space left"];
    folder.fail(
        &format!("render tap.csv {FLAGS} --out /dev/full"),
        1,
        &words,
    );
}

#[test]
fn a_figure_has_a_name_that_says_its_format() {
    let folder = Folder::new();
    folder.write("tap.csv", trace_text(&taps(0.01, 0.5)));
    for name in ["run.gif", "run", "-"] {
        let render = format!("render tap.csv {FLAGS} --out run.csv --plot {name}");
        folder.fail(&render, 2, &[name, ".svg, .pdf or .png"]);
    }
    assert_eq!(
        folder.names(),
        ["tap.csv"],
        "nothing is written before the name is checked"
    );
}

#[cfg(not(feature = "png"))]
#[test]
fn a_build_without_png_says_how_to_get_it() {
    let folder = Folder::new();
    folder.write("tap.csv", trace_text(&taps(0.01, 0.5)));
    let words = ["run.png", "--features png"];
    folder.fail(&format!("render tap.csv {FLAGS} --plot run.png"), 2, &words);
}

#[cfg(feature = "png")]
#[test]
fn a_build_with_png_draws_one() {
    let folder = Folder::new();
    folder.write("tap.csv", trace_text(&taps(0.01, 0.5)));
    folder.succeed(&format!("render tap.csv {FLAGS} --plot run.png"));
    let bytes = std::fs::read(folder.path("run.png")).unwrap();
    assert!(bytes.starts_with(b"\x89PNG\r\n\x1a\n") && bytes.len() > 10_000);
}

#[test]
fn what_stood_there_before_survives_a_run_that_fails() {
    let folder = Folder::new();
    folder.write("bad.csv", "t_s,position_m\n0,0\n0,0\n");
    folder.write("good.csv", trace_text(&taps(0.01, 0.5)));
    folder
        .write("run.csv", "precious")
        .write("run.svg", "precious too");
    let outputs = "--out run.csv --plot run.svg --overwrite";
    folder.fail(&format!("render bad.csv {FLAGS} {outputs}"), 3, &[]);
    folder.fail(&format!("render no.csv {FLAGS} {outputs}"), 1, &[]);
    folder.fail(
        &format!("render good.csv {FLAGS} --damping -1 {outputs}"),
        2,
        &[],
    );
    assert_eq!(folder.read("run.csv"), "precious");
    assert_eq!(folder.read("run.svg"), "precious too");
    assert_eq!(
        folder.names(),
        ["bad.csv", "good.csv", "run.csv", "run.svg"]
    );
    folder.succeed(&format!("render good.csv {FLAGS} {outputs}"));
    assert!(
        folder.read("run.csv").starts_with("t_s,"),
        "a run that works replaces it"
    );
    assert_eq!(
        folder.names(),
        ["bad.csv", "good.csv", "run.csv", "run.svg"]
    );
}

#[test]
fn the_recording_is_never_overwritten_by_its_run() {
    let folder = Folder::new();
    let text = trace_text(&taps(0.01, 0.5));
    folder.write("tap.csv", &text);
    for out in ["tap.csv", "./tap.csv"] {
        let words = ["--out", "overwrite", "tap.csv"];
        folder.fail(&format!("render tap.csv {FLAGS} --out {out}"), 2, &words);
    }
    assert_eq!(folder.read("tap.csv"), text);
}

#[test]
fn what_spreadsheets_write_is_read_as_the_same_motion() {
    let folder = Folder::new();
    let text = trace_text(&taps(0.001, 0.5));
    let swapped: String = text
        .lines()
        .map(|line| {
            let (t, x) = line.split_once(',').unwrap();
            format!("{x},{t},\"a note\"\n")
        })
        .collect();
    let variants = [
        ("crlf", text.replace('\n', "\r\n")),
        ("mark", format!("\u{feff}{text}")),
        ("both", format!("\u{feff}{}", text.replace('\n', "\r\n"))),
        ("comments", format!("# by hand\n\n{text}")),
        ("columns", swapped),
        ("semicolons", text.replace(',', ";")),
        ("tabs", text.replace(',', "\t")),
        ("units", text.replacen('\n', "\ns,m\n", 1)),
    ];
    folder.write("plain.csv", &text);
    let run = |name: &str| {
        folder.succeed(&format!("render {name} {FLAGS} --out run.csv --overwrite"));
        folder
            .run_file("run.csv")
            .numbers("force_on_object_n")
            .unwrap()
    };
    let plain = run("plain.csv");
    assert!(plain.iter().any(|&force| force > 0.1));
    for (name, variant) in variants {
        folder.write(name, variant);
        assert_eq!(run(name), plain, "{name}");
    }
}
