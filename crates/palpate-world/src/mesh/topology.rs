//! Which triangles of a mesh meet where, and their normals.

use std::collections::HashMap;

use super::build::{Mesh, MeshError};
use super::tree::size;
use crate::rigid::{Rotation, Vector3};

/// In place of the neighbour across an edge that has none.
pub(super) const NONE: u32 = u32::MAX;
/// Cosine of the angle between two normals from which on their faces push apart from each other: 30 degrees.
pub(super) const SHARP: f64 = 0.866_025_403_784_438_6;
/// Sine of the angle below which an edge neither stands out nor is hollow: files are in single precision.
const FLAT: f64 = 1e-3;

/// How a triangle goes on over its edges.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Bends(u8);

impl Bends {
    const HOLLOW: u8 = 1 << 3;

    /// Whether the surface goes on over edge k: it does not stand out there, and bends by less than [`SHARP`].
    pub fn goes_on(self, k: usize) -> bool {
        self.0 >> k & 1 == 1
    }

    /// Whether it goes on over any of its edges.
    pub fn goes_on_at_all(self) -> bool {
        self.0 != 0
    }

    /// Whether it goes on over an edge that is hollow.
    pub fn is_hollow(self) -> bool {
        self.0 & Self::HOLLOW != 0
    }

    /// Over edge k, which leads along a vector, from a face with one normal to one with another.
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

/// Which triangles of a mesh meet where.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Topology {
    /// Unit normal of each triangle, out of the solid.
    pub normals: Vec<Vector3>,
    /// The triangle across each edge, or [`NONE`]. Edge k goes from corner k to the next.
    pub neighbours: Vec<[u32; 3]>,
    /// How each triangle goes on over its edges.
    pub bends: Vec<Bends>,
    /// Sum of the normals at each vertex, each times its angle there: says on which side of a nearest vertex a place
    /// is (Baerentzen and Aanaes, 2005).
    pub vertex_normals: Vec<Vector3>,
    /// The triangles at each vertex, one vertex after the other,
    around: Vec<u32>,
    /// and where those of a vertex begin.
    begins: Vec<u32>,
}

impl Topology {
    /// Of triangles with an area; `given` has their numbers for messages.
    pub fn of(
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
            if triangles > Mesh::MOST_AROUND {
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

    /// Of the same triangles, turned.
    pub fn turned(&self, by: &Rotation) -> Self {
        let turned = |all: &[Vector3]| all.iter().map(|normal| by * normal).collect();
        Self {
            normals: turned(&self.normals),
            vertex_normals: turned(&self.vertex_normals),
            ..self.clone()
        }
    }

    /// Whether every edge has two triangles.
    pub fn is_closed(&self) -> bool {
        !self.neighbours.iter().flatten().any(|&other| other == NONE)
    }

    /// The triangles at a vertex.
    pub fn around(&self, vertex: u32) -> &[u32] {
        let [from, to] = [vertex, vertex + 1].map(|number| self.begins[number as usize] as usize);
        &self.around[from..to]
    }
}
