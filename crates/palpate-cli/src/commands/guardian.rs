//! `palpate guardian`: what takes the force off a device when its loop can not. Started by commands
//! that run a loop, and by nobody else.

use crate::failure::Failure;

/// Watches until it is dismissed, or the loop is gone.
#[cfg(unix)]
pub fn run() -> Result<(), Failure> {
    palpate_rt::guardian::serve().map_err(|error| {
        Failure::System(format!(
            "{error}; a guardian is started by `palpate run`, `record` and `live`"
        ))
    })
}

/// No device here needs one.
#[cfg(not(unix))]
pub fn run() -> Result<(), Failure> {
    Err(Failure::System("a guardian needs Linux or macOS".into()))
}
