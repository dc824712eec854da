//! What the loop renders, and how that changes while it runs.

mod changing_world;
mod frame;
mod local_world;
mod one_contact;
mod rendered;
mod renders;
mod world;
mod world_rows;

use palpate::{ParameterError, Running};

pub use changing_world::{ChangingWorld, WorldChangeError, Worlds, changing_world};
pub use frame::{FrameError, WorldAxis, WorldFrame};
pub(crate) use local_world::{FromHost, sides};
pub use local_world::{LocalWorld, SlowHost, local_world};
pub use one_contact::OneContact;
pub use palpate::{CHANGE_DURATION, ChangeError};
pub use rendered::Rendered;
pub use renders::{Answer, Fresh, FreshDevice, Renders};
pub use world::{RenderedWorld, Turns};
pub use world_rows::WorldRows;

/// What a loop renders, in the loop's numbers.
pub type Rendering = palpate::Rendering<f64>;

/// A change of what is rendered that has been checked, with its number.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Change {
    pub change: palpate::Change<f64>,
    pub generation: u32,
}

/// The other end of the loop's parameters, for any thread: changes are handed over without either
/// side ever waiting. Of several changes between two ticks the last counts.
#[derive(Debug)]
pub struct Parameters {
    input: triple_buffer::Input<Change>,
    current: Rendering,
    generation: u32,
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
        let change = palpate::Change::new(&self.current, rendering)?;
        self.generation = self.generation.wrapping_add(1);
        self.current = rendering;
        self.input.write(Change {
            change,
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
    // Recordings and pipes have had the bits of this function since they are there.
    let running = Running::new(rendering)?.with_power(f64::powf);
    let (input, output) = triple_buffer::triple_buffer(&Change {
        change: palpate::Change::none(&running),
        generation: 0,
    });
    let parameters = Parameters {
        input,
        current: rendering,
        generation: 0,
    };
    Ok((parameters, Rendered::new(running, output)))
}
