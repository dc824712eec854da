//! The program `palpate`; all of it is in the library beside it.

use std::process::ExitCode;

fn main() -> ExitCode {
    palpate_cli::run()
}
