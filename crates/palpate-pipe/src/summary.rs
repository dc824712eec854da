//! What a pipe did, for its end.

use std::fmt;

use palpate::Ledger;
use palpate_rt::safety::{SafetyParams, Trip};
use serde::Serialize;

use palpate_study::text::{counted, digits};

use crate::number::millijoules;

/// Name and version of the JSON report.
const FORMAT: &str = "palpate pipe 1";

/// Message of a safety stop that stays: its reason, and the way out.
pub fn stop_in_words(limits: &SafetyParams, trip: Trip) -> String {
    let why = match trip {
        Trip::Oscillation => format!(
            "held forces created more than {} mJ within about {} s",
            digits(1e3 * limits.oscillation.energy),
            limits.oscillation.window
        ),
        other => other.to_string(),
    };
    format!(
        "safety stop: {why}; all forces are 0 from here on. Start the pipe again with a softer or more damped contact, a \
         shorter period or another method"
    )
}

/// What a pipe did, for its end.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
pub struct PipeSummary {
    #[cfg_attr(any(test, feature = "schema"), schemars(extend("const" = FORMAT)))]
    format: &'static str,
    /// Lines that were answered.
    pub samples: u64,
    /// Lines whose answer is 0 because they were no sample.
    pub refused: u64,
    /// Forces that a limit changed.
    pub limited: u64,
    /// Forces that were still coming in.
    pub softened: u64,
    /// Reason of the safety stop that has held the force at 0 since; none: there was none.
    pub safety_stop: Option<&'static str>,
    /// Changes that were made.
    pub changes: u64,
    /// Largest force; none: no limit.
    force_limit_n: Option<f64>,
    soft_start_s: f64,
    stored_energy_j: f64,
    port_work_j: f64,
    virtual_force_work_j: f64,
    outside_work_j: f64,
    leak_original_j: f64,
    /// Energy that held forces created, if the loop is as modelled (delay, lag, gain).
    leak_held_j: f64,
    /// By how much later than told the commands begin, by what the method has learned; 0 where it learns nothing of
    /// it.
    learned_lateness_s: f64,
}

impl PipeSummary {
    /// Nothing has been done yet.
    #[must_use]
    pub fn new(force_limit_n: Option<f64>, soft_start_s: f64) -> Self {
        Self {
            format: FORMAT,
            samples: 0,
            refused: 0,
            limited: 0,
            softened: 0,
            safety_stop: None,
            changes: 0,
            force_limit_n,
            soft_start_s,
            stored_energy_j: 0.0,
            port_work_j: 0.0,
            virtual_force_work_j: 0.0,
            outside_work_j: 0.0,
            leak_original_j: 0.0,
            leak_held_j: 0.0,
            learned_lateness_s: 0.0,
        }
    }

    /// The same with the books.
    #[must_use]
    pub fn with_books(&self, ledger: &Ledger<f64>) -> Self {
        Self {
            stored_energy_j: ledger.stored,
            port_work_j: ledger.port_work,
            virtual_force_work_j: ledger.virtual_force_work,
            outside_work_j: ledger.outside_work,
            leak_original_j: ledger.original_leak.accumulated,
            leak_held_j: ledger.held_leak.accumulated,
            ..self.clone()
        }
    }
}

impl PipeSummary {
    /// The same, with the lateness of commands that was learned `[s]`.
    #[must_use]
    pub fn with_learned_lateness(self, learned_lateness_s: f64) -> Self {
        Self {
            learned_lateness_s,
            ..self
        }
    }
}

impl fmt::Display for PipeSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}, {} refused, {} limited; leak {} if the loop is as modelled, the spring force alone would have leaked {}",
            counted(self.samples, "sample"),
            self.refused,
            counted(self.limited, "force"),
            millijoules(self.leak_held_j),
            millijoules(self.leak_original_j),
        )?;
        if let Some(reason) = self.safety_stop {
            write!(f, "; safety stop: {reason}")?;
        }
        if self.changes > 0 {
            write!(f, "; {} made", counted(self.changes, "change"))?;
        }
        if self.learned_lateness_s != 0.0 {
            let than = if self.learned_lateness_s < 0.0 {
                "earlier"
            } else {
                "later"
            };
            let milliseconds = digits(1e3 * self.learned_lateness_s.abs());
            write!(
                f,
                "; learned: commands begin {milliseconds} ms {than} than told"
            )?;
        }
        Ok(())
    }
}
