//! A cylinder with a half-space, a flat-faced solid or another cylinder, and the candidate planes between them.
//!
//! The pair uses the plane of lowest energy of two kinds:
//!
//! - Planes with the other solid behind them: its faces, planes through one of its edges between the adjacent faces,
//!   and tangent planes of its side. The points of the cylinder's rims overlap them: E = K/2m sum of p^2, where m
//!   points share the law. The force thus balances at any position of the cylinder on the other solid.
//! - Planes with the cylinder behind them: its caps and the tangent planes of its side and rims. The other solid
//!   overlaps them by p at its deepest point, and E = K/2 p^2, as for two crossing edges. Such a plane has the lowest
//!   energy if a corner or rim touches the cylinder first. If a face or edge lies flat on the cylinder, a plane of
//!   the first kind has lower energy: its energy grows with the square of a tilt.
//!
//! From a family of planes the pair uses the one of lowest energy. For two cylinders "the cylinder" is the shorter
//! one, or the first if they are equal. Face indices: for a flat solid its faces, then its edges; for a cylinder its
//! caps, then its side.

use std::f64::consts::TAU;
use std::sync::Arc;

use super::crossing::across_rims;
use super::hulls::Flat;
use super::rims::Cylinder;
use super::zero::rising_zero;
use super::{Between, Bound, Found, PREFERENCE, Plane};
use crate::geometry::hull::Corners;
use crate::geometry::rigid::{Rigid, Vector3};

/// Number of directions around a cylinder in the search for the plane of least overlap at its side.
const DIRECTIONS: usize = 16;
/// Number of intervals between the two faces at an edge in the search for the plane of least overlap.
const PARTS: usize = 8;
/// Safety margin of a lower bound on an overlap, relative to the size of the solids, that covers rounding.
const ROUND_OFF: f64 = 1e-9;
/// Number of faces of a cylinder before its side.
const CAPS: usize = 2;
/// Planes with the cylinder behind them.
const AT_CAP: [Plane; CAPS] = [Plane::Edges([0, 0]), Plane::Edges([1, 0])];
const AT_SIDE: Plane = Plane::Edges([2, 0]);
const AT_RIM: Plane = Plane::Edges([3, 0]);

/// A solid at its current pose.
#[derive(Clone, Debug)]
pub(super) enum Form {
    Cylinder(Cylinder),
    Flat(Flat),
    /// Half-space of a body, in its own axes and at its current pose.
    HalfSpace {
        own: Bound,
        placed: Bound,
    },
}

/// An evaluated plane.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    plane: Plane,
    /// Half-space with one of the solids behind the plane.
    bound: Bound,
    /// Depth as in [`Between::least`] `[m]`.
    depth: f64,
}

/// A cylinder and another solid.
#[derive(Clone, Debug)]
pub(super) struct Cylinders {
    /// Index of the cylinder in the pair.
    side: usize,
    cylinder: Cylinder,
    other: Form,
    share: usize,
    /// Directions around a cylinder: angle, and its sine and cosine.
    directions: Arc<[(f64, (f64, f64)); DIRECTIONS + 1]>,
    /// Preallocated; the first `known` entries are valid.
    candidates: Vec<Candidate>,
    known: usize,
}

impl Candidate {
    fn none() -> Self {
        Self {
            plane: AT_RIM,
            bound: Bound {
                normal: Vector3::x(),
                offset: 0.0,
            },
            depth: f64::INFINITY,
        }
    }
}

impl Cylinders {
    /// Returns the half-space of the second, if it is one: normal and offset in its axes `[m]`.
    pub fn plane(&self) -> Option<(Vector3, f64)> {
        match self.other {
            Form::HalfSpace { own, .. } => Some((own.normal, own.offset)),
            _ => None,
        }
    }
}

impl Form {
    pub fn flat(corners: Arc<Corners>) -> Self {
        Self::Flat(Flat::new(corners))
    }

    pub fn half_space(normal: Vector3, offset: f64) -> Self {
        let own = Bound { normal, offset };
        Self::HalfSpace { own, placed: own }
    }

    fn place(&mut self, rigid: &Rigid) {
        match self {
            Self::Cylinder(cylinder) => cylinder.place(rigid),
            Self::Flat(flat) => flat.place(rigid),
            Self::HalfSpace { own, placed } => {
                let normal = rigid.orientation * own.normal;
                *placed = Bound {
                    normal,
                    offset: own.offset + normal.dot(&rigid.position),
                };
            }
        }
    }

    fn reach(&self) -> f64 {
        match self {
            Self::Cylinder(cylinder) => cylinder.reach(),
            Self::Flat(flat) => flat.reach,
            Self::HalfSpace { .. } => f64::INFINITY,
        }
    }

