//! Parameters of a renderer with the initial state of its object, and changes at run time.

mod blend;
mod change;
mod running;

use core::fmt;

use crate::Scalar;
use crate::contact::{Contact, LoopParams, Mass};
use crate::motion::ObjectState;
use crate::parameter::ParameterError;
use crate::render::{AnyParams, AnyRenderer, MethodParams as _, Renderer};

pub use blend::CHANGE_DURATION;
pub use change::{Change, ChangeError};
pub use running::Running;

/// Rendering task of a loop: a contact, a method, and a start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rendering<S> {
    /// The contact.
    pub contact: Contact<S>,
    /// The loop parameters; the period also determines the deadlines.
    pub loop_params: LoopParams<S>,
    /// The method, with its parameters.
    pub params: AnyParams<S>,
    /// Virtual force f_V on the object `[N]`.
    pub virtual_force: S,
    /// Initial state of the object; the position of a wall.
    pub object: ObjectState<S>,
}

impl<S: Scalar> Rendering<S> {
    /// Checks all parameters and creates the renderer.
    ///
    /// # Errors
    /// The first parameter outside its range.
    pub fn renderer(&self) -> Result<AnyRenderer<S>, ParameterError> {
        Renderer::new(self.contact, self.loop_params, self.params)
    }

    /// Returns the method's name; HFCR without dissipation is `hfcr`, however it was selected.
    #[must_use]
    pub fn method(&self) -> &'static str {
        self.params.name()
    }

    /// Returns whether the method compares the samples with the modelled timing of the loop: coupled rendering with a
    /// standard deviation of delay or lag.
    #[must_use]
    pub fn checks_timing(&self) -> bool {
        matches!(self.params, AnyParams::Coupled(_))
            && self.loop_params.actuation.timing_deviation() > S::ZERO
    }

    /// Returns whether the object is a wall.
    #[must_use]
    pub fn is_wall(&self) -> bool {
        matches!(self.contact.object_mass, Mass::Infinite)
    }
}

impl<S: Scalar + fmt::Display> fmt::Display for Rendering<S> {
    /// Writes contact, virtual force and method with its parameters, in words and SI units.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let stiffness = &self.contact.stiffness;
        match &self.contact.object_mass {
            Mass::Finite(mass) => write!(f, "{mass} kg behind {stiffness} N/m")?,
            Mass::Infinite => write!(f, "a wall of {stiffness} N/m")?,
        }
        write!(f, ", f_V {} N, by {}", self.virtual_force, self.params)
    }
}
