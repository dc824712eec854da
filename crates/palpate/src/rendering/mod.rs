//! All that a renderer is made of, where its object begins, and how it changes while it runs.

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

/// What a loop renders: a contact, by a method, from a start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rendering<S> {
    /// The contact.
    pub contact: Contact<S>,
    /// The loop; its period is that of the deadlines.
    pub loop_params: LoopParams<S>,
    /// The method, with its parameters.
    pub params: AnyParams<S>,
    /// Virtual force f_V on the object `[N]`.
    pub virtual_force: S,
    /// Where the object is at the start; where a wall always is.
    pub object: ObjectState<S>,
}

impl<S: Scalar> Rendering<S> {
    /// Checks all parameters and gives the renderer.
    ///
    /// # Errors
    /// The first parameter outside its range.
    pub fn renderer(&self) -> Result<AnyRenderer<S>, ParameterError> {
        Renderer::new(self.contact, self.loop_params, self.params)
    }

    /// The method's name; HFCR without dissipation is `hfcr`, whatever it was chosen as.
    #[must_use]
    pub fn method(&self) -> &'static str {
        self.params.name()
    }

    /// Whether the object is a wall.
    #[must_use]
    pub fn is_wall(&self) -> bool {
        matches!(self.contact.object_mass, Mass::Infinite)
    }
}

impl<S: Scalar + fmt::Display> fmt::Display for Rendering<S> {
    /// Contact, virtual force and method with its parameters, in words and SI units.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let stiffness = &self.contact.stiffness;
        match &self.contact.object_mass {
            Mass::Finite(mass) => write!(f, "{mass} kg behind {stiffness} N/m")?,
            Mass::Infinite => write!(f, "a wall of {stiffness} N/m")?,
        }
        write!(f, ", f_V {} N, by {}", self.virtual_force, self.params)
    }
}
