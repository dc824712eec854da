//! The watchdog process of devices that hold their last force: this program in another process.

use std::io;
use std::os::unix::process::CommandExt;
use std::process::Command;

use palpate_drivers::prepared::Guard;

use crate::reports::Guarding;

/// Returns a watchdog process with these settings.
pub fn guard(guarding: &Guarding) -> io::Result<Guard> {
    Ok(Guard {
        command: command()?,
        limit: guarding.limit,
        account: guarding.account.clone(),
    })
}

/// Returns the command that starts this program as a watchdog process.
pub fn command() -> io::Result<Command> {
    // On Linux by a name that stays valid if a newer file replaces the program.
    let program = if cfg!(target_os = "linux") {
        "/proc/self/exe".into()
    } else {
        std::env::current_exe()?
    };
    let mut command = Command::new(program);
    command.arg0("palpate").arg("watchdog");
    Ok(command)
}
