//! Two hulls, and the candidate planes between them.

use std::sync::Arc;

use super::{Between, Found, PARALLEL, PREFERENCE, Plane};
use crate::geometry::hull::{Corners, MAX_CORNERS};
use crate::geometry::rigid::{Rigid, Vector3};

/// A hull in the world's axes.
#[derive(Clone, Debug)]
pub(super) struct Flat {
    pub own: Arc<Corners>,
    pub reach: f64,
    pub corners: Vec<Vector3>,
    /// Normal of each face; `offsets` has the offsets.
    pub normals: Vec<Vector3>,
    pub offsets: Vec<f64>,
    /// Unit vector along each edge.
    pub along: Vec<Vector3>,
}

/// Two hulls.
#[derive(Clone, Debug)]
pub(super) struct Hulls {
    solids: [Flat; 2],
    /// Number of corners that share the law of the pair.
    pub(super) share: usize,
}

/// A set of edges.
struct Near {
    edges: [u8; MAX_EDGES],
    count: usize,
}

/// Maximum number of edges: three per corner, minus six (Euler).
const MAX_EDGES: usize = 3 * MAX_CORNERS;

impl Near {
    fn none() -> Self {
        Self {
            edges: [0; MAX_EDGES],
            count: 0,
        }
    }

    fn add(&mut self, edge: usize) {
        if let (Ok(edge), Some(place)) = (u8::try_from(edge), self.edges.get_mut(self.count)) {
            *place = edge;
            self.count += 1;
        }
    }

    fn all(&self) -> impl Iterator<Item = usize> {
        self.edges[..self.count]
            .iter()
            .map(|&edge| usize::from(edge))
    }
}

impl Flat {
    pub fn new(own: Arc<Corners>) -> Self {
        Self {
            reach: own.reach(),
            corners: own.places.clone(),
            normals: own.faces.iter().map(|face| face.normal).collect(),
            offsets: own.faces.iter().map(|face| face.offset).collect(),
            along: own.edges.iter().map(|edge| edge.along).collect(),
            own,
        }
    }

    pub fn place(&mut self, rigid: &Rigid) {
        let turned = rigid.orientation.to_rotation_matrix();
        for (corner, own) in self.corners.iter_mut().zip(&self.own.places) {
            *corner = rigid.position + turned * own;
        }
        for (number, face) in self.own.faces.iter().enumerate() {
            let normal = turned * face.normal;
            self.normals[number] = normal;
            self.offsets[number] = face.offset + normal.dot(&rigid.position);
        }
        for (along, edge) in self.along.iter_mut().zip(&self.own.edges) {
            *along = turned * edge.along;
        }
    }

    /// Returns the normals of the faces at an edge.
    pub fn at(&self, edge: usize) -> [&Vector3; 2] {
        self.own.edges[edge].faces.map(|face| &self.normals[face])
    }

    pub fn begin(&self, edge: usize) -> &Vector3 {
        &self.corners[self.own.edges[edge].ends[0]]
    }
}

impl Hulls {
    pub fn new(hulls: [Arc<Corners>; 2], share: usize) -> Self {
        Self {
            solids: hulls.map(Flat::new),
            share,
        }
    }

    pub fn reaches(&self) -> [f64; 2] {
        self.solids.each_ref().map(|solid| solid.reach)
    }

    /// Sets the current poses.
    pub fn place(&mut self, rigids: [&Rigid; 2]) {
        for (solid, rigid) in self.solids.iter_mut().zip(rigids) {
            solid.place(rigid);
        }
    }

    /// Returns whether the plane of two edges touches each solid at that edge: the arcs between the face normals of
    /// the first solid and of the inverted second solid cross on the unit sphere.
    fn is_between(&self, [i, j]: [usize; 2]) -> bool {
        let [first, second] = &self.solids;
        let (u, v) = (&first.along[i], &second.along[j]);
        let [c, d] = second.at(j).map(|normal| -u.dot(normal));
        if c * d >= 0.0 {
            return false;
        }
        let [a, b] = first.at(i).map(|normal| v.dot(normal));
        a * b < 0.0 && c * b > 0.0 && u.cross(v).norm_squared() > PARALLEL * PARALLEL
    }

    /// Returns the normal out of the first solid.
    fn out_at(&self, [i, j]: [usize; 2]) -> Vector3 {
        let [first, second] = &self.solids;
        let across = first.along[i].cross(&second.along[j]).normalize();
        let [a, b] = first.at(i);
        if across.dot(&(a + b)) < 0.0 {
            -across
        } else {
            across
        }
    }

    fn depth(&self, plane: Plane) -> f64 {
        match plane {
            Plane::Face { of, number } => self.behind(of, number).0,
            Plane::Edges(pair) if self.is_between(pair) => self.overlap(pair),
            // The plane no longer exists.
            Plane::Edges(_) => f64::INFINITY,
        }
    }

