//! Shapes of tools and bodies.

use std::sync::Arc;

use crate::{Hull, Mesh, Vector};

/// A shape, in the own axes of the tool or body that has it.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// All points within a radius above 0 of the centre. A tool may have radius 0: a point.
    Sphere {
        /// Radius `[m]`.
        radius: f64,
    },
    /// All points x with n . x <= offset: the normal points out of the solid. For fixed bodies only.
    HalfSpace {
        /// Unit vector out of the solid.
        normal: Vector,
        /// Where the surface is along the normal `[m]`.
        offset: f64,
    },
    /// Several spheres, each of which has the whole law of a contact. For tools only.
    Spheres {
        /// At least one.
        spheres: Vec<SphereAt>,
    },
    /// A block along the body's own axes.
    Box {
        /// Half of its length along each axis, above 0 `[m]`.
        half_extents: Vector,
    },
    /// All points within a radius of a segment along the body's own z axis.
    Capsule {
        /// Radius, above 0 `[m]`.
        radius: f64,
        /// Half of the segment's length, above 0 `[m]`.
        half_length: f64,
    },
    /// A cylinder along the body's own z axis.
    Cylinder {
        /// Radius, above 0 `[m]`.
        radius: f64,
        /// Half of its length, above 0 `[m]`.
        half_length: f64,
    },
    /// A surface of triangles, in the own axes of the tool or body. That of a tool has a shell of points; a body that moves may
    /// need [`Body::balanced`](crate::Body::balanced).
    Mesh(Arc<Mesh>),
    /// A convex solid with flat faces, in the body's own axes. For bodies only; one that moves may need
    /// [`Body::balanced`](crate::Body::balanced).
    Hull(Arc<Hull>),
}

/// A sphere of a tool that has several.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereAt {
    /// Its centre, in the tool's own axes `[m]`.
    pub centre: Vector,
    /// Its radius, 0 for a point `[m]`.
    pub radius: f64,
}
