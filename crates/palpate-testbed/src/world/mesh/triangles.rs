//! A surface of triangles: its parts, and a grid to find them by.

use std::collections::HashMap;
use std::fmt;
use std::sync::Arc;

use thiserror::Error;

use crate::world::field::Field;
use crate::world::scene::Vector;
use crate::world::vector::Vec3;

/// Cosine of the angle between normals above which their faces are separate surfaces: 30°.
pub(super) const SHARP: f64 = 0.866_025_403_784_438_6;
/// Sine of the angle below which an edge counts as flat, neither convex nor concave.
const FLAT: f64 = 1e-3;

/// A triangle mesh that is not one.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("triangle {triangle} of the mesh: {reason}")]
#[non_exhaustive]
pub struct InvalidMesh {
    /// Number of the triangle, from 0.
    pub triangle: usize,
    /// Reason for rejecting it.
    pub reason: &'static str,
}

/// An edge: its ends, and the faces on its sides.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Edge {
    pub ends: [usize; 2],
    pub faces: Vec<usize>,
    /// Whether it is not convex and its faces differ by less than 30°.
    pub is_bend: bool,
}

/// A surface of triangles; seen from outside, their corners run counter-clockwise.
#[derive(Clone, PartialEq)]
pub struct TriangleMesh {
    pub(super) vertices: Vec<Vec3>,
    pub(super) faces: Vec<[usize; 3]>,
    /// Unit normals of the faces.
    pub(super) normals: Vec<Vec3>,
    pub(super) edges: Vec<Edge>,
    /// Edge k of a face goes from its corner k to the next.
    pub(super) edges_of: Vec<[usize; 3]>,
    pub(super) edges_at: Vec<Vec<usize>>,
    pub(super) faces_at: Vec<Vec<usize>>,
    /// A ball around each face: its centre and radius `[m]`.
    balls: Vec<(Vec3, f64)>,
    side: f64,
    /// Whether any of its edges is hollow and a bend.
    pub(super) has_bends: bool,
    cells: HashMap<[i64; 3], Vec<usize>>,
    /// Points by which it touches other shapes than spheres, and how many of them share a law.
    points: Option<(Vec<Vec3>, usize)>,
    /// The solid as those points of others meet it.
    field: Option<Arc<Field>>,
}

impl fmt::Debug for TriangleMesh {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sum: f64 = self.vertices.iter().flat_map(|vertex| vertex.0).sum();
        f.debug_struct("TriangleMesh")
            .field("vertices", &self.vertices.len())
            .field("faces", &self.faces.len())
            .field("sum_of_coordinates", &sum)
            .finish_non_exhaustive()
    }
}

impl TriangleMesh {
    /// Returns the same surface with points `[m]` for contacts with shapes other than spheres; `shared_by` of them, at
    /// least one, share a contact's law.
    #[must_use]
    pub fn with_points(self, points: &[Vector], shared_by: usize) -> Self {
        let points = points.iter().map(|&point| Vec3(point)).collect();
        Self {
            points: Some((points, shared_by.max(1))),
            ..self
        }
    }

    /// Returns the same surface with a distance function for contacts with the points of other meshes.
    #[must_use]
    pub fn with_field(self, field: Field) -> Self {
        Self {
            field: Some(Arc::new(field)),
            ..self
        }
    }

    /// Its points, and how many of them share a law.
    pub(in crate::world) fn points(&self) -> Option<(&[Vec3], usize)> {
        let (points, shared_by) = self.points.as_ref()?;
        Some((points, *shared_by))
    }

    pub(in crate::world) fn field(&self) -> Option<&Arc<Field>> {
        self.field.as_ref()
    }

    /// Largest distance of a vertex from the origin `[m]`.
    pub(in crate::world) fn reach(&self) -> f64 {
        let each = self.vertices.iter().map(|vertex| vertex.norm());
        each.fold(0.0, f64::max)
    }

    /// A mesh of `vertices` `[m]` and faces, each by the numbers of its corners from 0.
    ///
    /// # Errors
    ///
    /// A corner that there is not, a face without an area, an edge of more than two faces or of two that run along it
    /// the same way.
    pub fn new(vertices: &[Vector], faces: &[[u32; 3]]) -> Result<Self, InvalidMesh> {
        let faces: Vec<[usize; 3]> = faces.iter().map(|f| f.map(|c| c as usize)).collect();
        let vertices: Vec<Vec3> = vertices.iter().map(|&vertex| Vec3(vertex)).collect();
        let mut numbers: HashMap<[usize; 2], usize> = HashMap::new();
        let mut mesh = Self {
            normals: Vec::with_capacity(faces.len()),
            edges: Vec::new(),
            edges_of: Vec::with_capacity(faces.len()),
            edges_at: vec![Vec::new(); vertices.len()],
            faces_at: vec![Vec::new(); vertices.len()],
            balls: Vec::with_capacity(faces.len()),
            side: 1.0,
            has_bends: false,
            cells: HashMap::new(),
            points: None,
            field: None,
            vertices,
            faces,
        };
        let mut lengths = 0.0;
        for number in 0..mesh.faces.len() {
            let invalid = |reason| InvalidMesh {
                triangle: number,
                reason,
            };
            lengths += mesh.add_face(number).map_err(invalid)?;
            let mut of_face = [0; 3];
            for (k, edge) in of_face.iter_mut().enumerate() {
                *edge = mesh.add_edge(number, k, &mut numbers).map_err(invalid)?;
            }
            mesh.edges_of.push(of_face);
        }
        // Cells of about three edges.
        mesh.side = (3.0 * lengths / (3.0 * mesh.faces.len().max(1) as f64)).max(1e-9);
        mesh.fill_cells();
        Ok(mesh)
    }

