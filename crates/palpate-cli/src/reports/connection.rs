//! Connection to a device of another program.

use std::fmt;
use std::time::Duration;

use palpate_device::Connection;
use palpate_study::text::{counted, digits};
use serde::Serialize;

/// Messages from a device during a run. A sample that is not accepted counts as missing.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ConnectionReport {
    device: String,
    /// Number of accepted samples.
    samples: u64,
    /// Number of samples that never arrived.
    lost: u64,
    /// Number of samples that arrived too late.
    late: u64,
    /// Number of samples that arrived after a newer one.
    reordered: u64,
    /// Number of samples that arrived again.
    duplicate: u64,
    /// Number of invalid messages.
    unreadable: u64,
    /// Number of commands that the device did not take.
    untaken: u64,
    /// Time from a message to its answer.
    round_trip_s: Option<RoundTrip>,
}

/// Time from a message to its answer `[s]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct RoundTrip {
    median: f64,
    p99: f64,
    longest: f64,
}

impl ConnectionReport {
    /// Creates the report of the device called `name`.
    #[must_use]
    pub fn new(name: &str, connection: &Connection) -> Self {
        Self {
            device: name.to_owned(),
            samples: connection.samples,
            lost: connection.lost,
            late: connection.late,
            reordered: connection.reordered,
            duplicate: connection.duplicate,
            unreadable: connection.unreadable,
            untaken: connection.untaken,
            round_trip_s: connection.round_trip.map(|times| {
                let [median, p99, longest] = times.map(|time: Duration| time.as_secs_f64());
                RoundTrip {
                    median,
                    p99,
                    longest,
                }
            }),
        }
    }
}

impl fmt::Display for ConnectionReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "connection to `{}`: {}",
            self.device,
            counted(self.samples, "sample")
        )?;
        for (count, what) in [
            (self.lost, "lost"),
            (self.late, "late"),
            (self.reordered, "reordered"),
            (self.duplicate, "duplicate"),
            (self.unreadable, "unreadable"),
        ] {
            if count > 0 {
                write!(f, ", {count} {what}")?;
            }
        }
        if self.untaken > 0 {
            write!(f, "; {} not taken", counted(self.untaken, "command"))?;
        }
        if let Some(times) = self.round_trip_s {
            let [median, p99, longest] =
                [times.median, times.p99, times.longest].map(|time| digits(1e3 * time));
            write!(
                f,
                "; round trip {median} ms, 99 % {p99} ms, longest {longest} ms"
            )?;
        }
        Ok(())
    }
}
