//! `palpate watchdog`: the watchdog process, which disables the output of a device if its loop cannot. Only commands
//! that run a loop start it.

use crate::failure::Failure;

/// Watches until it is dismissed or the loop has ended.
#[cfg(unix)]
pub fn run() -> Result<(), Failure> {
    palpate_rt::watchdog::serve().map_err(|error| {
        Failure::System(format!(
            "{error}; a watchdog is started by `palpate run` and `palpate live`"
        ))
    })
}

/// No supported device here needs a watchdog process.
#[cfg(not(unix))]
pub fn run() -> Result<(), Failure> {
    Err(Failure::System("a watchdog needs Linux or macOS".into()))
}