    /// Returns the number of flat faces.
    fn faces(&self) -> usize {
        match self {
            Self::Cylinder(_) => CAPS,
            Self::Flat(flat) => flat.normals.len(),
            Self::HalfSpace { .. } => 1,
        }
    }

    fn face(&self, number: usize) -> Bound {
        match self {
            Self::Cylinder(cylinder) => cylinder.cap(number),
            Self::Flat(flat) => Bound {
                normal: flat.normals[number],
                offset: flat.offsets[number],
            },
            Self::HalfSpace { placed, .. } => *placed,
        }
    }

    /// Returns the position that is deepest behind a plane.
    fn deepest(&self, bound: &Bound) -> Vector3 {
        match self {
            Self::Cylinder(cylinder) => cylinder.deepest(bound),
            Self::Flat(flat) => {
                let first = (f64::NEG_INFINITY, Vector3::zeros());
                let each = flat
                    .corners
                    .iter()
                    .map(|corner| (bound.depth(corner), *corner));
                each.fold(
                    first,
                    |most, here| if here.0 > most.0 { here } else { most },
                )
                .1
            }
            // A half-space has a deepest point only for its own plane.
            Self::HalfSpace { placed, .. } => placed.normal * placed.offset,
        }
    }
}

impl Cylinders {
    /// Creates the pair. `side`: the cylinder is the first (0) or second (1) solid. `share`: number of points that
    /// share the law, equal to the number per rim.
    pub fn new(side: usize, cylinder: Cylinder, other: Form, share: usize) -> Self {
        // Capacity for all possible planes.
        let of_other = match &other {
            Form::Flat(flat) => flat.normals.len() + flat.along.len(),
            form => form.faces() + 1,
        };
        let most = of_other + CAPS + 2;
        let step = TAU / DIRECTIONS as f64;
        let directions = std::array::from_fn(|number| {
            let angle = step * number as f64;
            (angle, angle.sin_cos())
        });
        Self {
            side,
            cylinder,
            other,
            share,
            directions: Arc::new(directions),
            candidates: vec![Candidate::none(); most],
            known: 0,
        }
    }

    pub fn reaches(&self) -> [f64; 2] {
        let (own, other) = (self.cylinder.reach(), self.other.reach());
        if self.side == 0 {
            [own, other]
        } else {
            [other, own]
        }
    }

    pub fn points(&self) -> usize {
        2 * self.share
    }

    pub fn copy_from(&mut self, other: &Self) {
        self.cylinder.copy_from(&other.cylinder);
    }

    #[cfg(test)]
    pub fn solids(&self) -> (&Cylinder, &Form) {
        (&self.cylinder, &self.other)
    }

    /// Sets the current poses. `before`: the previous plane, which is always evaluated.
    pub fn place(&mut self, rigids: [&Rigid; 2], before: Option<Plane>) {
        self.cylinder.place(rigids[self.side]);
        self.other.place(rigids[1 - self.side]);
        let mut candidates = std::mem::take(&mut self.candidates);
        self.known = self.look(before, &mut candidates);
        self.candidates = candidates;
    }

    /// Evaluates the planes until one separates the solids. Returns the number of evaluated planes.
    fn look(&self, before: Option<Plane>, candidates: &mut [Candidate]) -> usize {
        let mut known = 0;
        self.look_at_each(before, |plane, bound| {
            let depth = self.depth(plane, &bound);
            candidates[known] = Candidate {
                plane,
                bound,
                depth,
            };
            known += 1;
            depth
        });
        known
    }

    /// Returns a face of the other solid.
    fn face(&self, number: usize) -> Plane {
        let of = 1 - self.side;
        Plane::Face { of, number }
    }

