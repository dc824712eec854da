//! Shapes of tools and bodies.

use std::sync::Arc;

use crate::geometry::rigid::Vector3;
use crate::{Hull, Mesh, Vector};

/// A shape, in the axes of its tool or body.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// All points within a radius above 0 of the centre. A tool may have radius 0: a point.
    Sphere {
        /// Radius `[m]`.
        radius: f64,
    },
    /// All points x with n . x <= offset: the normal points out of the solid. For fixed bodies only.
    HalfSpace {
        /// Outward unit normal.
        normal: Vector,
        /// Position of the surface along the normal `[m]`.
        offset: f64,
    },
    /// Several spheres, each with the whole law of a contact. For tools only.
    Spheres {
        /// The spheres; at least one.
        spheres: Vec<SphereAt>,
    },
    /// A box along the body's axes.
    Box {
        /// Half of its length along each axis, above 0 `[m]`.
        half_extents: Vector,
    },
    /// All points within a radius of a segment along the body's z axis.
    Capsule {
        /// Radius, above 0 `[m]`.
        radius: f64,
        /// Half of the segment's length, above 0 `[m]`.
        half_length: f64,
    },
    /// A cylinder along the body's z axis.
    Cylinder {
        /// Radius, above 0 `[m]`.
        radius: f64,
        /// Half of its length, above 0 `[m]`.
        half_length: f64,
    },
    /// A triangle surface, in the axes of the tool or body. The mesh of a tool needs a point shell. A moving body may
    /// need [`Body::balanced`](crate::Body::balanced).
    Mesh(Arc<Mesh>),
    /// A convex solid with flat faces, in the body's axes. For bodies only; a moving body may need
    /// [`Body::balanced`](crate::Body::balanced).
    Hull(Arc<Hull>),
}

impl Shape {
    /// Returns the half-extents of the smallest box about its origin along its own axes `[m]`.
    pub(crate) fn half_extents(&self) -> Vector3 {
        let around = |places: &[Vector]| {
            let each = places.iter().map(|place| Vector3::from(*place).abs());
            each.fold(Vector3::zeros(), |most, place| most.sup(&place))
        };
        match self {
            Self::Sphere { radius } => Vector3::repeat(*radius),
            Self::HalfSpace { .. } => Vector3::repeat(f64::INFINITY),
            Self::Spheres { spheres } => {
                let each = spheres.iter().map(|sphere| {
                    Vector3::from(sphere.centre).abs() + Vector3::repeat(sphere.radius)
                });
                each.fold(Vector3::zeros(), |most, place| most.sup(&place))
            }
            Self::Box { half_extents } => Vector3::from(*half_extents),
            Self::Capsule {
                radius,
                half_length,
            } => Vector3::new(*radius, *radius, radius + half_length),
            Self::Cylinder {
                radius,
                half_length,
            } => Vector3::new(*radius, *radius, *half_length),
            Self::Mesh(mesh) => around(&mesh.vertices()),
            Self::Hull(hull) => around(&hull.mesh().vertices()),
        }
    }
}

/// One of several spheres of a tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereAt {
    /// Centre, in the tool's axes `[m]`.
    pub centre: Vector,
    /// Radius, 0 for a point `[m]`.
    pub radius: f64,
}
