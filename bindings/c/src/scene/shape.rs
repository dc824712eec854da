//! Shapes of tools and bodies.

use std::fmt::Display;
use std::string::ToString;
use std::sync::Arc;

use palpate_world::{Hull, Mesh, Shape as World, SphereAt};

use crate::array::array;
use crate::choice;
use crate::edge::status;
use crate::sized::{self, SizedStruct};
use crate::status::{Refusal, Status};

/// Kind of a shape.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShapeKind {
    /// A sphere of `radius`; for a tool, radius 0 is a point.
    Sphere = 0,
    /// The half-space behind the plane with normal `normal` at distance `offset`; for fixed bodies.
    HalfSpace = 1,
    /// A box of `half_extents`.
    Box = 2,
    /// All points within `radius` of a segment of length 2 `half_length` along z.
    Capsule = 3,
    /// A cylinder of `radius` and a length of 2 `half_length` along z.
    Cylinder = 4,
    /// The triangles `faces` between `points`; for bodies.
    Mesh = 5,
    /// The convex hull of `points`; for bodies.
    Hull = 6,
    /// A sphere of `radius` at each of `points`; for tools.
    Spheres = 7,
}

/// A shape, in the axes of its tool or body. palpate_shape_default() fills it. Functions that take a shape copy its
/// arrays.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    /// Size of this struct; palpate_shape_default() sets it.
    pub struct_size: usize,
    /// One of palpate_shape_kind. Default: PALPATE_SHAPE_KIND_SPHERE.
    pub kind: u32,
    /// Must be 0.
    pub reserved: u32,
    /// Radius [m]. Default: 0.
    pub radius: f64,
    /// Half the length of a capsule's segment or a cylinder [m].
    pub half_length: f64,
    /// Half the length of a box along each axis [m].
    pub half_extents: [f64; 3],
    /// Outward normal of a half-space, of any length above 0. Default: z.
    pub normal: [f64; 3],
    /// Position of a half-space's surface along its normal [m].
    pub offset: f64,
    /// Points of a mesh or hull, or centres of spheres: three numbers per point [m].
    pub points: *const f64,
    /// Number of points.
    pub point_count: usize,
    /// Triangles of a mesh: three point indices each, counter-clockwise as seen from outside.
    pub faces: *const u32,
    /// Number of triangles.
    pub face_count: usize,
}

// SAFETY: `repr(C)`, a `usize` first, numbers and raw pointers only.
unsafe impl SizedStruct for Shape {
    const NAME: &'static str = "palpate_shape";
}

impl Default for Shape {
    fn default() -> Self {
        Self {
            struct_size: size_of::<Self>(),
            kind: ShapeKind::Sphere as u32,
            reserved: 0,
            radius: 0.0,
            half_length: 0.0,
            half_extents: [0.0; 3],
            normal: [0.0, 0.0, 1.0],
            offset: 0.0,
            points: core::ptr::null(),
            point_count: 0,
            faces: core::ptr::null(),
            face_count: 0,
        }
    }
}

impl Shape {
    /// Reads the shape at `shape`. The check of the world validates its lengths.
    ///
    /// # Safety
    /// `shape` is NULL or points to a shape whose first field is its size and whose arrays have the stated numbers of
    /// elements.
    pub(super) unsafe fn at(shape: *const Self) -> Result<World, Refusal<'static>> {
        // SAFETY: guaranteed by the caller.
        let shape = unsafe { sized::read(shape) }?;
        choice::unused(shape.reserved)?;
        let numbers = |error: &dyn Display| Refusal::Numbers(error.to_string());
        let Self {
            radius,
            half_length,
            half_extents,
            normal,
            offset,
            ..
        } = shape;
        let is = |kind: ShapeKind| shape.kind == kind as u32;
        // SAFETY: guaranteed by the caller.
        let points =
            || unsafe { array(shape.points.cast::<[f64; 3]>(), shape.point_count, "points") };
        Ok(if is(ShapeKind::Sphere) {
            World::Sphere { radius }
        } else if is(ShapeKind::HalfSpace) {
            let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
            let is_direction = length > 0.0 && length.is_finite();
            World::HalfSpace {
                normal: if is_direction {
                    normal.map(|x| x / length)
                } else {
                    normal
                },
                offset,
            }
        } else if is(ShapeKind::Box) {
            World::Box { half_extents }
        } else if is(ShapeKind::Capsule) {
            World::Capsule {
                radius,
                half_length,
            }
        } else if is(ShapeKind::Cylinder) {
            World::Cylinder {
                radius,
                half_length,
            }
        } else if is(ShapeKind::Mesh) {
            // SAFETY: guaranteed by the caller.
            let faces =
                unsafe { array(shape.faces.cast::<[u32; 3]>(), shape.face_count, "faces") }?;
            let mesh = Mesh::new(points()?, faces).map_err(|error| numbers(&error))?;
            World::Mesh(Arc::new(mesh))
        } else if is(ShapeKind::Hull) {
            let hull = Hull::around(points()?).map_err(|error| numbers(&error))?;
            World::Hull(Arc::new(hull))
        } else if is(ShapeKind::Spheres) {
            let spheres = points()?.iter();
            let spheres = spheres.map(|&centre| SphereAt { centre, radius });
            World::Spheres {
                spheres: spheres.collect(),
            }
        } else {
            return Err(Refusal::Choice {
                name: "kind",
                given: shape.kind,
                allowed: "one of palpate_shape_kind, 0 to 7",
            });
        })
    }
}

/// Fills a shape with the defaults. `struct_size` is sizeof(palpate_shape).
///
/// # Safety
/// `shape` is NULL, or `struct_size` bytes can be written there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_shape_init(shape: *mut Shape, struct_size: usize) -> Status {
    // SAFETY: guaranteed by the caller.
    status(|| unsafe { sized::fill(shape, struct_size, Shape::default()) })
}
