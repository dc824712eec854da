//! Faces, edges and vertices of a mesh, each with a smooth formula for its distance and its normal.

use super::triangles::TriangleMesh;
use crate::world::vector::Vec3;

/// A face, an edge or a vertex, by its number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(in crate::world) enum Part {
    Face(usize),
    Edge(usize),
    Vertex(usize),
}

/// State of a contact with a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::world) enum OnMesh {
    /// No contact.
    Nothing,
    /// The sphere has been inside since the start.
    Inside,
    /// Up to three parts that push together from in front of the surface.
    Before([Option<Part>; 3]),
    /// A part that pulls from behind the surface.
    Behind(Part),
}

/// Position of a part relative to a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Lie {
    /// Distance of the point in front of it, negative behind a face `[m]`.
    pub distance: f64,
    /// Unit vector from it to the point, for a face out of the solid.
    pub normal: Vec3,
    /// Rate of the normal while the point moves with the velocity that was given.
    pub rate: Vec3,
}

impl TriangleMesh {
    /// Returns the position of `part` relative to a moving point.
    pub(super) fn lie(&self, part: Part, point: Vec3, velocity: Vec3) -> Lie {
        let round = |off: Vec3, moving: Vec3, fallback: Vec3| {
            let distance = off.norm();
            let normal = off.direction().unwrap_or(fallback);
            let rate = if distance > 0.0 {
                moving.across(normal) * (1.0 / distance)
            } else {
                Vec3::ZERO
            };
            Lie {
                distance,
                normal,
                rate,
            }
        };
        match part {
            Part::Face(face) => {
                let normal = self.normals[face];
                Lie {
                    distance: normal.dot(point - self.vertices[self.faces[face][0]]),
                    normal,
                    rate: Vec3::ZERO,
                }
            }
            Part::Edge(edge) => {
                let [from, to] = self.edges[edge].ends.map(|end| self.vertices[end]);
                let along = (to - from).direction().unwrap_or(Vec3::ZERO);
                let fallback = self.normals[self.edges[edge].faces[0]];
                round(
                    (point - from).across(along),
                    velocity.across(along),
                    fallback,
                )
            }
            Part::Vertex(vertex) => {
                let fallback = self.normals[self.faces_at[vertex][0]];
                round(point - self.vertices[vertex], velocity, fallback)
            }
        }
    }
}

/// Returns the penetration `[m]` of a sphere, the unit normal, and its rate, for a sphere whose centre moves with
/// `velocity`, by the formula of the contact's part. All vectors are in the mesh's axes.
pub(in crate::world) fn nearest(
    mesh: &TriangleMesh,
    at: OnMesh,
    radius: f64,
    centre: Vec3,
    velocity: Vec3,
) -> (f64, Vec3, Vec3) {
    match at {
        OnMesh::Nothing | OnMesh::Inside => (-1.0, Vec3([0.0, 0.0, 1.0]), Vec3::ZERO),
        OnMesh::Behind(part @ Part::Face(_)) => {
            let lie = mesh.lie(part, centre, velocity);
            (radius - lie.distance, lie.normal, lie.rate)
        }
        OnMesh::Behind(part) => {
            let lie = mesh.lie(part, centre, velocity);
            (radius + lie.distance, -lie.normal, -lie.rate)
        }
        OnMesh::Before(parts) => {
            let lies: Vec<Lie> = parts
                .iter()
                .flatten()
                .map(|&part| mesh.lie(part, centre, velocity))
                .collect();
            if let [lie] = lies[..] {
                return (radius - lie.distance, lie.normal, lie.rate);
            }
            together(&lies, radius, velocity)
        }
    }
}

/// The shortest way d that ends on all of several surfaces, n·d = radius − distance for each: its length, its direction
/// and the rate of that.
fn together(lies: &[Lie], radius: f64, velocity: Vec3) -> (f64, Vec3, Vec3) {
    let depths: Vec<f64> = lies.iter().map(|lie| radius - lie.distance).collect();
    let normals: Vec<Vec3> = lies.iter().map(|lie| lie.normal).collect();
    let Some(shares) = shares(&normals, &depths) else {
        return (depths[0], normals[0], lies[0].rate);
    };
    let sum = |vectors: &dyn Fn(usize) -> Vec3, shares: &[f64]| {
        let mut sum = Vec3::ZERO;
        for (number, share) in shares.iter().enumerate() {
            sum += vectors(number) * *share;
        }
        sum
    };
    let way = sum(&|number| normals[number], &shares);
    // n·d' = depth' − n'·d, and d' = Σ share' n + Σ share n'.
    let turned = sum(&|number| lies[number].rate, &shares);
    let rates: Vec<f64> = lies
        .iter()
        .map(|lie| -lie.normal.dot(velocity) - lie.rate.dot(way) - lie.normal.dot(turned))
        .collect();
    let share_rates = self::shares(&normals, &rates).unwrap_or_else(|| vec![0.0; lies.len()]);
    let way_rate = turned + sum(&|number| normals[number], &share_rates);
    let depth = way.norm();
    let normal = way.direction().unwrap_or(normals[0]);
    (depth, normal, way_rate.across(normal) * (1.0 / depth))
}

/// The shares of up to three normals in the shortest vector with these products with them; none if they are dependent.
pub(super) fn shares(normals: &[Vec3], products: &[f64]) -> Option<Vec<f64>> {
    let size = normals.len();
    let mut rows: Vec<Vec<f64>> = (0..size)
        .map(|i| {
            let mut row: Vec<f64> = normals.iter().map(|n| n.dot(normals[i])).collect();
            row.push(products[i]);
            row
        })
        .collect();
    for pivot in 0..size {
        let best =
            (pivot..size).max_by(|&a, &b| rows[a][pivot].abs().total_cmp(&rows[b][pivot].abs()))?;
        rows.swap(pivot, best);
        if rows[pivot][pivot].abs() < 1e-13 {
            return None;
        }
        let by = rows[pivot].clone();
        for (number, row) in rows.iter_mut().enumerate() {
            if number != pivot {
                let factor = row[pivot] / by[pivot];
                for (entry, by) in row.iter_mut().zip(&by) {
                    *entry -= factor * by;
                }
            }
        }
    }
    Some((0..size).map(|i| rows[i][size] / rows[i][i]).collect())
}
