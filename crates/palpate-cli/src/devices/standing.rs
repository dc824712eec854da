//! Where a device stands in a world.

use palpate_device::{Capabilities, Vector};
use palpate_rt::{WorldAxis, WorldFrame};

use super::DeviceArguments;
use super::placed::in_axes;
use crate::failure::Failure;
use crate::values::WorldAxes;

/// Where the flags put a device in a world whose tool begins at `place` `[m]`: the `usual` place of the device is there
/// unless `--origin` names another. `None`: the device's frame is the world's.
pub fn frame(
    arguments: &DeviceArguments,
    device: &Capabilities,
    usual: Option<Vector>,
    place: Vector,
) -> Result<WorldFrame, Failure> {
    let origin = match &arguments.origin {
        Some(origin) => Some(
            in_axes(origin, device)
                .map_err(|why| Failure::Arguments(format!("--origin {origin}: {why}")))?,
        ),
        None => usual,
    };
    let axes = match &arguments.world_axes {
        Some(axes) if axes.0.len() != device.axes => {
            return Err(Failure::Arguments(format!(
                "--world-axes {axes}: {} for the {} axes of the device `{}`",
                axes.0.len(),
                device.axes,
                device.name
            )));
        }
        Some(axes) => axes.clone(),
        None => WorldAxes((0..device.axes.min(3)).map(WorldAxis::along).collect()),
    };
    let mut along = [None; 3];
    for (along, axis) in along.iter_mut().zip(&axes.0) {
        *along = Some(*axis);
    }
    let (origin, place) = match origin {
        Some(origin) => (origin, place),
        // The device's own places are the world's; where it has no axis the tool is at its place.
        None => {
            let mut own = place;
            for axis in &axes.0 {
                own[axis.axis] = 0.0;
            }
            ([0.0; 3], own)
        }
    };
    WorldFrame::new(along, origin, place).map_err(|error| Failure::Arguments(error.to_string()))
}
