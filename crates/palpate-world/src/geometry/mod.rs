//! Shapes: hulls, meshes and the solids that contacts compute with; rotations, axes and inertia.

pub(crate) mod axes;
pub(crate) mod convex;
pub(crate) mod coplanar;
pub(crate) mod hull;
pub(crate) mod inertia;
pub(crate) mod mesh;
pub(crate) mod rigid;
pub(crate) mod shape;
pub(crate) mod solid;
pub(crate) mod turning;
