//! Adjacency of a mesh's triangles, and their normals.

use std::collections::HashMap;

use super::build::{Mesh, MeshError};
use super::tree::size;
use crate::geometry::rigid::{Rotation, Vector3};

/// Marker for an edge without a neighbour.
pub(super) const NONE: u32 = u32::MAX;
/// Cosine of the angle between two normals above which their faces are separate contacts: 30 degrees.
pub(super) const SHARP: f64 = 0.866_025_403_784_438_6;
/// Sine of the angle below which an edge is neither convex nor concave. Mesh files are in single precision.
const FLAT: f64 = 1e-3;

/// Continuation of the surface over a triangle's edges.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Bends(u8);

impl Bends {
    const HOLLOW: u8 = 1 << 3;

    /// Returns whether the surface continues over edge k: the edge is not convex and bends by less than [`SHARP`].
    pub fn goes_on(self, k: usize) -> bool {
        self.0 >> k & 1 == 1
    }

    /// Returns whether the surface continues over any edge.
    pub fn goes_on_at_all(self) -> bool {
        self.0 != 0
    }

    /// Returns whether the surface continues over a concave edge.
    pub fn is_hollow(self) -> bool {
        self.0 & Self::HOLLOW != 0
    }

    /// Adds edge k with direction `along`, between faces with the given normals.
    fn add(&mut self, k: usize, along: &Vector3, [own, other]: [&Vector3; 2]) {
        let inwards = -own.cross(other).dot(along) / along.norm();
        if own.dot(other) > SHARP && inwards > -FLAT {
            self.0 |= 1 << k;
            if inwards > FLAT {
                self.0 |= Self::HOLLOW;
            }
        }
    }
}

/// Adjacency of a mesh's triangles.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Topology {
    /// Outward unit normal of each triangle.
    pub normals: Vec<Vector3>,
    /// Triangle across each edge, or [`NONE`]. Edge k goes from corner k to the next.
    pub neighbours: Vec<[u32; 3]>,
    /// Continuation over the edges of each triangle.
    pub bends: Vec<Bends>,
    /// Angle-weighted sum of the normals at each vertex. It determines the side of a position whose nearest point is
    /// a vertex (Baerentzen and Aanaes, 2005).
    pub vertex_normals: Vec<Vector3>,
    /// Triangles at each vertex, concatenated.
    around: Vec<u32>,
    /// Start index of each vertex in `around`.
    begins: Vec<u32>,
}

impl Topology {
    /// Creates the topology of triangles with non-zero area. `given` has their indices for messages.
    pub fn new(
        vertices: &[Vector3],
        faces: &[[u32; 3]],
        given: &[usize],
    ) -> Result<Self, MeshError> {
        let mut edges: HashMap<(u32, u32), (u32, usize)> = HashMap::with_capacity(3 * faces.len());
        for (triangle, face) in (0_u32..).zip(faces) {
            for k in 0..3 {
                let (from, to) = (face[k], face[(k + 1) % 3]);
                let Some((other, _)) = edges.insert((from, to), (triangle, k)) else {
                    continue;
                };
                let number = |triangle: u32| given[triangle as usize];
                return Err(match edges.get(&(to, from)) {
                    Some(&(third, _)) => {
                        MeshError::SharedEdge([number(other), number(triangle), number(third)])
                    }
                    None => MeshError::Winding([number(other), number(triangle)]),
                });
            }
        }
        let mut neighbours = vec![[NONE; 3]; faces.len()];
        for (&(from, to), &(triangle, k)) in &edges {
            if let Some(&(other, _)) = edges.get(&(to, from)) {
                neighbours[triangle as usize][k] = other;
            }
        }
        let mut begins = vec![0_u32; vertices.len() + 1];
        for corner in faces.iter().flatten() {
            begins[*corner as usize + 1] += 1;
        }
        for vertex in 0..vertices.len() {
            let triangles = begins[vertex + 1] as usize;
            if triangles > Mesh::MAX_AROUND {
                return Err(MeshError::Fan { vertex, triangles });
            }
            begins[vertex + 1] += begins[vertex];
        }
        let mut around = vec![0; 3 * faces.len()];
        let mut next = begins.clone();
        let mut normals = Vec::with_capacity(faces.len());
        let mut vertex_normals = vec![Vector3::zeros(); vertices.len()];
        for (triangle, face) in faces.iter().enumerate() {
            let places = face.map(|corner| vertices[corner as usize]);
            let normal = (places[1] - places[0])
                .cross(&(places[2] - places[0]))
                .normalize();
            normals.push(normal);
            for k in 0..3 {
                let corner = face[k] as usize;
                around[next[corner] as usize] = size(triangle);
                next[corner] += 1;
                let [one, other] = [1, 2].map(|step| places[(k + step) % 3] - places[k]);
                vertex_normals[corner] += normal * one.cross(&other).norm().atan2(one.dot(&other));
            }
        }
        let mut bends = vec![Bends::default(); faces.len()];
        for (triangle, face) in faces.iter().enumerate() {
            let places = face.map(|corner| vertices[corner as usize]);
            for (k, &other) in neighbours[triangle].iter().enumerate() {
                if other != NONE {
                    let both = [triangle, other as usize].map(|number| &normals[number]);
                    bends[triangle].add(k, &(places[(k + 1) % 3] - places[k]), both);
                }
            }
        }
        Ok(Self {
            normals,
            neighbours,
            bends,
            vertex_normals,
            around,
            begins,
        })
    }

    /// Returns the topology of the rotated triangles.
    pub fn turned(&self, by: &Rotation) -> Self {
        let turned = |all: &[Vector3]| all.iter().map(|normal| by * normal).collect();
        Self {
            normals: turned(&self.normals),
            vertex_normals: turned(&self.vertex_normals),
            ..self.clone()
        }
    }

    /// Returns whether every edge has two triangles.
    pub fn is_closed(&self) -> bool {
        !self.neighbours.iter().flatten().any(|&other| other == NONE)
    }

    /// Returns the triangles at a vertex.
    pub fn around(&self, vertex: u32) -> &[u32] {
        let [from, to] = [vertex, vertex + 1].map(|number| self.begins[number as usize] as usize);
        &self.around[from..to]
    }
}
