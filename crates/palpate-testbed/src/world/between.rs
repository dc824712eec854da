//! Two convex solids with flat faces: which plane is between them, and how they lie across it.
//!
//! Every face of a solid bounds a half-space, of which the corners of the other one are above or below; two edges that
//! cross span a plane. A plane's *overlap* p is such that K p²/2 is stored by it: with corners at depths d, p² = Σ
//! max(0, d)²/n where n corners share the law, and with edges p is how far one has passed the other. The solids touch
//! across the plane of least overlap.

use std::collections::HashMap;

use super::contact::{Placed, Touch};
use super::vector::Vec3;
use super::wrapping::{Wrapped, normal_of};

/// Another plane takes over where its overlap is less by this part.
pub(super) const MARGIN: f64 = 1e-9;
/// Sine of the angle of parallel edges.
const PARALLEL: f64 = 1e-6;
/// Corners that are beyond a plane by no more than this are in it `[m]`.
const IN_PLANE: f64 = 1e-12;

/// A plane between two solids.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Between {
    /// A face of the first (0) or second (1), by its number.
    Face { of: u8, face: u8 },
    /// An edge of the first and one of the second, by their numbers.
    Edges { first: u8, second: u8 },
}

/// A solid in its own axes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Flat {
    pub corners: Vec<Vec3>,
    /// Normal of each face, and how far along it the face is.
    pub faces: Vec<(Vec3, f64)>,
    pub edges: Vec<Edge>,
    /// Corners of the face with the most.
    pub most: usize,
}

/// An edge by its ends, and the faces that meet there.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Edge {
    pub ends: [usize; 2],
    pub faces: [usize; 2],
}

impl Flat {
    /// A box of half these lengths.
    pub fn of_box(half: [f64; 3]) -> Option<Self> {
        let sign = |number: usize, i: usize| if number >> i & 1 == 1 { 1.0 } else { -1.0 };
        let corners: Vec<Vec3> = (0..8)
            .map(|number| Vec3(std::array::from_fn(|i| sign(number, i) * half[i])))
            .collect();
        Some(Self::of(&Wrapped::around(&corners, 8)?))
    }

    /// All points x with normal · x ≤ offset: one face without an end.
    pub fn half_space(normal: Vec3, offset: f64) -> Self {
        Self {
            corners: Vec::new(),
            faces: vec![(normal, offset)],
            edges: Vec::new(),
            most: 0,
        }
    }

    pub fn of(wrapped: &Wrapped) -> Self {
        let mut edges: Vec<Edge> = Vec::new();
        let mut numbers = HashMap::new();
        for (number, face) in wrapped.faces.iter().enumerate() {
            for (place, &from) in face.iter().enumerate() {
                let to = face[(place + 1) % face.len()];
                if let Some(&edge) = numbers.get(&[to, from]) {
                    let edge: &mut Edge = &mut edges[edge];
                    edge.faces[1] = number;
                    continue;
                }
                numbers.insert([from, to], edges.len());
                edges.push(Edge {
                    ends: [from, to],
                    faces: [number; 2],
                });
            }
        }
        let faces = wrapped.faces.iter().map(|face| {
            let corners: Vec<Vec3> = face.iter().map(|&corner| wrapped.corners[corner]).collect();
            let normal = normal_of(&corners).unwrap_or(Vec3::ZERO);
            (normal, normal.dot(corners[0]))
        });
        Self {
            faces: faces.collect(),
            corners: wrapped.corners.clone(),
            edges,
            most: wrapped.most_corners(),
        }
    }

    fn along(&self, edge: usize) -> Vec3 {
        let [from, to] = self.edges[edge].ends.map(|end| self.corners[end]);
        (to - from).direction().unwrap_or(Vec3::ZERO)
    }
}

/// Two solids.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Pair(pub [Flat; 2]);

impl Pair {
    /// Returns the number of contacts: one for each corner of either solid.
    pub fn contacts(&self) -> usize {
        self.0.iter().map(|of| of.corners.len()).max().unwrap_or(0)
    }

    /// Returns the number of contacts that share the law.
    pub fn share(&self) -> usize {
        self.0.iter().map(|of| of.most).max().unwrap_or(1)
    }
}

pub(super) fn number(of: usize) -> u8 {
    u8::try_from(of).unwrap_or(u8::MAX)
}

/// Closest points of two edges.
struct Crossing {
    /// Directions of both.
    along: [Vec3; 2],
    /// The corner from which each begins.
    from: [Vec3; 2],
    /// From the second to the first, of any length: ± the cross product of the two.
    across: Vec3,
    turned: f64,
}

