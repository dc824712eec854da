//! A mesh as a host queries it.

use crate::low_rate_simulator::vector::{Vector, cross, dot, length, less, sum, times};

#[derive(Debug)]
pub struct Facets(Vec<Facet>);

#[derive(Debug)]
struct Facet {
    corners: [Vector; 3],
    centre: Vector,
    /// Farthest corner from the centre.
    radius: f64,
}

impl Facets {
    pub fn new(vertices: &[Vector], faces: &[[u32; 3]]) -> Self {
        let facets = faces.iter().map(|face| {
            let corners = face.map(|corner| vertices[corner as usize]);
            let centre = times(corners.into_iter().fold([0.0; 3], sum), 1.0 / 3.0);
            let radii = corners.map(|corner| length(less(corner, centre)));
            Facet {
                corners,
                centre,
                radius: radii.into_iter().fold(0.0, f64::max),
            }
        });
        Self(facets.collect())
    }

    /// The nearest point to one that is outside.
    pub fn nearest(&self, point: Vector) -> Vector {
        let (mut best, mut nearest) = (f64::INFINITY, point);
        for facet in &self.0 {
            let from = less(point, facet.centre);
            let reach = best + facet.radius;
            if dot(from, from) > reach * reach {
                continue;
            }
            let candidate = facet.nearest(point);
            let distance = length(less(point, candidate));
            if distance < best {
                (best, nearest) = (distance, candidate);
            }
        }
        nearest
    }
}

impl Facet {
    fn nearest(&self, point: Vector) -> Vector {
        let [a, b, c] = self.corners;
        let normal = cross(less(b, a), less(c, a));
        let square = dot(normal, normal);
        let over = less(point, times(normal, dot(less(point, a), normal) / square));
        let is_left =
            |from: Vector, to: Vector| dot(cross(less(to, from), less(over, from)), normal) >= 0.0;
        if is_left(a, b) && is_left(b, c) && is_left(c, a) {
            return over;
        }
        let on_edges = [(a, b), (b, c), (c, a)].map(|(from, to)| {
            let edge = less(to, from);
            let share = dot(less(point, from), edge) / dot(edge, edge);
            sum(from, times(edge, share.clamp(0.0, 1.0)))
        });
        let far = |place: &Vector| length(less(point, *place));
        on_edges
            .into_iter()
            .min_by(|one, other| far(one).total_cmp(&far(other)))
            .unwrap()
    }
}
