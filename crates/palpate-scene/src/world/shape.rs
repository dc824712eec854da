//! Shapes as a file gives them.

use std::path::Path;

use palpate_world::{Shape, SphereAt, Vector};
use serde::Deserialize;

use super::mesh::{RawHull, RawMesh, ReadMesh};

/// A shape by its name; lengths as one measures them, from side to side.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename = "shape", rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum RawShape {
    Sphere {
        radius_m: f64,
    },
    Spheres(Vec<RawSphere>),
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
    Mesh(RawMesh),
    Hull(RawHull),
}

/// A sphere of a tool that has several.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawSphere {
    centre_m: Vector,
    #[serde(default)]
    radius_m: f64,
}

impl RawShape {
    /// Whether it is a point: a sphere of radius 0.
    pub fn is_point(&self) -> bool {
        matches!(self, Self::Sphere { radius_m } if *radius_m == 0.0)
    }

    /// Its lengths, each with its key: all have to be above 0.
    pub fn lengths(&self) -> Vec<(&'static str, f64)> {
        match *self {
            Self::Sphere { radius_m } => vec![("radius_m", radius_m)],
            Self::Spheres(ref spheres) => {
                let radii = spheres.iter().map(|sphere| sphere.radius_m);
                radii.map(|radius| ("radius_m", radius)).collect()
            }
            Self::HalfSpace { .. } | Self::Mesh(_) | Self::Hull(_) => vec![],
            Self::Box { size_m } => size_m.map(|length| ("size_m", length)).into(),
            Self::Capsule { radius_m, length_m } | Self::Cylinder { radius_m, length_m } => {
                vec![("radius_m", radius_m), ("length_m", length_m)]
            }
        }
    }

    /// Returns the shape, with a note for the user; file names are relative to `folder`. A normal may have any length
    /// above 0.
    pub fn shape(self, folder: &Path) -> Result<ReadMesh, String> {
        let shape = match self {
            Self::Mesh(mesh) => return mesh.read(folder),
            Self::Hull(hull) => return hull.read(folder),
            Self::Sphere { radius_m } => Shape::Sphere { radius: radius_m },
            Self::Spheres(spheres) => Shape::Spheres {
                spheres: spheres
                    .into_iter()
                    .map(|sphere| SphereAt {
                        centre: sphere.centre_m,
                        radius: sphere.radius_m,
                    })
                    .collect(),
            },
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
        };
        Ok(ReadMesh { shape, note: None })
    }
}

/// Returns the vector scaled to length 1. A vector without direction is returned unchanged; the checks of a world
/// reject it.
pub(crate) fn unit<const N: usize>(vector: [f64; N]) -> [f64; N] {
    // The largest part first, so that no square overflows or vanishes.
    let largest = vector
        .iter()
        .fold(0.0_f64, |most, part| most.max(part.abs()));
    if vector.iter().any(|part| !part.is_finite()) || largest == 0.0 {
        return vector;
    }
    let vector = vector.map(|part| part / largest);
    let length = vector.iter().map(|part| part * part).sum::<f64>().sqrt();
    vector.map(|part| part / length)
}
