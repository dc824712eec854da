//! Contact with triangle meshes, compared with the shapes that they approximate.

pub mod common;
mod distance_grid;
mod grids;
mod moving;
mod parts;
mod refusals;
mod sides;
mod surfaces;
