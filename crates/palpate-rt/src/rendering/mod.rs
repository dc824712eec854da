//! What the loop renders, and how that changes while it runs.

mod blend;
mod rendered;

use palpate::{AnyRenderer, ParameterError};

pub use blend::CHANGE_DURATION;
pub use rendered::Rendered;

/// What a loop renders, in the loop's numbers.
pub type Rendering = palpate::Rendering<f64>;

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
#[non_exhaustive]
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
///
/// A [`ControlLoop`](crate::ControlLoop) does this by itself. For another loop it gives the contact to
/// render; what that loop commands has to pass a [`Safety`](crate::safety::Safety) of its own.
///
/// # Errors
/// The first parameter outside its range.
pub fn parameters(rendering: Rendering) -> Result<(Parameters, Rendered), ParameterError> {
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
