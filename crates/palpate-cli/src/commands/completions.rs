//! `palpate completions`: completion scripts for shells.

use crate::arguments::CompletionArguments;
use crate::failure::Failure;
use crate::results::print;

/// Prints the script of a shell for the command line `program`.
pub fn run(arguments: &CompletionArguments, program: &mut clap::Command) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, program, "palpate", &mut script);
    print(&String::from_utf8_lossy(&script))
}
