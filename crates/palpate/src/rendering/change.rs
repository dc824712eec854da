//! What a rendering that runs can change to.

use core::fmt;

use super::{Rendering, Running};
use crate::Scalar;
use crate::parameter::ParameterError;
use crate::render::AnyRenderer;

/// A change of what is rendered that has been checked.
#[derive(Clone, Copy, Debug)]
pub struct Change<S> {
    pub(super) rendering: Rendering<S>,
    pub(super) renderer: AnyRenderer<S>,
}

/// Why a change is not taken; what was rendered goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ChangeError {
    /// A parameter outside its range.
    Parameter(ParameterError),
    /// The loop runs at one period.
    Period {
        /// What was asked for `[s]`.
        given: f64,
        /// What the loop runs at `[s]`.
        running: f64,
    },
    /// Measurement from the other side, the device would be deep in the object.
    Side,
}

impl fmt::Display for ChangeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Parameter(error) => error.fmt(f),
            Self::Period { given, running } => write!(
                f,
                "the period is {given} s, and the loop runs at {running} s; stop it to change that"
            ),
            Self::Side => f.write_str(
                "the object cannot change to the other side of the device while the loop runs",
            ),
        }
    }
}

impl core::error::Error for ChangeError {}

impl From<ParameterError> for ChangeError {
    fn from(error: ParameterError) -> Self {
        Self::Parameter(error)
    }
}

impl<S: Scalar> Change<S> {
    /// The change from `running` to `rendering`.
    ///
    /// # Errors
    /// A parameter outside its range, another period, another side of the device.
    pub fn new(running: &Rendering<S>, rendering: Rendering<S>) -> Result<Self, ChangeError> {
        let renderer = rendering.renderer()?;
        let (given, period) = (rendering.loop_params.period, running.loop_params.period);
        if given != period {
            return Err(ChangeError::Period {
                given: given.to_f64(),
                running: period.to_f64(),
            });
        }
        if rendering.contact.side != running.contact.side {
            return Err(ChangeError::Side);
        }
        Ok(Self {
            rendering,
            renderer,
        })
    }

    /// The change to what `running` renders already.
    #[must_use]
    pub fn none(running: &Running<S>) -> Self {
        running.as_change()
    }

    /// What is to be rendered.
    #[must_use]
    pub fn rendering(&self) -> &Rendering<S> {
        &self.rendering
    }
}
