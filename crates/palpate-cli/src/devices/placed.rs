//! Where the axis of the contact lies in a device.

use palpate::AlongAxis;
use palpate_device::{Capabilities, Vector};

use super::DeviceArguments;
use crate::failure::Failure;
use crate::values::Place;

/// Origin `[m]` and direction of the axis, if no flag says otherwise.
pub type Axis = (Vector, Vector);

/// The device's first axis from its origin.
pub const FIRST_AXIS: Axis = ([0.0; 3], [1.0, 0.0, 0.0]);

/// The axis that the flags place, or else the `usual` one of the device.
pub fn axis(
    arguments: &DeviceArguments,
    device: &Capabilities,
    usual: Axis,
) -> Result<AlongAxis<f64, 3>, Failure> {
    let of = |flag: &str, place: &Option<Place>, usual: Vector| match place {
        None => Ok(usual),
        Some(place) => in_axes(place, device)
            .map_err(|why| Failure::Arguments(format!("{flag} {place}: {why}"))),
    };
    let origin = of("--origin", &arguments.origin, usual.0)?;
    let normal = of("--normal", &arguments.normal, usual.1)?;
    let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
    if !(length.is_finite() && length > 0.0) {
        return Err(Failure::Arguments(
            "--normal has no direction; allowed: any that is not 0 in all axes".into(),
        ));
    }
    AlongAxis::new(origin, normal.map(|x| x / length))
        .map_err(|error| Failure::Arguments(format!("--origin: {error}")))
}

/// The place with as many axes as the device has.
pub fn in_axes(place: &Place, device: &Capabilities) -> Result<Vector, String> {
    let (axes, given) = (device.axes, place.0.len());
    if axes == 1 {
        return Err(format!("the device `{}` has one axis", device.name));
    }
    if given != axes {
        return Err(format!(
            "{given} numbers for the {axes} axes of the device `{}`",
            device.name
        ));
    }
    let mut vector = [0.0; 3];
    for (component, value) in vector.iter_mut().zip(&place.0) {
        *component = *value;
    }
    Ok(vector)
}
