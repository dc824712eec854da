//! Changes of an active rendering.

use core::fmt;

use super::{Rendering, Running};
use crate::Scalar;
use crate::parameter::ParameterError;
use crate::render::AnyRenderer;

/// A checked change of the rendering.
#[derive(Clone, Copy, Debug)]
pub struct Change<S> {
    pub(super) rendering: Rendering<S>,
    pub(super) renderer: AnyRenderer<S>,
}

/// Reason for rejecting a change. The current rendering continues unchanged.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ChangeError {
    /// A parameter is outside its range.
    Parameter(ParameterError),
    /// The loop has a fixed period.
    Period {
        /// Requested period `[s]`.
        given: f64,
        /// Period of the loop `[s]`.
        running: f64,
    },
    /// The actuator holds what it holds.
    Hold,
    /// With the other side of measurement, the device would be deep in the object.
    Side,
}

impl fmt::Display for ChangeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Parameter(error) => error.fmt(f),
            Self::Period { given, running } => write!(
                f,
                "the period is {given} s, and the loop runs at {running} s; stop the loop to change its period"
            ),
            Self::Hold => f.write_str("the hold of the actuator cannot change while the loop runs"),
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
    /// Checks the change from `running` to `rendering`.
    ///
    /// # Errors
    /// A parameter is outside its range, or the period or the side of the device differs.
    pub fn new(running: &Rendering<S>, rendering: Rendering<S>) -> Result<Self, ChangeError> {
        let renderer = rendering.renderer()?;
        let (given, period) = (rendering.loop_params.period, running.loop_params.period);
        if given != period {
            return Err(ChangeError::Period {
                given: given.to_f64(),
                running: period.to_f64(),
            });
        }
        let (hold, before) = (
            rendering.loop_params.actuation.hold,
            running.loop_params.actuation.hold,
        );
        if hold != before {
            return Err(ChangeError::Hold);
        }
        if rendering.contact.side != running.contact.side {
            return Err(ChangeError::Side);
        }
        Ok(Self {
            rendering,
            renderer,
        })
    }

    /// Returns the change to the current rendering of `running`.
    #[must_use]
    pub fn none(running: &Running<S>) -> Self {
        running.as_change()
    }

    /// Returns the new rendering.
    #[must_use]
    pub fn rendering(&self) -> &Rendering<S> {
        &self.rendering
    }
}
