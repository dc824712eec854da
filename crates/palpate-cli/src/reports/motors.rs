//! Check that each motor of a device turns its own joint.

use palpate_drivers::two_diy::Checked;
use serde::Serialize;

/// Name and version of the JSON report on motors.
const MOTORS_FORMAT: &str = "palpate devices check 1";

/// Result of a motor check.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct MotorsReport {
    board: &'static str,
    #[cfg_attr(test, schemars(extend("const" = MOTORS_FORMAT)))]
    format: &'static str,
    motors: Vec<MotorReport>,
}

impl MotorsReport {
    /// Creates the report of the `checked` motors of a board with this name.
    #[must_use]
    pub fn new(board: &'static str, checked: &[Checked]) -> Self {
        let motors = checked.iter().map(|checked| MotorReport {
            turned_deg: checked.turned.map(f64::from),
            verdict: checked.verdict.name(),
        });
        Self {
            board,
            format: MOTORS_FORMAT,
            motors: motors.collect(),
        }
    }
}

/// Result of one motor.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct MotorReport {
    /// Rotation of each joint `[degrees]`.
    turned_deg: [f64; 2],
    verdict: &'static str,
}
