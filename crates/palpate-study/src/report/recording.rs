//! What a report says of the recording that was replayed.

use std::fmt;

use serde::Serialize;

use crate::text::{counted, digits};

/// A recording: what is in it, and what is not.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct FromRecording {
    /// Its file.
    pub file: String,
    /// Method of the scene in its receipt.
    pub recorded_method: &'static str,
    /// Whether it is whole and holds as many ticks as the loop counted.
    pub complete: bool,
    /// Ticks that it has.
    pub ticks: u64,
    /// Ticks that it has not.
    pub ticks_lost: u64,
    /// Ticks that have no position to replay.
    pub ticks_without_position: u64,
    /// Changes of parameters while it was made, none of which the replay makes.
    pub parameter_changes: u32,
    /// Strongest force that was sent `[N]`.
    pub recorded_peak_force_n: f64,
    /// Leak of the held force, as the recorded loop booked it `[J]`.
    pub recorded_leak_held_j: f64,
}

impl fmt::Display for FromRecording {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "recorded by {} in {}: peak {} N, leak {} mJ",
            self.recorded_method,
            counted(self.ticks, "tick"),
            digits(self.recorded_peak_force_n),
            digits(1e3 * self.recorded_leak_held_j),
        )?;
        if self.ticks_lost > 0 {
            write!(f, "; {} lost", counted(self.ticks_lost, "tick"))?;
        }
        if self.ticks_without_position > 0 {
            let count = counted(self.ticks_without_position, "tick");
            write!(f, "; {count} without a position")?;
        }
        if self.parameter_changes > 0 {
            let count = counted(self.parameter_changes, "change");
            write!(f, "; {count} of parameters, not made here")?;
        }
        Ok(())
    }
}
