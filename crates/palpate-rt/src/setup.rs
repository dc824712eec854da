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
    /// A world with another number of devices than a loop has.
    #[error(
        "the world has {0} devices; a loop in real time has one so far, and `palpate pipe` renders a world of several"
    )]
    Devices(usize),
    /// A world whose tool turns.
    #[error(
        "the world's device has six axes (inertia_kg_m2); a loop in real time gives no torque so far, and `palpate \
         pipe` renders it"
    )]
    SixAxes,
    /// A period that no clock can keep `[s]`.
    #[error("the period is {0} s; allowed: a nanosecond to 10 s")]
    Period(f64),
}
