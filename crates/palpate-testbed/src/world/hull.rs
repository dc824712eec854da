//! A convex solid with flat faces, as a shape.

use std::sync::Arc;

use super::contact::MAX_CORNERS;
use super::mesh::TriangleMesh;
use super::scene::Vector;
use super::vector::Vec3;
use super::wrapping::{Wrapped, normal_of};

/// A part of a hull's surface: a face, the edge between two corners, or a corner, by their numbers. A hull of 64
/// corners has at most 124 faces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum OfHull {
    Face(u8),
    Edge(u8, u8),
    Corner(u8),
}

/// The least convex solid around some points.
#[derive(Debug, Clone, PartialEq)]
pub struct Hull {
    wrapped: Wrapped,
    /// For each face, its outward normal and its offset along it.
    planes: Vec<(Vec3, f64)>,
    mesh: Arc<TriangleMesh>,
}

impl Hull {
    /// Around `points` `[m]`; `None` where they lie in a plane, or the solid has more than 64 corners.
    #[must_use]
    pub fn around(points: &[Vector]) -> Option<Self> {
        let points: Vec<Vec3> = points.iter().map(|&point| Vec3(point)).collect();
        let wrapped = Wrapped::around(&points, MAX_CORNERS)?;
        let number = |corner: usize| u32::try_from(corner).unwrap_or(u32::MAX);
        let mut triangles = Vec::new();
        for face in &wrapped.faces {
            for pair in face[1..].windows(2) {
                triangles.push([face[0], pair[0], pair[1]].map(number));
            }
        }
        let corners: Vec<Vector> = wrapped.corners.iter().map(|corner| corner.0).collect();
        let mesh = Arc::new(TriangleMesh::new(&corners, &triangles).ok()?);
        let planes = wrapped.faces.iter().map(|face| {
            let corners: Vec<Vec3> = face.iter().map(|&corner| wrapped.corners[corner]).collect();
            let normal = normal_of(&corners)?;
            Some((normal, normal.dot(corners[0])))
        });
        Some(Self {
            planes: planes.collect::<Option<_>>()?,
            wrapped,
            mesh,
        })
    }

    /// Its corners `[m]`.
    #[must_use]
    pub fn corners(&self) -> Vec<Vector> {
        self.wrapped.corners.iter().map(|corner| corner.0).collect()
    }

    /// The plane of a face: its normal out of the solid, and how far along it.
    pub(super) fn plane(&self, face: u8) -> (Vec3, f64) {
        self.planes[usize::from(face)]
    }

    pub(super) fn corner(&self, number: u8) -> Vec3 {
        self.wrapped.corners[usize::from(number)]
    }

    /// Returns the part of the surface that is nearest to a point; inside, the face of least depth.
    pub(super) fn nearest_part(&self, point: Vec3) -> OfHull {
        let small = |number: usize| u8::try_from(number).unwrap_or(u8::MAX);
        let heights = self.planes.iter();
        let heights = heights.map(|(normal, offset)| normal.dot(point) - offset);
        let highest = heights
            .clone()
            .enumerate()
            .max_by(|one, other| one.1.total_cmp(&other.1));
        let (face, height) = highest.unwrap_or((0, 0.0));
        if height <= 0.0 {
            return OfHull::Face(small(face));
        }
        let mut nearest = (f64::INFINITY, OfHull::Face(small(face)));
        let mut take = |distance: f64, part: OfHull| {
            if distance < nearest.0 {
                nearest = (distance, part);
            }
        };
        for ((number, face), height) in self.wrapped.faces.iter().enumerate().zip(heights) {
            if height <= 0.0 {
                continue;
            }
            let (normal, _) = self.planes[number];
            let mut is_over = true;
            for (from, to) in face.iter().zip(face.iter().cycle().skip(1)) {
                let (start, along) = (self.wrapped.corners[*from], self.wrapped.corners[*to]);
                let along = along - start;
                let off = point - start;
                is_over &= normal.cross(along).dot(off) >= 0.0;
                let share = along.dot(off) / along.dot(along);
                if share <= 0.0 {
                    take(off.norm(), OfHull::Corner(small(*from)));
                } else if share < 1.0 {
                    // Same name from both sides.
                    let (low, high) = (small(*from.min(to)), small(*from.max(to)));
                    take((off - along * share).norm(), OfHull::Edge(low, high));
                }
            }
            if is_over {
                take(height, OfHull::Face(small(number)));
            }
        }
        nearest.1
    }

    pub(super) fn wrapped(&self) -> &Wrapped {
        &self.wrapped
    }

    /// Its surface by triangles.
    #[must_use]
    pub fn mesh(&self) -> &Arc<TriangleMesh> {
        &self.mesh
    }
}
