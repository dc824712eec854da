//! The list of the commands in the help of the program.

use crate::common::Folder;

/// The commands in the list of a help text, in its order, each with its description.
fn listed(help: &str) -> Vec<(String, String)> {
    let (_, list) = help.split_once("Usage: palpate <COMMAND>\n").unwrap();
    let (list, _) = list.split_once("\npalpate help <COMMAND>").unwrap();
    let mut commands = Vec::new();
    for line in list.lines().filter(|line| !line.is_empty()) {
        let Some(entry) = line.strip_prefix("  ") else {
            assert!(
                line.ends_with(':'),
                "neither a heading nor a command: {line}"
            );
            continue;
        };
        let (name, about) = entry.split_once(' ').unwrap();
        commands.push((name.to_owned(), about.trim_start().to_owned()));
    }
    commands
}

#[test]
fn the_groups_contain_every_command_once_and_nothing_else() {
    let program = palpate_cli::command_line();
    let shown = program.get_subcommands().filter(|it| !it.is_hide_set());
    let mut expected: Vec<(String, String)> = shown
        .map(|it| {
            (
                it.get_name().to_owned(),
                it.get_about().unwrap().to_string(),
            )
        })
        .collect();
    let mut found = listed(&Folder::new().succeed("--help"));
    expected.sort();
    found.sort();
    assert_eq!(found, expected);
}

#[test]
fn the_help_fits_one_screen() {
    let folder = Folder::new();
    let help = folder.succeed("--help");
    assert!(
        help.lines().count() <= 45,
        "{} lines:\n{help}",
        help.lines().count()
    );
    let widest = help.lines().map(|line| line.chars().count()).max();
    assert!(widest <= Some(80), "{widest:?} columns:\n{help}");
    for same in ["-h", "help"] {
        assert_eq!(folder.succeed(same), help, "palpate {same}");
    }
    assert_eq!(folder.palpate("").stderr, help);
}

#[test]
fn hidden_commands_can_be_called() {
    let program = palpate_cli::command_line();
    let hidden = program.get_subcommands().filter(|it| it.is_hide_set());
    let hidden: Vec<&str> = hidden.map(clap::Command::get_name).collect();
    assert_eq!(hidden, ["watchdog", "completions"]);
    let folder = Folder::new();
    for name in hidden {
        let help = folder.succeed(&format!("{name} --help"));
        assert!(help.contains(&format!("Usage: palpate {name}")), "{help}");
    }
}
