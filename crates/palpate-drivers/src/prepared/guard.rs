//! Watchdog process of a device that holds its last force.

use std::process::Command;
use std::sync::Arc;
use std::time::Duration;

use palpate_rt::watchdog::WatchdogAccount;

/// Watchdog process of a device that holds its last force: only another process can remove the force after the program
/// is killed or stopped.
#[derive(Debug)]
pub struct Guard {
    /// Command that runs [`palpate_rt::watchdog::serve`].
    pub command: Command,
    /// Maximum time without a message from the loop while a force is on.
    pub limit: Duration,
    /// Record of the watchdog's actions.
    pub account: Arc<WatchdogAccount>,
}
