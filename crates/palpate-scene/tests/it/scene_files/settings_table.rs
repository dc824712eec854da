//! The table of settings in the documentation says what the methods' own files say.

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

#[test]
fn the_documented_settings_are_those_of_the_methods() {
    let documented = include_str!("../../../../../docs/reference/scene.md");
    let expected = rows();
    let said: Vec<_> = documented
        .lines()
        .filter(|line| line.starts_with("| `methods."))
        .collect();
    assert_eq!(
        said,
        expected,
        "docs/reference/scene.md should have these rows:\n{}\n",
        expected.join("\n")
    );
}
