//! Triangle meshes, and their contacts with a sphere.

pub mod gallery;
mod hollow;
mod mass;
mod parts;
mod search;
mod triangles;

pub(super) use parts::{OnMesh, nearest};
pub(super) use search::{MAX_CONTACTS, wanted};
pub use triangles::{InvalidMesh, TriangleMesh};
