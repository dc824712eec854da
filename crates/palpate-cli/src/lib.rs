#![doc = include_str!("../README.md")]
//!
//! # Overview
//!
//! The program `palpate`: arguments in, files and reports out. The physics is in the libraries.
//!
//! The program is a library to shorten the build: cargo compiles a library as soon as the types of
//! its dependencies are known, and a program only after all of them are compiled.

mod arguments;
mod command_line;
mod commands;
mod devices;
mod excerpt;
mod failure;
mod help;
mod inside;
mod pipe;
mod progress;
mod recorded;
mod reports;
mod results;
mod run_file;
#[cfg(test)]
mod schemas;
mod seeds;
mod setup;
mod values;
mod worlds;

use std::io::{self, Write};
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches};

use command_line::{Arguments, Command};

/// Runs the command in the arguments of this process. Returns its exit code.
#[must_use]
pub fn run() -> ExitCode {
    let given = command_line()
        .try_get_matches()
        .and_then(|matches| Arguments::from_arg_matches(&matches))
        .map_err(|error| error.format(&mut command_line()));
    let given = match given {
        Ok(given) => given,
        Err(error) => return print(&error),
    };
    let outcome = match given.command {
        Command::Render(arguments) => commands::render::run(&arguments),
        Command::Simulate(arguments) => commands::simulate::run(&arguments),
        Command::Compare(arguments) => commands::compare::run(&arguments),
        Command::Pipe(arguments) => commands::pipe::run(&arguments),
        Command::Calibrate(arguments) => commands::calibrate::run(&arguments),
        Command::Run(arguments) => commands::run::run(&arguments),
        Command::Live(arguments) => commands::live::run(&arguments),
        Command::Devices(arguments) => commands::devices::run(&arguments),
        Command::Watchdog => commands::watchdog::run(),
        Command::Doctor(arguments) => commands::doctor::run(&arguments),
        Command::Report(arguments) => commands::report::run(&arguments),
        Command::Info(arguments) => commands::info::run(&arguments),
        Command::Convert(arguments) => commands::convert::run(&arguments),
        Command::Replay(arguments) => commands::replay::run(&arguments),
        Command::Tune(arguments) => commands::tune::run(&arguments),
        Command::Suite(arguments) => commands::suite::run(&arguments),
        Command::Sweep(arguments) => commands::sweep::run(&arguments),
        Command::Map(arguments) => commands::map::run(&arguments),
        Command::Advise(arguments) => commands::advise::run(&arguments),
        Command::Paper(arguments) => commands::paper::run(&arguments),
        Command::Demo(arguments) => commands::demo::run(&arguments),
        Command::Completions(arguments) => {
            commands::completions::run(&arguments, &mut command_line())
        }
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}

/// Prints the help, the version or an error of the command line. Returns its exit code.
fn print(error: &clap::Error) -> ExitCode {
    match results::written(error.print().and_then(|()| io::stdout().flush())) {
        Ok(()) => ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2)),
        Err(failure) => failure.report(),
    }
}

/// Returns the command line. Its help lists the commands in groups. Numeric options accept negative numbers, so that
/// their checks can report the allowed values.
#[must_use]
pub fn command_line() -> clap::Command {
    taking_numbers_below_zero(help::in_groups(Arguments::command()))
}

fn taking_numbers_below_zero(command: clap::Command) -> clap::Command {
    let command = command.mut_args(|argument| {
        if argument.get_action().takes_values() && !argument.is_positional() {
            argument.allow_negative_numbers(true)
        } else {
            argument
        }
    });
    command.mut_subcommands(taking_numbers_below_zero)
}

#[cfg(test)]
mod tests {
    use clap::error::ErrorKind;

    use super::*;

    /// Collects the error of each option of `command`, called by these words, for the value -1.
    fn said_of_minus_one(command: &clap::Command, words: &[String], take: &mut dyn FnMut(String)) {
        let takes =
            |option: &&clap::Arg| option.get_action().takes_values() && !option.is_positional();
        for option in command.get_arguments().filter(takes) {
            let Some(long) = option.get_long() else {
                continue;
            };
            let asked = words.iter().cloned();
            let asked = asked.chain([format!("--{long}"), "-1".to_owned()]);
            let Err(error) = command_line().try_get_matches_from(asked) else {
                continue;
            };
            assert_ne!(
                error.kind(),
                ErrorKind::UnknownArgument,
                "{words:?}: {error}"
            );
            if error.kind() == ErrorKind::ValueValidation {
                take(error.to_string());
            }
        }
        for sub in command.get_subcommands() {
            let mut words = words.to_vec();
            words.push(sub.get_name().to_owned());
            said_of_minus_one(sub, &words, take);
        }
    }

    #[test]
    fn an_option_that_refuses_a_number_below_zero_names_what_is_allowed() {
        let mut refused = 0;
        said_of_minus_one(&command_line(), &["palpate".to_owned()], &mut |said| {
            refused += 1;
            // The message of a parser of unsigned numbers.
            assert!(!said.contains("invalid digit"), "{said}");
        });
        assert!(refused > 20, "{refused}");
    }
}