    /// Adds the normal and the ball of a face. Returns the length around the face `[m]`, or the reason for rejecting
    /// it.
    fn add_face(&mut self, number: usize) -> Result<f64, &'static str> {
        let face = self.faces[number];
        if face.iter().any(|&corner| corner >= self.vertices.len()) {
            return Err("a corner is not a vertex of the mesh");
        }
        let [a, b, c] = face.map(|corner| self.vertices[corner]);
        let normal = (b - a).cross(c - a).direction();
        let normal = normal.filter(|normal| normal.norm().is_finite());
        self.normals.push(normal.ok_or("it has no area")?);
        let middle = (a + b + c) * (1.0 / 3.0);
        let radius = [a, b, c].map(|corner| (corner - middle).norm());
        let radius = radius.into_iter().fold(0.0, f64::max);
        self.balls.push((middle, radius * (1.0 + 1e-9)));
        Ok((b - a).norm() + (c - b).norm() + (a - c).norm())
    }

    /// Adds edge `k` of a face, or the face to the edge's first one. Returns the edge's number, or the reason for
    /// rejecting the face. `numbers` holds the number of each edge by its ends.
    fn add_edge(
        &mut self,
        number: usize,
        k: usize,
        numbers: &mut HashMap<[usize; 2], usize>,
    ) -> Result<usize, &'static str> {
        let face = self.faces[number];
        let (from, to) = (face[k], face[(k + 1) % 3]);
        self.faces_at[from].push(number);
        let found = *numbers
            .entry([from.min(to), from.max(to)])
            .or_insert(self.edges.len());
        if found == self.edges.len() {
            self.edges_at[from].push(found);
            self.edges_at[to].push(found);
            self.edges.push(Edge {
                ends: [from, to],
                faces: vec![number],
                is_bend: false,
            });
            return Ok(found);
        }
        let edge = &mut self.edges[found];
        if edge.faces.len() == 2 || edge.ends != [to, from] {
            return Err("an edge has a third face or a face of opposite winding");
        }
        let normals = [edge.faces[0], number].map(|face| self.normals[face]);
        let [start, end] = edge.ends.map(|end| self.vertices[end]);
        let along = (end - start).direction().unwrap_or(Vec3::ZERO);
        let hollow = normals[1].cross(normals[0]).dot(along);
        edge.is_bend = hollow > -FLAT && normals[0].dot(normals[1]) > SHARP;
        self.has_bends |= edge.is_bend && hollow > FLAT;
        edge.faces.push(number);
        Ok(found)
    }

    /// Lists each face in the cells that it may reach.
    fn fill_cells(&mut self) {
        for number in 0..self.faces.len() {
            let places = self.faces[number].map(|corner| self.vertices[corner].0);
            let most = |pick: fn(f64, f64) -> f64| {
                Vec3(std::array::from_fn(|axis| {
                    pick(pick(places[0][axis], places[1][axis]), places[2][axis])
                }))
            };
            for cell in self.cells_between(most(f64::min), most(f64::max)) {
                self.cells.entry(cell).or_default().push(number);
            }
        }
    }

    /// Its vertices `[m]`.
    #[must_use]
    pub fn vertices(&self) -> Vec<Vector> {
        self.vertices.iter().map(|vertex| vertex.0).collect()
    }

    /// Its faces, each by the numbers of its corners.
    #[must_use]
    pub fn faces(&self) -> Vec<[u32; 3]> {
        let number = |corner: usize| u32::try_from(corner).unwrap_or(u32::MAX);
        self.faces.iter().map(|face| face.map(number)).collect()
    }

    fn cell(&self, place: Vec3) -> [i64; 3] {
        #[expect(clippy::cast_possible_truncation, reason = "a cell of a small mesh")]
        place.0.map(|x| (x / self.side).floor() as i64)
    }

    fn cells_between(&self, low: Vec3, high: Vec3) -> impl Iterator<Item = [i64; 3]> + use<> {
        let (low, high) = (self.cell(low), self.cell(high));
        (low[0]..=high[0]).flat_map(move |x| {
            (low[1]..=high[1]).flat_map(move |y| (low[2]..=high[2]).map(move |z| [x, y, z]))
        })
    }

    /// The faces of which a part may be within `reach` `[m]` of a place, each once, in order.
    pub(super) fn near(&self, place: Vec3, reach: f64) -> Vec<usize> {
        let corner = Vec3([reach; 3]);
        let is_near = |&face: &usize| {
            let (middle, radius) = self.balls[face];
            let off = place - middle;
            off.dot(off) <= (reach + radius) * (reach + radius)
        };
        let cells = 8.0 * (reach / self.side + 1.0).powi(3);
        if cells > self.faces.len() as f64 {
            return (0..self.faces.len()).filter(is_near).collect();
        }
        let cells = self.cells_between(place - corner, place + corner);
        let mut found: Vec<usize> = cells
            .filter_map(|cell| self.cells.get(&cell))
            .flatten()
            .copied()
            .filter(is_near)
            .collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Length of about three of its edges `[m]`.
    pub(super) fn cell_side(&self) -> f64 {
        self.side
    }

    /// Into `face`, at right angles to its edge `edge`.
    pub(super) fn inward(&self, face: usize, edge: usize) -> Vec3 {
        let [from, to] = self.edges[edge].ends;
        let along = self.vertices[to] - self.vertices[from];
        let across = self.normals[face].cross(along);
        // The second face runs along the edge the other way.
        let sign = if self.edges[edge].faces[0] == face {
            1.0
        } else {
            -1.0
        };
        across * sign
    }
}
