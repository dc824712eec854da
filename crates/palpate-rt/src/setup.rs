//! Errors of setting up a loop.

use palpate_core::ParameterError;
use palpate_device::Device;

use crate::rendering::{RenderedWorld, Turns};
use crate::safety::SafetyError;

/// Reason why a loop cannot be set up.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SetupError {
    /// An invalid parameter of the rendering.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// An invalid limit of the safety.
    #[error(transparent)]
    Safety(#[from] SafetyError),
    /// The rendering has another number of devices than the loop.
    #[error("the world has {world} devices, but {given} are given; allowed: one for each")]
    Devices {
        /// Devices of the world, or 1 of a contact.
        world: usize,
        /// Number of devices, or of frames for them, that were given.
        given: usize,
    },
    /// A world whose tool has a torque, on a device without torque.
    #[error(
        "the world's device has six axes (inertia_kg_m2), but this device has no torque about three axes; use a \
         device with torque, such as simulated, or set gives_torque = false: only the hand then turns the tool"
    )]
    SixAxes,
    /// A world whose tool rotates, on a device that measures no orientation.
    #[error(
        "the world's tool turns (inertia_kg_m2), but this device measures no orientation; use a device that does, \
         such as simulated, or a tool with a fixed orientation"
    )]
    Orientation,
    /// A world whose tool rotates, on a device whose axes are not those of the world.
    #[error("a device of six axes must have the axes of the world, x,y,z; its position may differ")]
    TurnedFrame,
    /// A rendering with lines on a device that holds constants.
    #[error(
        "the rendering has loop.hold = \"line\", but this device holds constants; use a device that holds lines, such as \
         simulated, or loop.hold = \"constant\""
    )]
    HoldsConstant,
    /// A period outside the range of the clock `[s]`.
    #[error("the period is {0} s; allowed: a nanosecond to 10 s")]
    Period(f64),
}

/// Checks that the devices of rotating tools can rotate.
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
