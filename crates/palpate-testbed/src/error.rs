//! The one error of parameters, and the checks that raise it.

use thiserror::Error;

/// A parameter outside its range: which one, what it was, what it may be.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error("{name} = {value} is not allowed; allowed: {allowed}")]
pub struct InvalidParameter {
    /// Name of the parameter, as in the type that holds it.
    pub name: &'static str,
    /// The rejected value, in the parameter's own unit.
    pub value: f64,
    /// The allowed range in words, with its unit.
    pub allowed: &'static str,
}

impl InvalidParameter {
    /// Accepts `value` if `holds`.
    pub(crate) fn unless(
        holds: bool,
        name: &'static str,
        value: f64,
        allowed: &'static str,
    ) -> Result<f64, Self> {
        if holds {
            Ok(value)
        } else {
            Err(Self {
                name,
                value,
                allowed,
            })
        }
    }
}

/// Accepts a finite number.
pub(crate) fn finite(
    name: &'static str,
    value: f64,
    allowed: &'static str,
) -> Result<f64, InvalidParameter> {
    InvalidParameter::unless(value.is_finite(), name, value, allowed)
}

/// Accepts a finite number above zero.
pub(crate) fn positive(
    name: &'static str,
    value: f64,
    allowed: &'static str,
) -> Result<f64, InvalidParameter> {
    InvalidParameter::unless(value.is_finite() && value > 0.0, name, value, allowed)
}
