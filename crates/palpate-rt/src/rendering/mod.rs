//! Renderings of a loop and their changes at run time.

mod changing_world;
mod frame;
mod local_world;
mod one_contact;
mod rendered;
mod renders;
mod world;
mod world_rows;

use palpate_core::{ParameterError, Running};

pub use changing_world::{ChangingWorld, WorldChangeError, Worlds, changing_world};
pub use frame::{FrameError, WorldAxis, WorldFrame};
pub(crate) use local_world::{FromHost, sides};
pub use local_world::{LocalWorld, LowRateSimulator, local_world};
pub use one_contact::OneContact;
pub use palpate_core::{CHANGE_DURATION, ChangeError};
pub use rendered::Rendered;
pub use renders::{Answer, DeviceSample, DeviceSamples, Renders};
pub use world::{RenderedWorld, Turns};
pub use world_rows::WorldRows;

/// Rendering of one contact, in the loop's number type.
pub type Rendering = palpate_core::Rendering<f64>;

/// A checked change of the rendering, with its number.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Change {
    pub change: palpate_core::Change<f64>,
    pub generation: u32,
}

/// The other end of the loop's parameters, for any thread. Changes are handed over without blocking either side. Of
/// several changes between two ticks only the latest takes effect.
#[derive(Debug)]
pub struct Parameters {
    input: triple_buffer::Input<Change>,
    current: Rendering,
    generation: u32,
}

impl Parameters {
    /// Returns the rendering that was handed over last.
    #[must_use]
    pub fn current(&self) -> &Rendering {
        &self.current
    }

    /// Returns the number of that rendering. Ticks carry the number of the rendering in force.
    #[must_use]
    pub fn generation(&self) -> u32 {
        self.generation
    }

    /// Renders `rendering` from the next tick on, without a step in the force. Stiffness, mass and virtual force
    /// change over a tenth of a second, and so does the force difference of another method. The ledger records the
    /// energy of the change as outside work. Returns the number of the change, which the ticks carry.
    ///
    /// # Errors
    /// A parameter outside its range, another period, another side of the device.
    pub fn change(&mut self, rendering: Rendering) -> Result<u32, ChangeError> {
        let change = palpate_core::Change::new(&self.current, rendering)?;
        self.generation = self.generation.wrapping_add(1);
        self.current = rendering;
        self.input.write(Change {
            change,
            generation: self.generation,
        });
        Ok(self.generation)
    }
}

/// Creates both ends of the parameters of a loop that starts with `rendering`.
///
/// A [`ControlLoop`](crate::ControlLoop) does this itself. This function serves other loops; their commands must pass
/// a [`Safety`](crate::safety::Safety). With a line [`Hold`](palpate_core::Hold) they command the slope of each output
/// too, and report it with [`Rendered::report_sent_line`].
///
/// # Errors
/// The first parameter outside its range.
pub fn parameters(rendering: Rendering) -> Result<(Parameters, Rendered), ParameterError> {
    // Recordings and pipes depend on the exact result of this power function.
    let running = Running::new(rendering)?.with_power(f64::powf);
    let (input, output) = triple_buffer::triple_buffer(&Change {
        change: palpate_core::Change::none(&running),
        generation: 0,
    });
    let parameters = Parameters {
        input,
        current: rendering,
        generation: 0,
    };
    Ok((parameters, Rendered::new(running, output)))
}
