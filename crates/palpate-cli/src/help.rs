//! The help of the program, which lists the commands in groups.

use std::fmt::Write as _;

use clap::Command;

/// The groups of commands: the heading of each, and the names of its commands in the order of the list.
const GROUPS: [(&str, &[&str]); 4] = [
    ("Try and compare", &["demo", "simulate", "compare", "sweep"]),
    ("Recordings", &["render", "replay", "info", "convert"]),
    (
        "Devices",
        &[
            "devices",
            "doctor",
            "run",
            "live",
            "pipe",
            "calibrate",
            "report",
        ],
    ),
    (
        "Tuning and studies",
        &["tune", "advise", "map", "suite", "paper"],
    ),
];

/// Replaces the list of commands in the help of `program` by a list in groups.
///
/// # Panics
/// A group has a name that is not a command.
pub fn in_groups(program: Command) -> Command {
    let mut template = String::from("{about-with-newline}\n{usage-heading} {usage}");
    let (header, literal) = (
        program.get_styles().get_header(),
        program.get_styles().get_literal(),
    );
    let names = GROUPS.iter().flat_map(|(_, names)| *names);
    let width = names.map(|name| name.len()).max().unwrap_or(0);
    for (heading, names) in GROUPS {
        // Writing to a string cannot fail.
        let _ = write!(template, "\n\n{header}{heading}:{header:#}");
        for name in names {
            let command = program
                .find_subcommand(name)
                .expect("it is the name of a command");
            let about = command
                .get_about()
                .map(ToString::to_string)
                .unwrap_or_default();
            let _ = write!(template, "\n  {literal}{name:<width$}{literal:#}  {about}");
        }
    }
    template.push_str("{after-help}");
    program.help_template(template)
}
