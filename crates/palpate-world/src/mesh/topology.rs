//! Which triangles of a mesh meet where, and their normals.

use std::collections::HashMap;

use super::build::{Mesh, MeshError};
use super::tree::size;
use crate::rigid::{Rotation, Vector3};

/// In place of the neighbour across an edge that has none.
pub(super) const NONE: u32 = u32::MAX;

/// Which triangles of a mesh meet where.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Topology {
    /// Unit normal of each triangle, out of the solid.
    pub normals: Vec<Vector3>,
    /// The triangle across each edge, or [`NONE`]. Edge k goes from corner k to the next.
    pub neighbours: Vec<[u32; 3]>,
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
        Ok(Self {
            normals,
            neighbours,
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