    /// Returns the depth of a face, and that of the corner that is furthest behind it.
    fn behind(&self, of: usize, number: usize) -> (f64, f64) {
        let (solid, other) = (&self.solids[of], &self.solids[1 - of]);
        let (normal, offset) = (&solid.normals[number], solid.offsets[number]);
        let (mut deepest, mut squares) = (f64::NEG_INFINITY, 0.0);
        for corner in &other.corners {
            let depth = offset - normal.dot(corner);
            deepest = depth.max(deepest);
            squares += depth.max(0.0).powi(2);
        }
        if deepest <= 0.0 {
            (deepest, deepest)
        } else {
            ((squares / self.share as f64).sqrt(), deepest)
        }
    }

    /// Returns the edges of both solids that may cross near a face with overlap `deepest`, with a plane of depth at
    /// most `least`.
    ///
    /// If two edges give the plane of least overlap, they cross inside the overlap region. Edges further from it than
    /// the depth are therefore skipped.
    fn near(&self, of: usize, number: usize, deepest: f64, least: f64) -> [Near; 2] {
        let (normal, offset) = (
            &self.solids[of].normals[number],
            self.solids[of].offsets[number],
        );
        let mut near = [Near::none(), Near::none()];
        for (side, solid) in self.solids.iter().enumerate() {
            for (edge, own) in solid.own.edges.iter().enumerate() {
                let [a, b] = own.ends.map(|end| normal.dot(&solid.corners[end]) - offset);
                let is_near = if side == of {
                    a.max(b) > -deepest - least
                } else {
                    a.min(b) < least
                };
                if is_near {
                    near[side].add(edge);
                }
            }
        }
        near
    }

    /// Returns the overlap of two crossing edges.
    fn overlap(&self, pair: [usize; 2]) -> f64 {
        let [first, second] = &self.solids;
        let between = first.begin(pair[0]) - second.begin(pair[1]);
        self.out_at(pair).dot(&between)
    }

    /// Returns the midpoint between the closest points of two edges `[m]`.
    fn crossing(&self, [i, j]: [usize; 2]) -> Vector3 {
        let [first, second] = &self.solids;
        let (one, other) = (first.begin(i), second.begin(j));
        let (u, v) = (&first.along[i], &second.along[j]);
        let (between, cosine) = (other - one, u.dot(v));
        let sine_square = 1.0 - cosine * cosine;
        let along_u = (u.dot(&between) - cosine * v.dot(&between)) / sine_square;
        let along_v = (cosine * u.dot(&between) - v.dot(&between)) / sine_square;
        0.5 * (one + u * along_u + other + v * along_v)
    }
}

impl Between for Hulls {
    fn least(&self, before: Option<Plane>) -> (Plane, f64) {
        let start = before.unwrap_or(Plane::Face { of: 0, number: 0 });
        let mut least = (start, self.depth(start));
        let mut look = |plane: Plane, depth: f64| {
            // A plane that no longer exists has infinite depth and no relative margin.
            let slack = if least.1.is_finite() {
                PREFERENCE * least.1.abs()
            } else {
                0.0
            };
            if depth < least.1 - slack {
                least = (plane, depth);
            }
        };
        let mut shallowest = (0, 0, f64::INFINITY);
        for (of, solid) in self.solids.iter().enumerate() {
            for number in 0..solid.normals.len() {
                let (depth, deepest) = self.behind(of, number);
                look(Plane::Face { of, number }, depth);
                if deepest < shallowest.2 {
                    shallowest = (of, number, deepest);
                }
            }
        }
        let (of, number, deepest) = shallowest;
        if deepest <= 0.0 {
            return least;
        }
        let [ones, others] = self.near(of, number, deepest, deepest);
        for i in ones.all() {
            for j in others.all() {
                if self.is_between([i, j]) {
                    look(Plane::Edges([i, j]), self.overlap([i, j]));
                }
            }
        }
        least
    }

    fn normal(&self, plane: Plane) -> Vector3 {
        match plane {
            Plane::Face { of: 0, number } => -self.solids[0].normals[number],
            Plane::Face { of, number } => self.solids[of].normals[number],
            Plane::Edges(pair) => -self.out_at(pair),
        }
    }

    fn points(&self, plane: Plane, found: &mut [Found]) {
        match plane {
            Plane::Face { of, number } => {
                let (solid, other) = (&self.solids[of], &self.solids[1 - of]);
                let (normal, offset) = (&solid.normals[number], solid.offsets[number]);
                found.fill(Found::none());
                for (found, corner) in found.iter_mut().zip(&other.corners) {
                    let above = normal.dot(corner) - offset;
                    *found = Found {
                        penetration: -above,
                        place: corner - normal * (0.5 * above),
                    };
                }
            }
            Plane::Edges(pair) => {
                Found::cross(found, self.overlap(pair), self.crossing(pair), self.share);
            }
        }
    }
}
