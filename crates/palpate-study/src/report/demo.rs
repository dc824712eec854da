//! The report on the demonstration.

use serde::Serialize;

use super::Report;

/// Name and version of the JSON report.
const FORMAT: &str = "palpate demo 1";

/// Report on both parts of the demonstration.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
pub struct DemoReport {
    #[cfg_attr(any(test, feature = "schema"), schemars(extend("const" = FORMAT)))]
    format: &'static str,
    /// Report on the motion of a hand.
    pub hand: Report,
    /// Report on the paper's Fig. 2.
    pub simulation: Report,
}

impl DemoReport {
    /// Creates the report on both.
    #[must_use]
    pub fn new(hand: Report, simulation: Report) -> Self {
        Self {
            format: FORMAT,
            hand,
            simulation,
        }
    }
}
