//! Shapes as a file gives them.

use palpate_world::{Shape, Vector};
use serde::Deserialize;

/// A shape by its name; lengths as one measures them, from side to side.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum RawShape {
    Sphere {
        radius_m: f64,
    },
    HalfSpace {
        normal: Vector,
        #[serde(default)]
        offset_m: f64,
    },
    Box {
        size_m: Vector,
    },
    Capsule {
        radius_m: f64,
        length_m: f64,
    },
    Cylinder {
        radius_m: f64,
        length_m: f64,
    },
}

impl RawShape {
    /// Its lengths, each with its key: all have to be above 0.
    pub fn lengths(&self) -> Vec<(&'static str, f64)> {
        match *self {
            Self::Sphere { radius_m } => vec![("radius_m", radius_m)],
            Self::HalfSpace { .. } => vec![],
            Self::Box { size_m } => size_m.map(|length| ("size_m", length)).into(),
            Self::Capsule { radius_m, length_m } | Self::Cylinder { radius_m, length_m } => {
                vec![("radius_m", radius_m), ("length_m", length_m)]
            }
        }
    }

    /// The shape. A normal may have any length above 0.
    pub fn shape(self) -> Shape {
        match self {
            Self::Sphere { radius_m } => Shape::Sphere { radius: radius_m },
            Self::HalfSpace { normal, offset_m } => Shape::HalfSpace {
                normal: unit(normal),
                offset: offset_m,
            },
            Self::Box { size_m } => Shape::Box {
                half_extents: size_m.map(|length| 0.5 * length),
            },
            Self::Capsule { radius_m, length_m } => Shape::Capsule {
                radius: radius_m,
                half_length: 0.5 * length_m,
            },
            Self::Cylinder { radius_m, length_m } => Shape::Cylinder {
                radius: radius_m,
                half_length: 0.5 * length_m,
            },
        }
    }
}

/// The vector at length 1, or as it is where it has no direction, which the checks of a world find.
pub(super) fn unit<const N: usize>(vector: [f64; N]) -> [f64; N] {
    let length = vector.iter().map(|part| part * part).sum::<f64>().sqrt();
    if length > 0.0 && length.is_finite() {
        vector.map(|part| part / length)
    } else {
        vector
    }
}
