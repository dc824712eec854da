//! Motion of a calibration in reports.

use serde::{Deserialize, Serialize};

/// A part of the motion of a calibration, with the fit's prediction.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct MotionCard {
    /// Times `[s]`.
    pub t_s: Vec<f64>,
    /// Measured positions relative to the start of the device `[m]`.
    pub measured_m: Vec<f64>,
    /// One-step predictions of the fit relative to the start of the device `[m]`.
    pub fitted_m: Vec<f64>,
    /// Commands `[N]`.
    pub command_n: Vec<f64>,
}
