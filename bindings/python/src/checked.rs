//! Range checks of numeric arguments.

use pyo3::PyResult;

use crate::names::refused;

/// Returns a number if it is within a closed range.
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

/// Returns a number if it is finite.
pub fn finite(name: &str, value: f64, unit: &str) -> PyResult<f64> {
    if value.is_finite() {
        return Ok(value);
    }
    Err(refused(format!(
        "{name} is {value}{unit}, but must be finite"
    )))
}

/// Returns a number if it is finite and above 0.
pub fn above_zero(name: &str, value: f64, unit: &str) -> PyResult<f64> {
    if value.is_finite() && value > 0.0 {
        return Ok(value);
    }
    Err(refused(format!(
        "{name} is {value}{unit}, but must be finite and greater than 0"
    )))
}

/// Range of non-negative numbers.
pub const NOT_NEGATIVE: [f64; 2] = [0.0, f64::INFINITY];
/// Range of a factor on a model value.
pub const FACTOR: [f64; 2] = [1e-3, 1e3];
/// Range of a time in periods.
pub const PERIODS: [f64; 2] = [0.0, 100.0];
/// Standard deviation of a delay or a lag, in periods of the loop.
pub const DEVIATION: [f64; 2] = [0.0, palpate_core::LARGEST_DELAY as f64];