impl Crossing {
    fn new(first: u8, second: u8, pair: &Pair, placed: [&Placed; 2]) -> Self {
        let edges = [usize::from(first), usize::from(second)];
        let out = |side: usize, v: Vec3| placed[side].rotation.out(v);
        let along = [0, 1].map(|side| out(side, pair.0[side].along(edges[side])));
        let from = [0, 1].map(|side| {
            let solid = &pair.0[side];
            placed[side].position + out(side, solid.corners[solid.edges[edges[side]].ends[0]])
        });
        let bare = along[0].cross(along[1]);
        // Into the first, so against the faces at its edge.
        let faces = pair.0[0].edges[edges[0]]
            .faces
            .map(|face| pair.0[0].faces[face].0);
        let turned = if bare.dot(out(0, faces[0] + faces[1])) > 0.0 {
            -1.0
        } else {
            1.0
        };
        Self {
            along,
            from,
            across: bare * turned,
            turned,
        }
    }

    fn normal(&self) -> Vec3 {
        self.across.direction().unwrap_or(Vec3::ZERO)
    }

    fn overlap(&self) -> f64 {
        self.normal().dot(self.from[1] - self.from[0])
    }

    fn touch(&self, placed: [&Placed; 2]) -> Touch {
        let [u, v] = self.along;
        let [at_u, at_v] = self.from;
        let turning = placed.map(|placed| placed.turning);
        let (u_rate, v_rate) = (turning[0].cross(u), turning[1].cross(v));
        // The way from one line to the other is at right angles to both: two equations for how far along each.
        let between = at_v - at_u;
        let between_rate = placed[1].velocity_at(at_v) - placed[0].velocity_at(at_u);
        let (c, c_rate) = (u.dot(v), u_rate.dot(v) + u.dot(v_rate));
        let solve = |a: f64, b: f64| {
            let size = 1.0 - c * c;
            [(a - c * b) / size, (c * a - b) / size]
        };
        let [s, t] = solve(u.dot(between), v.dot(between));
        let a_rate = u_rate.dot(between) + u.dot(between_rate);
        let b_rate = v_rate.dot(between) + v.dot(between_rate);
        let [s_rate, t_rate] = solve(a_rate + c_rate * t, b_rate - c_rate * s);
        let point = (at_u + u * s + at_v + v * t) * 0.5;
        let moved =
            |placed: &Placed, from: Vec3, along: Vec3, rate: Vec3, by: f64, by_rate: f64| {
                placed.velocity_at(from) + rate * by + along * by_rate
            };
        let point_velocity = (moved(placed[0], at_u, u, u_rate, s, s_rate)
            + moved(placed[1], at_v, v, v_rate, t, t_rate))
            * 0.5;
        let normal = self.normal();
        let across_rate = (u_rate.cross(v) + u.cross(v_rate)) * self.turned;
        let normal_rate = across_rate.across(normal) * (1.0 / self.across.norm());
        Touch::across(
            self.overlap(),
            normal,
            normal_rate,
            point,
            point_velocity,
            placed,
        )
    }
}

impl Between {
    /// Returns the state of one of the contacts.
    pub fn touch(self, number: usize, pair: &Pair, placed: [&Placed; 2]) -> Touch {
        match self {
            Self::Face { of, face } => {
                let of = usize::from(of);
                let (owner, other) = (placed[of], placed[1 - of]);
                let (normal, offset) = pair.0[of].faces[usize::from(face)];
                let out = owner.rotation.out(normal);
                let out_rate = owner.turning.cross(out);
                let corners = &pair.0[1 - of].corners;
                // A solid with fewer corners has contacts at which nothing is.
                let corner = corners.get(number).copied();
                let place = other.position + other.rotation.out(corner.unwrap_or(Vec3::ZERO));
                let depth = offset - out.dot(place - owner.position);
                let velocity = other.velocity_at(place);
                let rate = out.dot(owner.velocity_at(place) - velocity);
                let point = place + out * (0.5 * depth);
                let point_velocity = velocity + (out_rate * depth + out * rate) * 0.5;
                let towards_first = if of == 0 { -1.0 } else { 1.0 };
                let touch = Touch::across(
                    depth,
                    out * towards_first,
                    out_rate * towards_first,
                    point,
                    point_velocity,
                    placed,
                );
                if corner.is_some() {
                    touch
                } else {
                    touch.of_none()
                }
            }
            Self::Edges { first, second } => {
                let touch = Crossing::new(first, second, pair, placed).touch(placed);
                if number < pair.share() {
                    touch
                } else {
                    touch.of_none()
                }
            }
        }
    }

