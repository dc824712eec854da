//! `palpate devices emulate haply-2diy`.

pub mod arguments;
#[cfg(unix)]
mod board_and_arm;

use self::arguments::TwoDiyArguments;
use crate::failure::Failure;

/// Emulates until the end.
#[cfg(unix)]
pub fn run(arguments: &TwoDiyArguments) -> Result<(), Failure> {
    board_and_arm::run(arguments)
}

/// Fails, because emulation needs Unix.
#[cfg(not(unix))]
pub fn run(_: &TwoDiyArguments) -> Result<(), Failure> {
    Err(Failure::System(
        "this emulator needs pseudo-terminals, of Linux or macOS".into(),
    ))
}
