//! Position of a contact's axis and of a world in the frame of a device.

use palpate_core::AlongAxis;
use palpate_device::{Capabilities, Vector};
use palpate_rt::{FrameError, WorldAxis, WorldFrame};

/// Origin `[m]` and direction of a contact's axis in the frame of a device.
pub type Axis = (Vector, Vector);

/// Axis through the device's origin along its first axis.
pub const FIRST_AXIS: Axis = ([0.0; 3], [1.0, 0.0, 0.0]);

/// Vector given by the user, with one component per axis of the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placed {
    /// Position at which the contact's coordinate is 0 `[m]`.
    Origin,
    /// Direction in which the contact's coordinate increases, of any length.
    Normal,
}

/// Reason for rejecting the axis of a contact.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlaceError {
    /// A device with one axis accepts neither origin nor normal.
    #[error("the device `{device}` has one axis")]
    OneAxis {
        /// The rejected vector.
        what: Placed,
        /// Name of the device.
        device: String,
    },
    /// The number of components differs from the number of axes of the device.
    #[error("{given} numbers for the {axes} axes of the device `{device}`")]
    Count {
        /// The rejected vector.
        what: Placed,
        /// Number of components given.
        given: usize,
        /// Number of axes of the device.
        axes: usize,
        /// Name of the device.
        device: String,
    },
    /// The normal has zero length or is not finite.
    #[error("not a direction; allowed: finite, and not 0 in all axes")]
    NoDirection,
    /// The origin is invalid.
    #[error("{0}")]
    Origin(String),
}

impl PlaceError {
    /// Returns the rejected vector.
    #[must_use]
    pub fn what(&self) -> Placed {
        match self {
            Self::OneAxis { what, .. } | Self::Count { what, .. } => *what,
            Self::NoDirection => Placed::Normal,
            Self::Origin(_) => Placed::Origin,
        }
    }
}

/// Returns the axis from `origin` `[m]` along `normal`, of any length. `None` selects the value of `usual`.
///
/// # Errors
/// A number of components that differs from the number of axes of the device, a zero or non-finite normal, or an
/// origin that is not finite.
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

/// Returns `given` as a vector, if its length is the number of axes of the device.
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

/// Reason for rejecting the frame of a device in a world.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WorldPlaceError {
    /// The origin is invalid.
    #[error("{0}")]
    Origin(PlaceError),
    /// The number of world axes differs from the number of axes of the device.
    #[error("{given} for the {axes} axes of the device `{device}`")]
    Axes {
        /// Number of world axes given.
        given: usize,
        /// Number of axes of the device.
        axes: usize,
        /// Name of the device.
        device: String,
    },
    /// The frame is invalid.
    #[error("{0}")]
    Frame(FrameError),
}

/// Returns the frame of a device in a world whose tool begins at `place` `[m]`. The point `origin` of the device
/// `[m]`, by default `usual`, coincides with `place`; without either, the two frames coincide. `axes` assigns a world
/// axis to each axis of the device; `None`: in the same order.
///
/// # Errors
/// A number of components or axes that differs from the number of axes of the device, or an invalid frame.
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
        // Device coordinates equal world coordinates; on axes that the device lacks, the tool keeps its position
        // `place`.
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
