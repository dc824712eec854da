//! Where the axis of a contact lies in a device, and where a device stands in a world.

use palpate::AlongAxis;
use palpate_device::{Capabilities, Vector};
use palpate_rt::{FrameError, WorldAxis, WorldFrame};

/// Origin `[m]` and direction of a contact's axis in the frame of a device.
pub type Axis = (Vector, Vector);

/// The device's first axis from its origin.
pub const FIRST_AXIS: Axis = ([0.0; 3], [1.0, 0.0, 0.0]);

/// What somebody places, in as many numbers as the device has axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placed {
    /// Where the contact's coordinate is 0 `[m]`.
    Origin,
    /// The direction in which the contact's coordinate grows, of any length.
    Normal,
}

/// Why a contact cannot lie there.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlaceError {
    /// A device with one axis is not placed.
    #[error("the device `{device}` has one axis")]
    OneAxis {
        /// What was placed.
        what: Placed,
        /// Name of the device.
        device: String,
    },
    /// Another number of numbers than the device has axes.
    #[error("{given} numbers for the {axes} axes of the device `{device}`")]
    Count {
        /// What was placed.
        what: Placed,
        /// How many numbers came.
        given: usize,
        /// How many axes the device has.
        axes: usize,
        /// Name of the device.
        device: String,
    },
    /// The normal has no length, or is not finite.
    #[error("no direction; allowed: any that is finite and not 0 in all axes")]
    NoDirection,
    /// The origin is none.
    #[error("{0}")]
    Origin(String),
}

impl PlaceError {
    /// What was placed.
    #[must_use]
    pub fn what(&self) -> Placed {
        match self {
            Self::OneAxis { what, .. } | Self::Count { what, .. } => *what,
            Self::NoDirection => Placed::Normal,
            Self::Origin(_) => Placed::Origin,
        }
    }
}

/// The axis from `origin` `[m]` along `normal`, of any length; where one is `None`, that of the `usual` axis of the
/// device.
///
/// # Errors
/// Another number of numbers than the device has axes, no direction, or an origin that is not finite.
pub fn axis(
    origin: Option<&[f64]>,
    normal: Option<&[f64]>,
    device: &Capabilities,
    usual: Axis,
) -> Result<AlongAxis<f64, 3>, PlaceError> {
    let of = |what, given: Option<&[f64]>, usual| match given {
        None => Ok(usual),
        Some(given) => in_axes(what, given, device),
    };
    let origin = of(Placed::Origin, origin, usual.0)?;
    let normal = of(Placed::Normal, normal, usual.1)?;
    let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
    if !(length.is_finite() && length > 0.0) {
        return Err(PlaceError::NoDirection);
    }
    AlongAxis::new(origin, normal.map(|x| x / length))
        .map_err(|error| PlaceError::Origin(error.to_string()))
}

/// The place with as many axes as the device has.
fn in_axes(what: Placed, given: &[f64], device: &Capabilities) -> Result<Vector, PlaceError> {
    let (axes, count) = (device.axes, given.len());
    if axes == 1 {
        return Err(PlaceError::OneAxis {
            what,
            device: device.name.clone(),
        });
    }
    if count != axes {
        return Err(PlaceError::Count {
            what,
            given: count,
            axes,
            device: device.name.clone(),
        });
    }
    let mut vector = [0.0; 3];
    for (component, value) in vector.iter_mut().zip(given) {
        *component = *value;
    }
    Ok(vector)
}

/// Why a device cannot stand there in a world.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WorldPlaceError {
    /// The origin is none.
    #[error("{0}")]
    Origin(PlaceError),
    /// Another number of axes of the world than the device has.
    #[error("{given} for the {axes} axes of the device `{device}`")]
    Axes {
        /// How many axes of the world came.
        given: usize,
        /// How many axes the device has.
        axes: usize,
        /// Name of the device.
        device: String,
    },
    /// The frame cannot be.
    #[error("{0}")]
    Frame(FrameError),
}

/// Where a device stands in a world whose tool begins at `place` `[m]`: the `origin` of the device `[m]`, or else its
/// `usual` one, is there; where there is neither, the device's frame is the world's. `axes` says which axis of the world
/// each axis of the device is; `None`: the same in order.
///
/// # Errors
/// Another number of numbers or axes than the device has axes, or a frame that cannot be.
pub fn world_frame(
    origin: Option<&[f64]>,
    axes: Option<&[WorldAxis]>,
    device: &Capabilities,
    usual: Option<Vector>,
    place: Vector,
) -> Result<WorldFrame, WorldPlaceError> {
    let origin = match origin {
        Some(origin) => {
            Some(in_axes(Placed::Origin, origin, device).map_err(WorldPlaceError::Origin)?)
        }
        None => usual,
    };
    let axes = match axes {
        Some(axes) if axes.len() != device.axes => {
            return Err(WorldPlaceError::Axes {
                given: axes.len(),
                axes: device.axes,
                device: device.name.clone(),
            });
        }
        Some(axes) => axes.to_vec(),
        None => (0..device.axes.min(3)).map(WorldAxis::along).collect(),
    };
    let mut along = [None; 3];
    for (along, axis) in along.iter_mut().zip(&axes) {
        *along = Some(*axis);
    }
    let (origin, place) = match origin {
        Some(origin) => (origin, place),
        // The device's own places are the world's; where it has no axis the tool is at its place.
        None => {
            let mut own = place;
            for axis in &axes {
                own[axis.axis] = 0.0;
            }
            ([0.0; 3], own)
        }
    };
    WorldFrame::new(along, origin, place).map_err(WorldPlaceError::Frame)
}
