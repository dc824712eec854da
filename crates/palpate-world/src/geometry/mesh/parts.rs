//! Parts of a mesh: sets of triangles that are connected by edges.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

use super::build::MeshError;
use super::topology::NONE;
use super::tree::size;
use crate::geometry::rigid::Vector3;

/// Maximum number of triangles at an edge for pairing.
const MAX_AT_EDGE: usize = 64;
/// Angle below which two faces at an edge coincide `[rad]`.
const SAME_ANGLE: f64 = 1e-6;
/// Ratio of volume to area^(3/2) up to which a closed part is a sheet.
const EMPTY: f64 = 1e-9;

/// Triangles by vertex indices, and their vertices.
pub(super) struct Triangles {
    pub vertices: Vec<Vector3>,
    pub faces: Vec<[u32; 3]>,
    /// Given indices of the triangles, for messages.
    pub given: Vec<usize>,
    /// Number of closed parts that were inside out and have been reversed.
    pub turned: usize,
}

/// Connectivity of the triangles.
struct Parts {
    /// Triangle across each edge, or [`NONE`].
    neighbours: Vec<[u32; 3]>,
    /// Whether an edge has more than two triangles.
    has_shared_edges: bool,
    /// Part of each triangle.
    part: Vec<usize>,
    each: Vec<Part>,
}

struct Part {
    is_closed: bool,
    triangles: usize,
    /// Twice the area `[m^2]`.
    area: f64,
    /// Signed volume of a closed part, negative if it is inside out or a cavity `[m^3]`.
    volume: f64,
}

/// Side of a triangle at an edge between two vertices.
#[derive(Clone, Copy)]
struct Side {
    ends: [u32; 2],
    triangle: u32,
    k: usize,
    /// Whether the triangle's direction is from the lower vertex index to the higher one.
    is_up: bool,
}

impl Triangles {
    /// Separates or merges parts that touch along edges or faces, and reverses closed parts that are inside out.
    /// Afterwards at most two triangles share an edge.
    ///
    /// # Errors
    /// An edge whose triangles bound no solids, a sheet with both sides given, a closed mesh without a volume.
    pub fn into_parts(mut self) -> Result<Self, MeshError> {
        let mut parts = self.parts()?;
        if parts.has_shared_edges {
            let inner = self.inner_walls(&parts)?;
            if inner.iter().any(|is_inner| *is_inner) {
                self.retain(|triangle| !inner[triangle]);
                parts = self.parts()?;
            }
        }
        self.drop_empty_parts(&mut parts)?;
        self.orient(&parts);
        if parts.has_shared_edges {
            // Reversing a part does not change the pairs.
            self.split_vertices(&self.parts()?);
        }
        Ok(self)
    }

    fn parts(&self) -> Result<Parts, MeshError> {
        let mut sides: Vec<Side> = Vec::with_capacity(3 * self.faces.len());
        for (triangle, face) in (0_u32..).zip(&self.faces) {
            for k in 0..3 {
                let (from, to) = (face[k], face[(k + 1) % 3]);
                sides.push(Side {
                    ends: [from.min(to), from.max(to)],
                    triangle,
                    k,
                    is_up: from < to,
                });
            }
        }
        sides.sort_unstable_by_key(|side| (side.ends, side.triangle));
        let mut neighbours = vec![[NONE; 3]; self.faces.len()];
        let mut has_shared_edges = false;
        for at_edge in sides.chunk_by(|one, other| one.ends == other.ends) {
            let pairs = match at_edge {
                [_] => continue,
                [one, other] if one.is_up != other.is_up => vec![(*one, *other)],
                [one, other] => {
                    let numbers = [one, other].map(|side| self.given[side.triangle as usize]);
                    return Err(MeshError::Winding(numbers));
                }
                _ => {
                    has_shared_edges = true;
                    self.solids_at(at_edge)?
                }
            };
            for (one, other) in pairs {
                neighbours[one.triangle as usize][one.k] = other.triangle;
                neighbours[other.triangle as usize][other.k] = one.triangle;
            }
        }
        let (part, each) = self.connected(&neighbours);
        Ok(Parts {
            neighbours,
            has_shared_edges,
            part,
            each,
        })
    }

