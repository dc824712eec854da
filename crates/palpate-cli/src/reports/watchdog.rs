//! Watchdog processes of devices that hold their last force.

use std::time::Duration;

use palpate_device::Capabilities;
#[cfg(unix)]
use palpate_rt::watchdog::Unguarded;
use serde::Serialize;

/// Watchdog settings of a session and their results.
#[derive(Clone, Debug)]
pub struct Guarding {
    /// Maximum silence of the loop while a force is on.
    pub limit: Duration,
    /// Results of the watchdog processes.
    #[cfg(unix)]
    pub account: std::sync::Arc<palpate_rt::watchdog::WatchdogAccount>,
}

/// Report on the watchdog process of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct WatchdogReport {
    /// Whether a watchdog process ran.
    on: bool,
    /// Maximum silence of the loop `[s]`.
    silence_s: Option<f64>,
    /// Whether the watchdog process had the highest real-time priority.
    first: Option<bool>,
    /// Number of zero-force commands by the watchdog process.
    cuts: u64,
    /// Whether the watchdog process was lost before the device was closed.
    gone: bool,
    /// Kind of loss: `ended` or `not-listening`.
    lost: Option<&'static str>,
    #[serde(skip)]
    lost_in_words: Option<&'static str>,
}

impl Guarding {
    /// Creates settings of watchdog processes that command zero force after `limit` of silence.
    #[must_use]
    pub fn new(limit: Duration) -> Self {
        Self {
            limit,
            #[cfg(unix)]
            account: std::sync::Arc::default(),
        }
    }

    /// Returns how a watchdog process was lost before its device was closed, as a key and a sentence. Returns `None`
    /// if none was lost.
    #[must_use]
    pub fn lost(&self) -> Option<(&'static str, &'static str)> {
        #[cfg(unix)]
        let lost = self.account.lost().map(|how| match how {
            Unguarded::Ended => ("ended", "the watchdog ended"),
            Unguarded::NotListening => (
                "not-listening",
                "the watchdog does not respond and may be suspended",
            ),
        });
        #[cfg(not(unix))]
        let lost = None;
        lost
    }

    /// Returns one report for several devices. Returns `None` if no device holds its last force.
    #[must_use]
    pub fn report_of(&self, on: bool, devices: &[&Capabilities]) -> Option<WatchdogReport> {
        let holds = devices.iter().find(|device| device.holds_last_force)?;
        self.report(on, holds)
    }

    /// Returns the report of a device; `on` states whether watchdog processes ran. Returns `None` if the device does
    /// not hold its last force.
    #[must_use]
    pub fn report(&self, on: bool, device: &Capabilities) -> Option<WatchdogReport> {
        if !device.holds_last_force {
            return None;
        }
        #[cfg(unix)]
        let (first, cuts) = (self.account.is_first(), self.account.cuts());
        #[cfg(not(unix))]
        let (first, cuts) = (false, 0);
        let lost = self.lost();
        Some(WatchdogReport {
            on,
            silence_s: on.then_some(self.limit.as_secs_f64()),
            first: on.then_some(first),
            cuts,
            gone: lost.is_some(),
            lost: lost.map(|(key, _)| key),
            lost_in_words: lost.map(|(_, words)| words),
        })
    }
}

impl std::fmt::Display for WatchdogReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Some(silence) = self.silence_s else {
            return write!(
                f,
                "watchdog: off as requested; the device holds its last force if this program is killed"
            );
        };
        write!(
            f,
            "watchdog: commands zero force after {} ms of silence; SCHED_FIFO, priority 99: {}",
            palpate_study::text::digits(1e3 * silence),
            if self.first == Some(true) {
                "granted"
            } else {
                "refused"
            }
        )?;
        if self.cuts > 0 {
            let times = palpate_study::text::counted(self.cuts, "time");
            write!(f, "\nthe watchdog commanded zero force {times}")?;
        }
        if let Some(lost) = self.lost_in_words {
            write!(f, "\n{lost}; the loop commanded zero force from then on")?;
        }
        Ok(())
    }
}
