//! Checking of parameters: what was wrong, with which value, and what is allowed.

use core::fmt;

use crate::Scalar;

/// A parameter outside its allowed range.
///
/// Its message names the parameter, the value it was given, and the range:
///
/// ```
/// use palpate::{BasicParams, Contact, LoopParams, Renderer};
///
/// let wrong = Renderer::new(Contact::object(-400.0, 0.1), LoopParams::new(0.001), BasicParams);
/// assert_eq!(
///     wrong.unwrap_err().to_string(),
///     "stiffness is -400 N/m, but must be finite and greater than 0"
/// );
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterError {
    /// Name of the parameter, as the field is called.
    pub parameter: &'static str,
    /// The value that was given.
    pub value: f64,
    /// The parameter's unit, empty for a pure number.
    pub unit: &'static str,
    /// The values that are allowed, in words that follow "must be".
    pub allowed: &'static str,
}

impl fmt::Display for ParameterError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let space = if self.unit.is_empty() { "" } else { " " };
        write!(
            f,
            "{} is {}{space}{}, but must be {}",
            self.parameter, self.value, self.unit, self.allowed
        )
    }
}

impl core::error::Error for ParameterError {}

pub(crate) fn positive<S: Scalar>(
    parameter: &'static str,
    unit: &'static str,
    value: S,
) -> Result<S, ParameterError> {
    check(
        value.is_finite() && value > S::ZERO,
        parameter,
        unit,
        value,
        "finite and greater than 0",
    )
}

pub(crate) fn not_negative<S: Scalar>(
    parameter: &'static str,
    unit: &'static str,
    value: S,
) -> Result<S, ParameterError> {
    check(
        value.is_finite() && value >= S::ZERO,
        parameter,
        unit,
        value,
        "finite and not below 0",
    )
}

pub(crate) fn finite<S: Scalar>(
    parameter: &'static str,
    unit: &'static str,
    value: S,
) -> Result<S, ParameterError> {
    check(value.is_finite(), parameter, unit, value, "finite")
}

pub(crate) fn check<S: Scalar>(
    allowed_value: bool,
    parameter: &'static str,
    unit: &'static str,
    value: S,
    allowed: &'static str,
) -> Result<S, ParameterError> {
    if allowed_value {
        Ok(value)
    } else {
        Err(ParameterError {
            parameter,
            value: value.to_f64(),
            unit,
            allowed,
        })
    }
}

/// The value of a parameter, for a report.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ParameterValue<S> {
    /// A number, in the unit that the parameter's key ends with.
    Number(S),
    /// One of several words.
    Word(&'static str),
    /// On or off.
    Switch(bool),
    /// A number that is derived from the contact and the loop, and has not been derived yet.
    ToBeDerived,
}

impl<S: fmt::Display> fmt::Display for ParameterValue<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => write!(f, "{number}"),
            Self::Word(word) => f.write_str(word),
            Self::Switch(on) => write!(f, "{on}"),
            Self::ToBeDerived => f.write_str("auto"),
        }
    }
}