    /// The plane of least overlap, and by how much less that is than what `now` has, where both solids touch across it.
    pub fn least(now: Option<Self>, pair: &Pair, placed: [&Placed; 2], slack: f64) -> Self {
        let lying = Lying::new(pair, placed);
        let mut least = now.map(|now| (now, lying.overlap(now)));
        if let Some((now, overlap)) = least
            && overlap <= slack
        {
            return now;
        }
        let mut look = |plane: Self| {
            let overlap = lying.overlap(plane);
            let is_less = least.is_none_or(|(_, least): (Self, f64)| {
                let margin = if least.is_finite() {
                    MARGIN * least.abs()
                } else {
                    0.0
                };
                overlap < least - margin.max(slack)
            });
            if is_less {
                least = Some((plane, overlap));
            }
            overlap
        };
        let mut is_apart = false;
        for (of, solid) in pair.0.iter().enumerate() {
            for face in 0..solid.faces.len() {
                let plane = Self::Face {
                    of: number(of),
                    face: number(face),
                };
                is_apart |= look(plane) <= 0.0;
            }
        }
        if !is_apart {
            for first in 0..pair.0[0].edges.len() {
                for second in 0..pair.0[1].edges.len() {
                    look(Self::Edges {
                        first: number(first),
                        second: number(second),
                    });
                }
            }
        }
        least.map_or(Self::Face { of: 0, face: 0 }, |(plane, _)| plane)
    }

    /// Whether each contact is at the same corner as with another plane.
    pub fn has_points_of(self, other: Self) -> bool {
        let corners = self.has_corners_of();
        corners.is_some() && corners == other.has_corners_of()
    }

    /// The solid whose corners touch, if corners do.
    fn has_corners_of(self) -> Option<u8> {
        match self {
            Self::Face { of, .. } => Some(1 - of),
            Self::Edges { .. } => None,
        }
    }
}

/// Two solids as they lie in the world.
struct Lying<'a> {
    pair: &'a Pair,
    placed: [&'a Placed; 2],
    corners: [Vec<Vec3>; 2],
    along: [Vec<Vec3>; 2],
}

impl<'a> Lying<'a> {
    fn new(pair: &'a Pair, placed: [&'a Placed; 2]) -> Self {
        let out = |side: usize, v: Vec3| placed[side].rotation.out(v);
        Self {
            corners: [0, 1].map(|side| {
                let corners = pair.0[side].corners.iter();
                corners
                    .map(|corner| placed[side].position + out(side, *corner))
                    .collect()
            }),
            along: [0, 1].map(|side| {
                let edges = 0..pair.0[side].edges.len();
                edges
                    .map(|edge| out(side, pair.0[side].along(edge)))
                    .collect()
            }),
            pair,
            placed,
        }
    }

    fn overlap(&self, plane: Between) -> f64 {
        match plane {
            Between::Face { of, face } => {
                let of = usize::from(of);
                let (normal, offset) = self.pair.0[of].faces[usize::from(face)];
                let out = self.placed[of].rotation.out(normal);
                let height = out.dot(self.placed[of].position) + offset;
                let depths = self.corners[1 - of].iter().map(|at| height - out.dot(*at));
                let deepest = depths.clone().fold(f64::NEG_INFINITY, f64::max);
                if deepest <= 0.0 {
                    return deepest;
                }
                let squares: f64 = depths.map(|depth| depth.max(0.0).powi(2)).sum();
                (squares / self.pair.share() as f64).sqrt()
            }
            Between::Edges { first, second } => {
                let edges = [usize::from(first), usize::from(second)];
                if !self.is_between(edges) {
                    return f64::INFINITY;
                }
                Crossing::new(first, second, self.pair, self.placed).overlap()
            }
        }
    }

    /// Whether all of each solid is on its own side of a plane along both edges that goes through its edge.
    fn is_between(&self, edges: [usize; 2]) -> bool {
        let across = self.along[0][edges[0]].cross(self.along[1][edges[1]]);
        let sine = across.norm();
        if sine <= PARALLEL {
            return false;
        }
        let normal = across * (1.0 / sine);
        let heights = |side: usize| {
            let from = self.pair.0[side].edges[edges[side]].ends[0];
            let from = normal.dot(self.corners[side][from]);
            self.corners[side]
                .iter()
                .map(move |corner| normal.dot(*corner) - from)
        };
        let is_behind = |side: usize| heights(side).all(|height| height <= IN_PLANE);
        let is_before = |side: usize| heights(side).all(|height| height >= -IN_PLANE);
        (is_behind(0) && is_before(1)) || (is_before(0) && is_behind(1))
    }
}

/// Assigns the old contacts to those of a new plane, nearest first. Contacts that do not touch take the remaining
/// indices.
pub(super) fn order_after(old: &[Touch], touched: &[bool], new: &[Touch]) -> Vec<usize> {
    let mut ways = Vec::new();
    for (from, one) in old.iter().enumerate().filter(|(from, _)| touched[*from]) {
        for (to, other) in new.iter().enumerate() {
            if other.penetration > 0.0 {
                ways.push(((one.point - other.point).norm(), from, to));
            }
        }
    }
    ways.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut order, mut taken) = (vec![None; new.len()], vec![false; new.len()]);
    for (_, from, to) in ways {
        if order[from].is_none() && !taken[to] {
            order[from] = Some(to);
            taken[to] = true;
        }
    }
    let mut left = (0..new.len()).filter(|&to| !taken[to]);
    let all = order.into_iter();
    all.map(|to: Option<usize>| to.or_else(|| left.next()).unwrap_or(0))
        .collect()
}
