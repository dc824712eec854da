//! What the loop renders, and how that changes while it runs.

mod blend;
mod rendered;

use std::fmt;

use palpate::{
    AnyParams, AnyRenderer, Contact, LoopParams, Mass, ObjectState, ParameterError, Renderer,
};
use palpate_scene::method::MethodName;
use palpate_scene::named_parameters::{in_words, method_of};
use palpate_scene::{Scene, SetupError};

pub use blend::CHANGE_DURATION;
pub use rendered::Rendered;

/// What the loop renders: a contact, by a method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rendering {
    /// The contact.
    pub contact: Contact<f64>,
    /// The loop; its period is that of the deadlines.
    pub loop_params: LoopParams<f64>,
    /// The method, with its parameters.
    pub params: AnyParams<f64>,
    /// Virtual force f_V on the object `[N]`.
    pub virtual_force: f64,
    /// Where the object is at the start; where a wall always is.
    pub object: ObjectState<f64>,
}

impl Rendering {
    /// What `scene` renders by `method`.
    ///
    /// # Errors
    /// A parameter outside its range; a setting that the method cannot use.
    pub fn of(scene: &Scene, method: MethodName) -> Result<Self, SetupError> {
        let renderer = scene.renderer(method)?;
        Ok(Self {
            contact: scene.contact,
            loop_params: *renderer.loop_params(),
            params: scene.params(method)?,
            virtual_force: scene.virtual_force,
            object: scene.object,
        })
    }

    /// The renderer of it.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn renderer(&self) -> Result<AnyRenderer<f64>, ParameterError> {
        Renderer::new(self.contact, self.loop_params, self.params)
    }

    /// The contact of it, for a loop that is not a [`ControlLoop`](crate::ControlLoop), and the
    /// other end of its parameters. What that loop commands has to pass a
    /// [`Safety`](crate::safety::Safety) of its own.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn begin(self) -> Result<(Parameters, Rendered), ParameterError> {
        parameters(self)
    }

    /// The method; HFCR without dissipation is `hfcr`, whatever it was chosen as.
    #[must_use]
    pub fn method(&self) -> MethodName {
        method_of(&self.params)
    }

    fn is_wall(&self) -> bool {
        self.contact.object_mass == Mass::Infinite
    }
}

impl fmt::Display for Rendering {
    /// What a change can change.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let stiffness = self.contact.stiffness;
        match self.contact.object_mass {
            Mass::Finite(mass) => write!(f, "{mass} kg behind {stiffness} N/m")?,
            Mass::Infinite => write!(f, "a wall of {stiffness} N/m")?,
        }
        write!(
            f,
            ", f_V {} N, by {}",
            self.virtual_force,
            in_words(&self.params)
        )
    }
}

/// A change of what is rendered that has been checked, with its number.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Change {
    pub rendering: Rendering,
    pub renderer: AnyRenderer<f64>,
    pub generation: u32,
}

/// The other end of the loop's parameters, for any thread: changes are handed over without either
/// side ever waiting. Of several changes between two ticks the last counts.
pub struct Parameters {
    input: triple_buffer::Input<Change>,
    current: Rendering,
    generation: u32,
}

/// Why a change is not taken; what was rendered goes on.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ChangeError {
    /// A parameter outside its range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// The loop runs at one period.
    #[error("the period is {given} s, and the loop runs at {running} s; stop it to change that")]
    Period {
        /// What was asked for `[s]`.
        given: f64,
        /// What the loop runs at `[s]`.
        running: f64,
    },
    /// Seen from the other side, the device would be deep in the object.
    #[error("the object cannot change to the other side of the device while the loop runs")]
    Side,
}

impl Parameters {
    /// What was handed over last.
    #[must_use]
    pub fn current(&self) -> &Rendering {
        &self.current
    }

    /// Number of what was handed over last, which the ticks carry from where it is in force.
    #[must_use]
    pub fn generation(&self) -> u32 {
        self.generation
    }

    /// Renders `rendering` from the next tick on, without a step in the force: stiffness, mass and
    /// virtual force pass over to the new ones in a tenth of a second, and so does the difference
    /// that another method makes. The energy of it is booked in the ledger as outside work. Its
    /// number, which the ticks carry.
    ///
    /// # Errors
    /// A parameter outside its range, another period, another side of the device.
    pub fn change(&mut self, rendering: Rendering) -> Result<u32, ChangeError> {
        let renderer = rendering.renderer()?;
        let running = self.current.loop_params.period;
        if rendering.loop_params.period != running {
            return Err(ChangeError::Period {
                given: rendering.loop_params.period,
                running,
            });
        }
        if rendering.contact.side != self.current.contact.side {
            return Err(ChangeError::Side);
        }
        self.generation = self.generation.wrapping_add(1);
        self.current = rendering;
        self.input.write(Change {
            rendering,
            renderer,
            generation: self.generation,
        });
        Ok(self.generation)
    }
}

/// Both ends of the parameters of a loop that begins with `rendering`.
pub(crate) fn parameters(rendering: Rendering) -> Result<(Parameters, Rendered), ParameterError> {
    let renderer = rendering.renderer()?;
    let change = Change {
        rendering,
        renderer,
        generation: 0,
    };
    let (input, output) = triple_buffer::triple_buffer(&change);
    let parameters = Parameters {
        input,
        current: rendering,
        generation: 0,
    };
    Ok((parameters, Rendered::new(change, output)?))
}
