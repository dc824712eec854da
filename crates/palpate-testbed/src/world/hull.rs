//! A convex solid with flat faces, as a shape.

use std::sync::Arc;

use super::contact::MOST_CORNERS;
use super::mesh::TriangleMesh;
use super::scene::Vector;
use super::vector::Vec3;
use super::wrapping::Wrapped;

/// The least convex solid around some points.
#[derive(Debug, Clone, PartialEq)]
pub struct Hull {
    wrapped: Wrapped,
    mesh: Arc<TriangleMesh>,
}

impl Hull {
    /// Around `points` \[m\]; `None` where they lie in a plane, or the solid has more than 64 corners.
    #[must_use]
    pub fn around(points: &[Vector]) -> Option<Self> {
        let points: Vec<Vec3> = points.iter().map(|&point| Vec3(point)).collect();
        let wrapped = Wrapped::around(&points, MOST_CORNERS)?;
        let number = |corner: usize| u32::try_from(corner).unwrap_or(u32::MAX);
        let mut triangles = Vec::new();
        for face in &wrapped.faces {
            for pair in face[1..].windows(2) {
                triangles.push([face[0], pair[0], pair[1]].map(number));
            }
        }
        let corners: Vec<Vector> = wrapped.corners.iter().map(|corner| corner.0).collect();
        let mesh = Arc::new(TriangleMesh::new(&corners, &triangles).ok()?);
        Some(Self { wrapped, mesh })
    }

    /// Its corners \[m\].
    #[must_use]
    pub fn corners(&self) -> Vec<Vector> {
        self.wrapped.corners.iter().map(|corner| corner.0).collect()
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
