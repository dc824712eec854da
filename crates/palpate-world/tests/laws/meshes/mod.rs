//! Laws of contact with triangle meshes, each beside the shape that the mesh is one of.

mod common;
mod distance_grid;
mod grids;
mod moving;
mod parts;
mod refusals;
mod sides;
mod surfaces;
