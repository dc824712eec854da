//! The one error of parameters, and the checks that raise it.

use std::fmt::Display;

use thiserror::Error;

/// A parameter outside its range: which one, what it was, what it may be.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error("{name} = {value} is not allowed; allowed: {allowed}")]
pub struct InvalidParameter<N: Display = &'static str> {
    /// The parameter: its name, as in the type that holds it, or a value to match.
    pub name: N,
    /// The rejected value, in the parameter's own unit.
    pub value: f64,
    /// Text of the allowed range, with its unit.
    pub allowed: &'static str,
}

impl<N: Display> InvalidParameter<N> {
    /// Accepts `value` if `holds`.
    pub(crate) fn unless(
        holds: bool,
        name: N,
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
pub(crate) fn finite<N: Display>(
    name: N,
    value: f64,
    allowed: &'static str,
) -> Result<f64, InvalidParameter<N>> {
    InvalidParameter::unless(value.is_finite(), name, value, allowed)
}

/// Accepts a finite number above zero.
pub(crate) fn positive<N: Display>(
    name: N,
    value: f64,
    allowed: &'static str,
) -> Result<f64, InvalidParameter<N>> {
    InvalidParameter::unless(value.is_finite() && value > 0.0, name, value, allowed)
}

/// Accepts a finite number that is at least zero.
pub(crate) fn not_negative<N: Display>(
    name: N,
    value: f64,
    allowed: &'static str,
) -> Result<f64, InvalidParameter<N>> {
    InvalidParameter::unless(value.is_finite() && value >= 0.0, name, value, allowed)
}
