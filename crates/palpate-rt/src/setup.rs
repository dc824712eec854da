//! Whether a loop can be set up, and why not.

use palpate::ParameterError;
use palpate_device::Device;

use crate::rendering::{RenderedWorld, Turns};
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
    /// What is rendered has another number of devices than the loop.
    #[error("the world has {world} devices, and {given} are given; allowed: one for each")]
    Devices {
        /// Devices of the world, or 1 of a contact.
        world: usize,
        /// Devices, or places for them, that were given.
        given: usize,
    },
    /// A world whose tool feels a torque, on a device that gives none.
    #[error(
        "the world's device has six axes (inertia_kg_m2), and this device has no torque about three axes; allowed: a \
         device that has, such as simulated, or gives_torque = false, with which the hand alone turns the tool"
    )]
    SixAxes,
    /// A world whose tool turns, on a device that does not say how it is turned.
    #[error(
        "the world's tool turns (inertia_kg_m2), and this device measures no orientation; allowed: a device that does, such as \
         simulated, or a tool that keeps the axes of the world"
    )]
    Orientation,
    /// A world whose tool turns, on a device whose axes are not those of the world.
    #[error("a device of six axes has the axes of the world, x,y,z; its place may be another one")]
    TurnedFrame,
    /// A period that no clock can keep `[s]`.
    #[error("the period is {0} s; allowed: a nanosecond to 10 s")]
    Period(f64),
}

/// Whether the devices turn that have to.
pub(crate) fn can_turn<'a, D: Device + 'a>(
    world: &RenderedWorld,
    devices: impl IntoIterator<Item = &'a D>,
) -> Result<(), SetupError> {
    for (turns, device) in world.turns().iter().zip(devices) {
        let can = device.capabilities();
        match turns {
            Turns::WithTorque if can.torque_axes != 3 => return Err(SetupError::SixAxes),
            Turns::WithTorque | Turns::ByHand if !can.measures_orientation => {
                return Err(SetupError::Orientation);
            }
            _ => {}
        }
    }
    Ok(())
}