    /// Enumerates the plane `before` and all planes that may have the lowest energy, or stops at a separating plane.
    /// `take` returns the overlap for a plane.
    fn look_at_each(&self, before: Option<Plane>, mut take: impl FnMut(Plane, Bound) -> f64) {
        let (mut depth, mut face) = (f64::INFINITY, 0);
        for number in 0..self.other.faces() {
            let here = take(self.face(number), self.other.face(number));
            if here <= 0.0 {
                return;
            }
            if here < depth {
                (depth, face) = (here, number);
            }
        }
        if matches!(self.other, Form::HalfSpace { .. }) {
            return;
        }
        let least = self.least_at_own_side(face);
        let mut own_side = None;
        if before == Some(AT_SIDE) || least <= depth {
            own_side = self.at_own_side();
        }
        let mut is_apart = |plane: Plane, bound: Option<Bound>| {
            let here = bound.map_or(f64::INFINITY, |bound| take(plane, bound));
            depth = depth.min(here);
            here <= 0.0
        };
        if (0..CAPS).any(|cap| is_apart(AT_CAP[cap], Some(self.cylinder.cap(cap))))
            || is_apart(AT_SIDE, own_side)
        {
            return;
        }
        match &self.other {
            Form::Flat(flat) => {
                // A point of the cylinder: for any plane between the faces at an edge, it is as deep as for one of
                // these faces.
                let place = self.cylinder.deepest(&self.other.face(face));
                for (edge, own) in flat.own.edges.iter().enumerate() {
                    let depths = own.faces.map(|face| self.other.face(face).depth(&place));
                    if depths[0].min(depths[1]) > depth * (self.share as f64).sqrt() {
                        continue;
                    }
                    let bound = self.at_edge(flat, edge);
                    let here = bound.map_or(f64::INFINITY, |bound| {
                        take(self.face(flat.normals.len() + edge), bound)
                    });
                    if here <= 0.0 {
                        return;
                    }
                    depth = depth.min(here);
                }
            }
            Form::Cylinder(other) => {
                let side = self.at_side_of(other);
                if is_apart(self.face(CAPS), side) {
                    return;
                }
                is_apart(
                    AT_RIM,
                    across_rims([&self.cylinder, other], [own_side, side]),
                );
            }
            Form::HalfSpace { .. } => {}
        }
    }

    fn depth(&self, plane: Plane, bound: &Bound) -> f64 {
        if plane.corners_of().is_none() {
            return bound.depth(&self.other.deepest(bound));
        }
        let (deepest, squares) = self.cylinder.behind(bound);
        if deepest > 0.0 {
            (squares / self.share as f64).sqrt()
        } else {
            deepest
        }
    }

    /// Returns a lower bound of the overlap of a flat solid with the planes at the cylinder's side. The bound is the
    /// overlap of a point near the axis, below the centre of the deeper cap behind a face. It spares the search for
    /// most upright cylinders.
    fn least_at_own_side(&self, face: usize) -> f64 {
        let Form::Flat(flat) = &self.other else {
            return f64::NEG_INFINITY;
        };
        let own = &self.cylinder;
        let (axis, bound) = (own.axes[2], self.other.face(face));
        let along = own.half_length.copysign(bound.normal.dot(&axis));
        let middle = own.centre - axis * along;
        let place = middle + bound.normal * bound.depth(&middle).min(0.0);
        let is_in = |number| number == face || self.other.face(number).depth(&place) >= 0.0;
        if !(0..flat.normals.len()).all(is_in) {
            return f64::NEG_INFINITY;
        }
        let way = place - own.centre;
        let off_axis = (way - axis * way.dot(&axis)).norm();
        own.radius - off_axis - ROUND_OFF * (own.reach() + flat.reach)
    }

    /// Returns the plane of least overlap among those tangent to the cylinder's side.
    fn at_own_side(&self) -> Option<Bound> {
        let slope = |turn: (f64, f64)| {
            let [bound, rate] = self.cylinder.tangent_at(turn);
            rate.depth(&self.other.deepest(&bound))
        };
        self.around(AT_SIDE, slope, |angle| self.cylinder.tangent(angle)[0])
    }

    /// Returns the plane of least overlap among those tangent to the side of another cylinder.
    fn at_side_of(&self, other: &Cylinder) -> Option<Bound> {
        let slope = |turn: (f64, f64)| {
            let [bound, rate] = other.tangent_at(turn);
            self.cylinder.slope(&bound, &rate)
        };
        self.around(self.face(CAPS), slope, |angle| other.tangent(angle)[0])
    }

    /// Returns the plane of least overlap around a cylinder. `slope` is a function of the sine and cosine of the angle.
    fn around(
        &self,
        plane: Plane,
        slope: impl Fn((f64, f64)) -> f64,
        at: impl Fn(f64) -> Bound,
    ) -> Option<Bound> {
        let first = slope(self.directions[0].1);
        let ends = (0..=DIRECTIONS).map(|number| {
            let (angle, turn) = self.directions[number];
            // The loop is closed: rounding must not make the first and the last entry differ.
            let is_first = number % DIRECTIONS == 0;
            (angle, if is_first { first } else { slope(turn) })
        });
        self.least_of(plane, ends, |angle| slope(angle.sin_cos()), at)
    }

