//! The table of settings in the documentation says what the methods' own files say.

use std::{env, fs};

use palpate_core::all_settings;
use palpate_scene::method::{MethodName, Setting, SettingValues};

/// Returns a row for each setting; methods with the same description share a row.
fn rows() -> Vec<String> {
    let mut rows: Vec<(Vec<&str>, &Setting)> = Vec::new();
    for key in all_settings().map(|setting| setting.key) {
        for method in MethodName::ALL {
            let Some(setting) = method.setting(key) else {
                continue;
            };
            match rows.iter_mut().find(|(_, other)| *other == setting) {
                Some((methods, _)) => methods.push(method.name()),
                None => rows.push((vec![method.name()], setting)),
            }
        }
    }
    rows.iter()
        .map(|(methods, setting)| row(methods, setting))
        .collect()
}

fn row(methods: &[&str], setting: &Setting) -> String {
    let of = match methods {
        [method] => (*method).to_owned(),
        _ => "NAME".to_owned(),
    };
    let shared = match methods {
        [_] => String::new(),
        _ => format!("of `{}`: ", methods.join("`, `")),
    };
    let values = match setting.values {
        SettingValues::Number { range, .. } => format!("; {}", range.allowed()),
        SettingValues::NumberOrWord { range, words, .. } => {
            let words = words.join("\"`, `\"");
            format!("; {}, or `\"{words}\"`", range.allowed())
        }
        SettingValues::Words { words, earlier } => {
            let earlier: String = earlier
                .iter()
                .map(|(before, now)| format!(" (`{before}` is read as `{now}`)"))
                .collect();
            format!("; `{}`{earlier}", words.join("`, `"))
        }
        SettingValues::Switch => "; `true` or `false`".to_owned(),
    };
    let (key, help, default) = (setting.key, setting.help, setting.default);
    format!("| `methods.{of}.{key}` | {shared}{help}{values} | {default} |")
}

const PAGE: &str = "../../docs/reference/scene.md";

/// `PALPATE_WRITE_DOCS=1` writes the table between its marks.
#[test]
fn the_documented_settings_are_those_of_the_methods() {
    let page = fs::read_to_string(PAGE).expect("the page is there");
    let (before, rest) = page
        .split_once("<!-- settings -->\n")
        .expect("its first mark");
    let (table, after) = rest.split_once("<!-- end -->\n").expect("its last mark");
    let expected = format!(
        "| key | meaning | default |\n|---|---|---|\n{}\n",
        rows().join("\n")
    );
    if env::var_os("PALPATE_WRITE_DOCS").is_some() {
        let written = format!("{before}<!-- settings -->\n{expected}<!-- end -->\n{after}");
        fs::write(PAGE, written).expect("the page can be written");
    } else {
        assert_eq!(
            table, expected,
            "PALPATE_WRITE_DOCS=1 writes the table of {PAGE}"
        );
    }
}
