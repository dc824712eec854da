//! `palpate completions`: completion scripts for shells.

use clap::CommandFactory;

use crate::arguments::{Arguments, CompletionArguments};
use crate::failure::Failure;
use crate::results::print;

/// Prints the script of a shell.
pub fn run(arguments: &CompletionArguments) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(
        arguments.shell,
        &mut Arguments::command(),
        "palpate",
        &mut script,
    );
    print(&String::from_utf8_lossy(&script))
}
