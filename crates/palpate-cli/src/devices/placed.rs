//! Placement of a contact in a device, and of a device in a world, from flags.

use palpate_core::AlongAxis;
use palpate_device::{Capabilities, Vector};
use palpate_drivers::prepared::{Axis, PlaceError, Placed, WorldPlaceError};
use palpate_rt::WorldFrame;

use super::DeviceArguments;
use crate::failure::Failure;

/// Returns the axis from the flags, or the `usual` one of the device.
pub fn axis(
    arguments: &DeviceArguments,
    device: &Capabilities,
    usual: Axis,
) -> Result<AlongAxis<f64, 3>, Failure> {
    let origin = arguments.origin.as_ref().map(|place| &place.0[..]);
    let normal = arguments.normal.as_ref().map(|place| &place.0[..]);
    palpate_drivers::prepared::axis(origin, normal, device, usual)
        .map_err(|error| refused(arguments, &error))
}

/// Returns the frame of a device in a world whose tool starts at `place` `[m]`. The `usual` position of the device, or
/// that of `--origin`, is mapped to it. `None`: the device's frame is the world's.
pub fn frame(
    arguments: &DeviceArguments,
    device: &Capabilities,
    usual: Option<Vector>,
    place: Vector,
) -> Result<WorldFrame, Failure> {
    let origin = arguments.origin.as_ref().map(|place| &place.0[..]);
    let axes = arguments.world_axes.as_ref();
    let frame = palpate_drivers::prepared::world_frame(
        origin,
        axes.map(|axes| &axes.0[..]),
        device,
        usual,
        place,
    );
    frame.map_err(|error| match error {
        WorldPlaceError::Origin(error) => refused(arguments, &error),
        WorldPlaceError::Axes { .. } => Failure::Arguments(match axes {
            Some(axes) => format!("--world-axes {axes}: {error}"),
            None => error.to_string(),
        }),
        WorldPlaceError::Frame(error) => Failure::Arguments(error.to_string()),
    })
}

fn refused(arguments: &DeviceArguments, error: &PlaceError) -> Failure {
    let (flag, given) = match error.what() {
        Placed::Origin => ("--origin", &arguments.origin),
        Placed::Normal => ("--normal", &arguments.normal),
    };
    Failure::Arguments(match given {
        Some(given) => format!("{flag} {given}: {error}"),
        None => format!("{flag}: {error}"),
    })
}
