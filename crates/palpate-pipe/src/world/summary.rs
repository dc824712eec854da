//! What a pipe of a world did, for its end.

use std::fmt;

use palpate_study::text::counted;
use palpate_world::Books;
use serde::Serialize;

use crate::number::millijoules;

/// Name and version of the JSON report.
const FORMAT: &str = "palpate world pipe 1";

/// What a pipe of a world did, for its end.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
pub struct WorldSummary {
    #[cfg_attr(any(test, feature = "schema"), schemars(extend("const" = FORMAT)))]
    format: &'static str,
    /// Lines that were answered.
    pub samples: u64,
    /// Lines whose answer is 0 because they were no sample.
    pub refused: u64,
    /// Lines with a force that a limit changed.
    pub limited: u64,
    /// Lines with a force that exceeded the guard's bound.
    pub guarded: u64,
    /// Lines with a force that was still coming in.
    pub softened: u64,
    /// How often a tool or body went through a solid and came out of its far side.
    pub went_through: u64,
    /// Reason of the safety stop that has held all forces at 0 since; none: there was none.
    pub safety_stop: Option<&'static str>,
    /// Largest force on each device; none: no limit.
    force_limit_n: Option<f64>,
    /// Largest torque on each device that turns; none: no limit, or no such device.
    torque_limit_n_m: Option<f64>,
    soft_start_s: f64,
    /// Energy that friction and damping of all contacts and joints took.
    dissipated_j: f64,
    /// Work of the held forces on the hands.
    port_work_j: f64,
    /// Energy that held forces created, if the loop is as modelled (delay, lag, gain): what hands, bodies, contacts and dissipation have gained together;
    /// without intervals that begin or end at a line that was refused.
    pub leak_held_j: f64,
}

impl WorldSummary {
    /// Nothing has been done yet.
    #[must_use]
    pub fn new(
        force_limit_n: Option<f64>,
        torque_limit_n_m: Option<f64>,
        soft_start_s: f64,
    ) -> Self {
        Self {
            format: FORMAT,
            samples: 0,
            refused: 0,
            limited: 0,
            guarded: 0,
            softened: 0,
            went_through: 0,
            safety_stop: None,
            force_limit_n,
            torque_limit_n_m,
            soft_start_s,
            dissipated_j: 0.0,
            port_work_j: 0.0,
            leak_held_j: 0.0,
        }
    }

    /// The same with the books; [`leak_held_j`](Self::leak_held_j) is summed up line by line.
    #[must_use]
    pub fn with_books(&self, books: &Books) -> Self {
        Self {
            dissipated_j: books.dissipated(),
            port_work_j: books.devices.iter().map(|book| book.port_work).sum(),
            ..self.clone()
        }
    }
}

impl fmt::Display for WorldSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}, {} refused, {} limited; leak {} if the loop is as modelled, friction and damping took {}",
            counted(self.samples, "sample"),
            self.refused,
            counted(self.limited, "line"),
            millijoules(self.leak_held_j),
            millijoules(self.dissipated_j),
        )?;
        if let Some(reason) = self.safety_stop {
            write!(f, "; safety stop: {reason}")?;
        }
        match self.guarded {
            0 => Ok(()),
            many => write!(f, "; {} beyond the guard's bound", counted(many, "line")),
        }
    }
}
