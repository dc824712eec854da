//! Moments of inertia of the volume inside a closed mesh, from integrals over its surface.

use super::triangles::TriangleMesh;
use crate::world::scene::Vector;
use crate::world::vector::Vec3;

/// Places on a triangle and their weights, by which a polynomial of third degree is integrated exactly.
const PLACES: [([f64; 3], f64); 4] = [
    ([1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0], -27.0 / 48.0),
    ([0.6, 0.2, 0.2], 25.0 / 48.0),
    ([0.2, 0.6, 0.2], 25.0 / 48.0),
    ([0.2, 0.2, 0.6], 25.0 / 48.0),
];

impl TriangleMesh {
    /// Whether each edge has two faces.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.edges.iter().all(|edge| edge.faces.len() == 2)
    }

    /// Returns the moments of inertia `[kg m²]` about the origin along the axes of a body of `mass` `[kg]` that fills
    /// the mesh evenly; infinite for an open mesh. The axes should be principal ones: products of inertia are ignored.
    ///
    /// Uses the divergence theorem: ∫ x² dV = ∫ x³/3 n_x dA, and ∫ dV = ∫ x n_x dA for the volume.
    #[must_use]
    pub fn inertia(&self, mass: f64) -> Vector {
        if !self.is_closed() {
            return [f64::INFINITY; 3];
        }
        let (mut volume, mut squares) = (0.0, [0.0; 3]);
        for face in &self.faces {
            let [a, b, c] = face.map(|corner| self.vertices[corner]);
            let area = (b - a).cross(c - a) * 0.5; // the normal times the area
            for ([u, v, w], weight) in PLACES {
                let Vec3(place) = a * u + b * v + c * w;
                volume += weight * area.0[0] * place[0];
                for axis in 0..3 {
                    squares[axis] += weight * area.0[axis] * place[axis].powi(3) / 3.0;
                }
            }
        }
        let [x, y, z] = squares.map(|square| square * mass / volume);
        [y + z, z + x, x + y]
    }
}
