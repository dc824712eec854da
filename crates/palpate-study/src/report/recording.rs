//! The replayed recording of a report.

use std::fmt;

use serde::Serialize;

use crate::text::{counted, digits};

/// A recording: its content and its losses.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct FromRecording {
    /// File of the recording.
    pub file: String,
    /// Method of the scene in the recording's metadata.
    pub recorded_method: &'static str,
    /// Whether the recording is intact and contains as many ticks as the loop counted.
    pub complete: bool,
    /// Number of recorded ticks.
    pub ticks: u64,
    /// Number of ticks missing in the recording.
    pub ticks_lost: u64,
    /// Number of ticks without a position to replay.
    pub ticks_without_position: u64,
    /// Number of parameter changes during the recording; the replay does not repeat them.
    pub parameter_changes: u32,
    /// Strongest sent force `[N]`.
    pub recorded_peak_force_n: f64,
    /// Leak of the held force in the energy ledger of the recorded loop `[J]`.
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
            write!(f, "; {count} of parameters, not repeated here")?;
        }
        Ok(())
    }
}
