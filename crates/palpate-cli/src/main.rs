//! The program `palpate`; its code is in the library of this crate.

use std::process::ExitCode;

fn main() -> ExitCode {
    palpate_cli::run()
}
