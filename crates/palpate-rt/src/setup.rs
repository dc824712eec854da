//! Why a loop cannot be set up.

use palpate::ParameterError;

use crate::safety::SafetyError;

/// Why a loop cannot be set up.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SetupError {
    /// A parameter of what is rendered.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A limit of the safety.
    #[error(transparent)]
    Safety(#[from] SafetyError),
    /// A period that no clock can keep `[s]`.
    #[error("the period is {0} s; allowed: a nanosecond to 10 s")]
    Period(f64),
}
