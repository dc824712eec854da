//! Nearest point over the whole surface of a mesh.

use super::build::Mesh;
use super::topology::NONE;
use super::triangle::{Region, nearest};
use crate::geometry::rigid::Vector3;
use crate::geometry::solid::{NO_DIRECTION, Nearest};

/// Distance beyond a face, relative to the mesh's reach, above which a corner counts as outside.
const FLAT: f64 = 1e-6;

impl Mesh {
    /// Maximum number of triangles for a convexity test, which compares every corner with every triangle. A closed
    /// surface without holes has twice as many triangles as corners, minus four.
    pub(crate) const MAX_OF_CONVEX: usize = 2 * Self::MAX_CONVEX_CORNERS - 4;

    /// Returns whether the mesh is closed, has at most [`MAX_OF_CONVEX`](Self::MAX_OF_CONVEX) triangles, and has no
    /// corner beyond the plane of a face.
    pub(crate) fn is_convex(&self) -> bool {
        let most = FLAT * self.reach();
        let no_corner_beyond = |(triangle, normal): (u32, &Vector3)| {
            let [corner, ..] = self.corners(triangle);
            let mut places = self.vertices.iter();
            places.all(|place| normal.dot(&(place - corner)) <= most)
        };
        self.is_closed()
            && self.faces.len() <= Self::MAX_OF_CONVEX
            && (0..).zip(&self.topology.normals).all(no_corner_beyond)
    }

    /// Returns the surface point of a convex mesh that is nearest to `place` `[m]`, in the mesh's axes. For an
    /// interior position it is the point of least depth.
    pub(crate) fn nearest_of_convex(&self, place: &Vector3) -> Nearest {
        let Some((distance, triangle)) = nearest_of(self, place) else {
            return Nearest::far();
        };
        let (on_surface, region) = nearest(self.corners(triangle), place);
        let off = place - on_surface;
        let is_outside = side(self, triangle, region, &off).is_some_and(|side| side > 0.0);
        let outward = if is_outside { 1.0 } else { -1.0 };
        let normal = if distance > NO_DIRECTION {
            off * (outward / distance)
        } else {
            self.topology.normals[triangle as usize]
        };
        Nearest::exact(outward * distance, normal)
    }
}

/// Returns the distance of the surface `[m]` and the nearest triangle; `None` for a non-finite position.
pub(super) fn nearest_of(mesh: &Mesh, centre: &Vector3) -> Option<(f64, u32)> {
    let mut best: Option<(f64, u32)> = None;
    mesh.tree.nearest(centre, |number| {
        let (place, _) = nearest(mesh.corners(number), centre);
        let square = (centre - place).norm_squared();
        if best.is_none_or(|(other, _)| square < other) {
            best = Some((square, number));
        }
        best.map_or(f64::INFINITY, |(square, _)| square)
    });
    best.filter(|(square, _)| square.is_finite())
        .map(|(square, triangle)| (square.sqrt(), triangle))
}

/// Returns a positive value in front of the surface, where `off` leads from its nearest point to the centre. Returns
/// `None` beyond the border of an open mesh.
pub(super) fn side(mesh: &Mesh, triangle: u32, region: Region, off: &Vector3) -> Option<f64> {
    let normals = &mesh.topology.normals;
    let own = normals[triangle as usize];
    match region {
        Region::Inside => Some(own.dot(off)),
        Region::Edge(k) => match mesh.topology.neighbours[triangle as usize][k] {
            NONE => None,
            other => Some((own + normals[other as usize]).dot(off)),
        },
        Region::Corner(k) => {
            let corner = mesh.faces[triangle as usize][k];
            Some(mesh.topology.vertex_normals[corner as usize].dot(off))
        }
    }
}
