//! The program `palpate`: arguments in, files and reports out. The physics is in the libraries.
//!
//! It is a library with one function, not only a program, because of the build: cargo compiles a library
//! as soon as it knows the types of what it depends on, and a program only once all of that is compiled.

mod arguments;
mod command_line;
mod commands;
mod devices;
mod excerpt;
mod failure;
mod hand;
mod inside;
mod progress;
mod recorded;
mod results;
mod run_file;
#[cfg(test)]
mod schemas;
mod setup;
mod values;
mod worlds;

use std::process::ExitCode;

use clap::{CommandFactory, Parser};

use command_line::{Arguments, Command};

/// Does what the arguments of this process ask for, and says how it ended: the exit code.
#[must_use]
pub fn run() -> ExitCode {
    let outcome = match Arguments::parse().command {
        Command::Render(arguments) => commands::render::run(&arguments),
        Command::Simulate(arguments) => commands::simulate::run(&arguments),
        Command::Compare(arguments) => commands::compare::run(&arguments),
        Command::Pipe(arguments) => commands::pipe::run(&arguments),
        Command::Calibrate(arguments) => commands::calibrate::run(&arguments),
        Command::Run(arguments) => commands::run::run(&arguments),
        Command::Record(arguments) => commands::run::record(&arguments),
        Command::Live(arguments) => commands::live::run(&arguments),
        Command::Devices(arguments) => commands::devices::run(&arguments),
        Command::Emulate(arguments) => commands::emulate::run(&arguments),
        Command::Guardian => commands::guardian::run(),
        Command::Doctor(arguments) => commands::doctor::run(&arguments),
        Command::Report(arguments) => commands::report::run(&arguments),
        Command::Bench(arguments) => commands::bench::run(&arguments),
        Command::Info(arguments) => commands::info::run(&arguments),
        Command::Convert(arguments) => commands::convert::run(&arguments),
        Command::Replay(arguments) => commands::replay::run(&arguments),
        Command::Tune(arguments) => commands::tune::run(&arguments),
        Command::Suite(arguments) => commands::suite::run(&arguments),
        Command::Heights(arguments) => commands::heights::run(&arguments),
        Command::Sweep(arguments) => commands::sweep::run(&arguments),
        Command::Claims(arguments) => commands::claims::run(&arguments),
        Command::Map(arguments) => commands::map::run(&arguments),
        Command::Advise(arguments) => commands::advise::run(&arguments),
        Command::Figure(arguments) => commands::figure::run(&arguments),
        Command::Demo(arguments) => commands::demo::run(&arguments),
        Command::Completions(arguments) => {
            commands::completions::run(&arguments, &mut Arguments::command())
        }
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}