    /// Returns the pairs of triangles at an edge that enclose a solid.
    fn solids_at(&self, sides: &[Side]) -> Result<Vec<(Side, Side)>, MeshError> {
        let (ups, downs): (Vec<Side>, Vec<Side>) = sides.iter().partition(|side| side.is_up);
        if ups.len() != downs.len() || sides.len() > MAX_AT_EDGE {
            let number = |k: usize| self.given[sides[k].triangle as usize];
            return Err(MeshError::SharedEdge([number(0), number(1), number(2)]));
        }
        let [start, end] = sides[0].ends.map(|end| self.vertices[end as usize]);
        let along = (end - start).normalize();
        let third = |side: &Side| {
            let corner = self.faces[side.triangle as usize][(side.k + 2) % 3];
            let off = self.vertices[corner as usize] - start;
            off - along * along.dot(&off)
        };
        let zero = third(&sides[0]);
        let quarter = along.cross(&zero);
        let angle = |side: &Side| {
            let off = third(side);
            quarter.dot(&off).atan2(zero.dot(&off))
        };
        // The solid is behind a face: at lower angles for an upward direction, at higher angles for a downward one.
        let mut between = Vec::with_capacity(ups.len() * downs.len());
        for (one, up) in ups.iter().enumerate() {
            for (other, down) in downs.iter().enumerate() {
                let angle = (angle(up) - angle(down)).rem_euclid(TAU);
                let is_same = !(SAME_ANGLE..=TAU - SAME_ANGLE).contains(&angle);
                between.push((if is_same { TAU } else { angle }, one, other));
            }
        }
        between.sort_by(|one, other| one.0.total_cmp(&other.0));
        let (mut is_used_up, mut is_used_down) = (vec![false; ups.len()], vec![false; ups.len()]);
        let mut pairs = Vec::with_capacity(ups.len());
        for (_, one, other) in between {
            if !is_used_up[one] && !is_used_down[other] {
                (is_used_up[one], is_used_down[other]) = (true, true);
                pairs.push((ups[one], downs[other]));
            }
        }
        Ok(pairs)
    }

    /// Returns the part of each triangle, and the parts.
    fn connected(&self, neighbours: &[[u32; 3]]) -> (Vec<usize>, Vec<Part>) {
        let mut part = vec![usize::MAX; self.faces.len()];
        let mut each = Vec::new();
        let mut waiting = Vec::new();
        for first in 0..self.faces.len() {
            if part[first] != usize::MAX {
                continue;
            }
            let tip = self.vertices[self.faces[first][0] as usize];
            let mut found = Part {
                is_closed: true,
                triangles: 0,
                area: 0.0,
                volume: 0.0,
            };
            part[first] = each.len();
            waiting.push(first);
            while let Some(triangle) = waiting.pop() {
                found.triangles += 1;
                let corners = self.faces[triangle].map(|corner| self.vertices[corner as usize]);
                let [a, b, c] = corners.map(|corner| corner - tip);
                found.area += (b - a).cross(&(c - a)).norm();
                found.volume += a.dot(&b.cross(&c)) / 6.0;
                for &other in &neighbours[triangle] {
                    if other == NONE {
                        found.is_closed = false;
                    } else if part[other as usize] == usize::MAX {
                        part[other as usize] = each.len();
                        waiting.push(other as usize);
                    }
                }
            }
            each.push(found);
        }
        (part, each)
    }

    /// Returns the triangles that are not on the surface: both triangles where two solids touch face to face, and the
    /// inner ones of a solid whose triangles are all given from both sides.
    fn inner_walls(&self, parts: &Parts) -> Result<Vec<bool>, MeshError> {
        let mut at: HashMap<[u32; 3], usize> = HashMap::with_capacity(self.faces.len());
        let mut twins = Vec::new();
        for (triangle, face) in self.faces.iter().enumerate() {
            let mut corners = *face;
            corners.sort_unstable();
            if let Some(other) = at.insert(corners, triangle) {
                twins.push([other, triangle]);
            }
        }
        // Number of coincident triangles for each pair of parts.
        let mut shared: HashMap<[usize; 2], usize> = HashMap::new();
        let parts_of = |twin: &[usize; 2]| {
            let mut both = twin.map(|triangle| parts.part[triangle]);
            both.sort_unstable();
            both
        };
        for twin in &twins {
            *shared.entry(parts_of(twin)).or_default() += 1;
        }
        let mut is_inner = vec![false; self.faces.len()];
        for twin in &twins {
            let both = parts_of(twin);
            let [one, other] = both.map(|part| &parts.each[part]);
            let count = shared[&both];
            let is_sheet = both[0] == both[1] && 2 * count == one.triangles;
            if is_sheet {
                return Err(MeshError::TwoSided(
                    twin.map(|triangle| self.given[triangle]),
                ));
            }
            let is_solid = one.is_closed && other.is_closed;
            let is_double =
                both[0] != both[1] && [one, other].iter().all(|part| part.triangles == count);
            for &triangle in twin {
                let volume = parts.each[parts.part[triangle]].volume;
                is_inner[triangle] = is_solid
                    && if is_double {
                        volume < 0.0
                    } else {
                        one.volume > 0.0 && other.volume > 0.0
                    };
            }
        }
        Ok(is_inner)
    }

    /// Drops closed parts without a volume.
    fn drop_empty_parts(&mut self, parts: &mut Parts) -> Result<(), MeshError> {
        let is_empty = |part: &Part| {
            let smallest = EMPTY * part.area * part.area.sqrt();
            part.is_closed && part.volume.abs() <= smallest
        };
        if parts.each.iter().all(is_empty) {
            let volume = parts.each.iter().map(|part| part.volume).sum();
            return Err(MeshError::NoVolume(volume));
        }
        if parts.each.iter().any(is_empty) {
            let part = std::mem::take(&mut parts.part);
            let each = std::mem::take(&mut parts.each);
            self.retain(|triangle| !is_empty(&each[part[triangle]]));
            *parts = self.parts()?;
        }
        Ok(())
    }