    /// Returns the plane of least overlap among those through an edge between its two faces, if it is not one of the
    /// faces.
    fn at_edge(&self, flat: &Flat, number: usize) -> Option<Bound> {
        let [first, last] = flat.at(number);
        let place = flat.begin(number);
        let cosine = first.dot(last);
        // Perpendicular to the first normal, in the plane of both.
        let across = last - first * cosine;
        let sine = across.norm();
        let across = across / sine;
        let at = |angle: f64| {
            let (s, c) = angle.sin_cos();
            let through = |normal: Vector3| Bound {
                normal,
                offset: normal.dot(place),
            };
            [
                through(first * c + across * s),
                through(across * c - first * s),
            ]
        };
        let slope = |angle: f64| {
            let [bound, rate] = at(angle);
            self.cylinder.slope(&bound, &rate)
        };
        let step = sine.atan2(cosine) / PARTS as f64;
        let ends = (0..=PARTS).map(|number| {
            let angle = step * number as f64;
            (angle, slope(angle))
        });
        self.least_of(self.face(0), ends, slope, |angle| at(angle)[0])
    }

    /// Returns the plane of least overlap of a family: searches all intervals between successive `ends` in which the
    /// overlap first falls and then rises.
    fn least_of(
        &self,
        plane: Plane,
        mut ends: impl Iterator<Item = (f64, f64)>,
        slope: impl Fn(f64) -> f64,
        at: impl Fn(f64) -> Bound,
    ) -> Option<Bound> {
        let mut least: Option<(f64, Bound)> = None;
        let mut low = ends.next()?;
        for high in ends {
            // The slope is zero everywhere for coaxial cylinders.
            if low.1 <= 0.0 && high.1 >= 0.0 {
                let angle = if high.1 == 0.0 {
                    high.0
                } else if low.1 == 0.0 {
                    low.0
                } else {
                    rising_zero(low, high, &slope)
                };
                let bound = at(angle);
                let depth = self.depth(plane, &bound);
                if least.is_none_or(|(least, _)| depth < least) {
                    least = Some((depth, bound));
                }
            }
            low = high;
        }
        Some(least?.1)
    }

    /// Returns the half-space of a plane. A plane through an edge that no longer exists becomes one of the two faces
    /// there; any other becomes the plane that replaces it.
    fn bound(&self, plane: Plane) -> Bound {
        let find = |plane: Plane| {
            let mut known = self.candidates[..self.known].iter();
            known.find(|candidate| candidate.plane == plane)
        };
        if let Some(candidate) = find(plane) {
            return candidate.bound;
        }
        if let (Plane::Face { number, .. }, Form::Flat(flat)) = (plane, &self.other)
            && let Some(edge) = number.checked_sub(flat.normals.len())
        {
            let faces = flat.own.edges[edge].faces;
            let [one, last] = faces.map(|face| self.other.face(face));
            return if self.depth(plane, &one) <= self.depth(plane, &last) {
                one
            } else {
                last
            };
        }
        let after = self.least(None).0;
        let bound = find(after).map_or(self.other.face(0), |candidate| candidate.bound);
        if after.corners_of() == plane.corners_of() {
            bound
        } else {
            bound.turned_round()
        }
    }

    /// Updates the rotation of the cylinder's points for the selected plane.
    pub fn turn(&mut self, plane: Plane) {
        if plane.corners_of().is_some() {
            let bound = self.bound(plane);
            self.cylinder.turn(&bound);
        }
    }
}

impl Between for Cylinders {
    fn least(&self, before: Option<Plane>) -> (Plane, f64) {
        let mut least = (Plane::Face { of: 0, number: 0 }, f64::INFINITY);
        let mut least_counted = f64::INFINITY;
        for candidate in &self.candidates[..self.known] {
            let depth = candidate.depth;
            let counted = if Some(candidate.plane) == before {
                depth - PREFERENCE * depth.abs()
            } else {
                depth
            };
            if counted < least_counted {
                least_counted = counted;
                least = (candidate.plane, depth);
            }
        }
        least
    }

    fn normal(&self, plane: Plane) -> Vector3 {
        let out = self.bound(plane).normal;
        let behind = plane.corners_of().map_or(self.side, |of| 1 - of);
        if behind == 0 { -out } else { out }
    }

    fn points(&self, plane: Plane, found: &mut [Found]) {
        let bound = self.bound(plane);
        let at = |place: Vector3| {
            let depth = bound.depth(&place);
            Found {
                penetration: depth,
                place: place + bound.normal * (0.5 * depth),
            }
        };
        if plane.corners_of().is_some() {
            for (found, place) in found.iter_mut().zip(self.cylinder.places(&bound)) {
                *found = at(place);
            }
        } else {
            let Found { penetration, place } = at(self.other.deepest(&bound));
            Found::cross(found, penetration, place, self.share);
        }
    }

    /// Returns `false`: the points of a rim rotate.
    fn keeps_points(&self) -> bool {
        false
    }
}
