//! Numbers that an argument may have.

use pyo3::PyResult;

use crate::names::refused;

/// A number within a range, both ends in it.
pub fn within(name: &str, value: f64, [least, most]: [f64; 2], unit: &str) -> PyResult<f64> {
    if value.is_finite() && value >= least && value <= most {
        return Ok(value);
    }
    let allowed = if most == f64::INFINITY {
        format!("finite and not below {least}")
    } else {
        format!("{least} to {most}")
    };
    Err(refused(format!(
        "{name} is {value}{unit}, but must be {allowed}"
    )))
}

/// A number that is neither NaN nor infinite.
pub fn finite(name: &str, value: f64, unit: &str) -> PyResult<f64> {
    if value.is_finite() {
        return Ok(value);
    }
    Err(refused(format!(
        "{name} is {value}{unit}, but must be finite"
    )))
}

/// A number above 0.
pub fn above_zero(name: &str, value: f64, unit: &str) -> PyResult<f64> {
    if value.is_finite() && value > 0.0 {
        return Ok(value);
    }
    Err(refused(format!(
        "{name} is {value}{unit}, but must be finite and greater than 0"
    )))
}

/// 0 and above.
pub const NOT_NEGATIVE: [f64; 2] = [0.0, f64::INFINITY];
/// A factor of what a renderer is told.
pub const FACTOR: [f64; 2] = [1e-3, 1e3];
/// A time in periods.
pub const PERIODS: [f64; 2] = [0.0, 100.0];
