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

/// A unit, as messages write it and as keys end with it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)] // the units are called what they are
pub enum Unit {
    One,
    Metre,
    MetrePerSecond,
    Second,
    Kilogram,
    Newton,
    NewtonPerMetre,
    NewtonPerSecond,
    NewtonSecondPerMetre,
    Joule,
    Sample,
}

impl Unit {
    /// Its symbol, empty for a pure number.
    pub const fn symbol(self) -> &'static str {
        match self {
            Self::One => "",
            Self::Metre => "m",
            Self::MetrePerSecond => "m/s",
            Self::Second => "s",
            Self::Kilogram => "kg",
            Self::Newton => "N",
            Self::NewtonPerMetre => "N/m",
            Self::NewtonPerSecond => "N/s",
            Self::NewtonSecondPerMetre => "N s/m",
            Self::Joule => "J",
            Self::Sample => "samples",
        }
    }

    /// What a key of this unit ends with, empty for a pure number.
    pub const fn suffix(self) -> &'static str {
        match self {
            Self::One => "",
            Self::Metre => "_m",
            Self::MetrePerSecond => "_m_per_s",
            Self::Second => "_s",
            Self::Kilogram => "_kg",
            Self::Newton => "_n",
            Self::NewtonPerMetre => "_n_per_m",
            Self::NewtonPerSecond => "_n_per_s",
            Self::NewtonSecondPerMetre => "_n_s_per_m",
            Self::Joule => "_j",
            Self::Sample => "_samples",
        }
    }
}

/// The range of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Range {
    /// Any finite number.
    Finite,
    /// Finite and greater than 0.
    Positive,
    /// Finite and not below 0.
    NotNegative,
}

impl Range {
    /// Whether `value` lies in it.
    pub fn contains<S: Scalar>(self, value: S) -> bool {
        value.is_finite()
            && match self {
                Self::Finite => true,
                Self::Positive => value > S::ZERO,
                Self::NotNegative => value >= S::ZERO,
            }
    }

    /// The range in words that follow "must be".
    pub const fn allowed(self) -> &'static str {
        match self {
            Self::Finite => "finite",
            Self::Positive => "finite and greater than 0",
            Self::NotNegative => "finite and not below 0",
        }
    }

    pub(crate) fn check<S: Scalar>(
        self,
        parameter: &'static str,
        unit: &'static str,
        value: S,
    ) -> Result<S, ParameterError> {
        check(self.contains(value), parameter, unit, value, self.allowed())
    }
}

pub(crate) fn positive<S: Scalar>(
    parameter: &'static str,
    unit: &'static str,
    value: S,
) -> Result<S, ParameterError> {
    Range::Positive.check(parameter, unit, value)
}

pub(crate) fn not_negative<S: Scalar>(
    parameter: &'static str,
    unit: &'static str,
    value: S,
) -> Result<S, ParameterError> {
    Range::NotNegative.check(parameter, unit, value)
}

pub(crate) fn finite<S: Scalar>(
    parameter: &'static str,
    unit: &'static str,
    value: S,
) -> Result<S, ParameterError> {
    Range::Finite.check(parameter, unit, value)
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

impl<S> From<S> for ParameterValue<S>
where
    S: Scalar,
{
    fn from(number: S) -> Self {
        Self::Number(number)
    }
}

impl From<bool> for ParameterValue<f64> {
    fn from(on: bool) -> Self {
        Self::Switch(on)
    }
}
