//! Triangle meshes: checked once, then asked for what a sphere touches.

mod build;
mod cluster;
mod gather;
mod mass;
mod nearest;
mod surface;
mod topology;
mod tree;
mod triangle;

pub use build::{Mesh, MeshError};
pub use mass::MassProperties;
pub(crate) use surface::{POINTS_PER_MESH, Surface};
pub(crate) use triangle::nearest_point as nearest_of_triangle;
