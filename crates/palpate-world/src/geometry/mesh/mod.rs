//! Triangle meshes: construction with checks, and contact queries for spheres.

mod build;
mod cluster;
mod distance_grid;
mod gather;
mod hollow;
mod mass;
mod nearest;
mod parts;
mod point_shell;
mod spared;
mod surface;
mod topology;
mod tree;
mod triangle;

pub use build::{Mesh, MeshError};
pub use distance_grid::{DistanceGrid, GridBytesError, GridError, InvalidGrid};
pub use mass::MassProperties;
pub use point_shell::{InvalidShell, PointShell};
pub(crate) use surface::{POINTS_PER_MESH, Surface};
pub(crate) use triangle::nearest_point as nearest_of_triangle;