    fn retain(&mut self, keeps: impl Fn(usize) -> bool) {
        let kept: Vec<usize> = (0..self.faces.len())
            .filter(|&triangle| keeps(triangle))
            .collect();
        self.faces = kept.iter().map(|&triangle| self.faces[triangle]).collect();
        self.given = kept.iter().map(|&triangle| self.given[triangle]).collect();
    }

    /// Reverses closed parts that are inside out: those with negative volume, except cavities of other parts.
    fn orient(&mut self, parts: &Parts) {
        let closed: Vec<usize> = (0..parts.each.len())
            .filter(|&part| parts.each[part].is_closed)
            .collect();
        if closed.iter().all(|&part| parts.each[part].volume > 0.0) {
            return;
        }
        let mut triangles: Vec<Vec<usize>> = vec![Vec::new(); parts.each.len()];
        for (triangle, &part) in parts.part.iter().enumerate() {
            triangles[part].push(triangle);
        }
        // Larger parts first: the container of a part is decided before the part.
        let mut by_size = closed;
        by_size.sort_by(|&one, &other| {
            let volume = |part: usize| parts.each[part].volume.abs();
            volume(other).total_cmp(&volume(one))
        });
        let mut is_turned = vec![false; parts.each.len()];
        for (before, &part) in by_size.iter().enumerate() {
            let place = self.middle(triangles[part][0]);
            let around: Vec<usize> = by_size[..before]
                .iter()
                .copied()
                .filter(|&other| self.contains(&triangles[other], &place))
                .collect();
            let is_cavity = around.len() % 2 == 1;
            let is_negative = parts.each[part].volume < 0.0;
            is_turned[part] = if is_cavity {
                // In a mesh that is entirely inside out, the cavities are inverted too.
                !is_negative && around.last().is_some_and(|&other| is_turned[other])
            } else {
                is_negative
            };
        }
        for (face, part) in self.faces.iter_mut().zip(&parts.part) {
            if is_turned[*part] {
                face.swap(1, 2);
            }
        }
        self.turned = is_turned.iter().filter(|turned| **turned).count();
    }

    fn middle(&self, triangle: usize) -> Vector3 {
        let corners = self.faces[triangle].map(|corner| self.vertices[corner as usize]);
        corners.iter().sum::<Vector3>() / 3.0
    }

    /// Returns whether a position is inside closed triangles, by their solid angle of 4 pi (Van Oosterom and
    /// Strackee, 1983).
    fn contains(&self, triangles: &[usize], place: &Vector3) -> bool {
        let angles = triangles.iter().map(|&triangle| {
            let corners = self.faces[triangle].map(|corner| self.vertices[corner as usize]);
            let [a, b, c] = corners.map(|corner| corner - place);
            let [of_a, of_b, of_c] = [a, b, c].map(|off| off.norm());
            let flat = of_a * of_b * of_c + a.dot(&b) * of_c + b.dot(&c) * of_a + c.dot(&a) * of_b;
            2.0 * a.dot(&b.cross(&c)).atan2(flat)
        });
        angles.sum::<f64>().abs() > 2.0 * PI
    }

    /// Gives each solid at an edge of more than two triangles its own vertices.
    fn split_vertices(&mut self, parts: &Parts) {
        let mut is_shared = vec![false; self.vertices.len()];
        let mut at_edge: HashMap<[u32; 2], usize> = HashMap::with_capacity(3 * self.faces.len());
        for face in &self.faces {
            for k in 0..3 {
                let (from, to) = (face[k], face[(k + 1) % 3]);
                let count = at_edge.entry([from.min(to), from.max(to)]).or_default();
                *count += 1;
                if *count > 2 {
                    is_shared[from as usize] = true;
                    is_shared[to as usize] = true;
                }
            }
        }
        let old = self.faces.clone();
        let mut has_its_own = vec![false; self.vertices.len()];
        let mut is_done = vec![[false; 3]; self.faces.len()];
        for first in 0..old.len() {
            for k in 0..3 {
                let vertex = old[first][k];
                if !is_shared[vertex as usize] || is_done[first][k] {
                    continue;
                }
                let number = if std::mem::replace(&mut has_its_own[vertex as usize], true) {
                    self.vertices.push(self.vertices[vertex as usize]);
                    size(self.vertices.len() - 1)
                } else {
                    vertex
                };
                // Visit all triangles at the vertex that are connected by edges there.
                let mut waiting = vec![(first, k)];
                is_done[first][k] = true;
                while let Some((triangle, k)) = waiting.pop() {
                    self.faces[triangle][k] = number;
                    for edge in [k, (k + 2) % 3] {
                        let other = parts.neighbours[triangle][edge];
                        if other == NONE {
                            continue;
                        }
                        let other = other as usize;
                        let corner = old[other].iter().position(|&corner| corner == vertex);
                        if let Some(corner) = corner
                            && !std::mem::replace(&mut is_done[other][corner], true)
                        {
                            waiting.push((other, corner));
                        }
                    }
                }
            }
        }
    }
}
