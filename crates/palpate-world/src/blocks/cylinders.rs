//! A cylinder and a half-space, a solid with flat faces or another cylinder, and the planes that may be between them.
//!
//! The plane that the pair takes is that of least energy of two kinds:
//!
//! - Planes that have the other solid behind them: its faces, those through one of its edges and between the faces there, and those
//!   that touch its side. The points of the cylinder's rims overlap them: E = K/2m sum of p^2, where m share the law. So the force
//!   balances where both solids are, wherever the cylinder stands on the other.
//! - Planes that have the cylinder behind them: its caps and those that touch its side or a rim. The other solid overlaps them by p
//!   where it is deepest, and E = K/2 p^2, as where two edges cross. Such a plane costs least where a corner or rim is the first to meet
//!   the cylinder. Where a face or edge lies flat on it, a plane of the first kind costs less: its energy grows with the square of a tilt.
//!
//! Of a family of planes the pair takes that of least energy. Of two cylinders the shorter one is "the cylinder", of equals the first.
//! Faces are numbered so: of a flat solid its faces, and then its edges; of a cylinder its caps, and then its side.

use std::f64::consts::TAU;
use std::sync::Arc;

use super::crossing::across_rims;
use super::hulls::Flat;
use super::rims::Cylinder;
use super::zero::rising_zero;
use super::{Between, Bound, Found, PREFERENCE, Plane};
use crate::hull::Corners;
use crate::rigid::{Rigid, Vector3};

/// Directions around a cylinder from which the plane of least overlap at its side is looked for.
const DIRECTIONS: usize = 16;
/// Parts of the way from one face at an edge to the other, in each of which the plane of least overlap is looked for.
const PARTS: usize = 8;
/// A bound on an overlap is lower by this part of the solids' size, so that a plane which is not looked at would not have been taken.
const ROUND_OFF: f64 = 1e-9;
/// Faces of a cylinder before its side.
const CAPS: usize = 2;
/// The planes that have the cylinder behind them.
const AT_CAP: [Plane; CAPS] = [Plane::Edges([0, 0]), Plane::Edges([1, 0])];
const AT_SIDE: Plane = Plane::Edges([2, 0]);
const AT_RIM: Plane = Plane::Edges([3, 0]);

/// A solid, as it lies.
#[derive(Clone, Debug)]
pub(super) enum Form {
    Cylinder(Cylinder),
    Flat(Flat),
    /// Of a body, in its own axes and as that lies.
    HalfSpace {
        own: Bound,
        placed: Bound,
    },
}

/// A plane that has been looked at.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    plane: Plane,
    /// With one of the solids behind it.
    bound: Bound,
    /// As of [`Between::least`] `[m]`.
    depth: f64,
}

/// A cylinder and another solid.
#[derive(Clone, Debug)]
pub(super) struct Cylinders {
    /// Which of the two is the cylinder.
    side: usize,
    cylinder: Cylinder,
    other: Form,
    share: usize,
    /// Of these the first `known` have been looked at: a tick asks for no more room.
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

    /// How many flat faces it has.
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

    /// The place that is deepest behind a plane.
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
            // None of its places is deepest behind any plane but its own.
            Self::HalfSpace { placed, .. } => placed.normal * placed.offset,
        }
    }
}

impl Cylinders {
    /// `side`: the cylinder is the first (0) or second (1) of the two; `share`: how many points have the law together, as many as each
    /// rim has.
    pub fn new(side: usize, cylinder: Cylinder, other: Form, share: usize) -> Self {
        // As many planes as there can be.
        let of_other = match &other {
            Form::Flat(flat) => flat.normals.len() + flat.along.len(),
            form => form.faces() + 1,
        };
        let most = of_other + CAPS + 2;
        Self {
            side,
            cylinder,
            other,
            share,
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

    /// They lie so now. `before`: the plane that was taken, which is looked at whatever it costs now.
    pub fn place(&mut self, rigids: [&Rigid; 2], before: Option<Plane>) {
        self.cylinder.place(rigids[self.side]);
        self.other.place(rigids[1 - self.side]);
        let mut candidates = std::mem::take(&mut self.candidates);
        self.known = self.look(before, &mut candidates);
        self.candidates = candidates;
    }

    /// Looks at the planes until one is between the two. Says at how many.
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

    /// A face of the other solid, by its number.
    fn face(&self, number: usize) -> Plane {
        let of = 1 - self.side;
        Plane::Face { of, number }
    }

    /// Gives all planes that may cost least and that of `before`, or those up to one that is between the two; `take` says by how much the
    /// two overlap there.
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
                // A place of the cylinder: whatever plane is between the faces at an edge, that place is as deep as behind one of them.
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

    /// By how much a flat solid overlaps the planes at the cylinder's side, at least: by that with which a place of it does that is
    /// near the axis, under the middle of the deeper cap behind a face. Most cylinders stand, and need not look for the plane.
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

    /// Of all planes that touch the cylinder's side, that of least overlap.
    fn at_own_side(&self) -> Option<Bound> {
        let tangent = |angle: f64| self.cylinder.tangent(angle);
        let slope = |angle: f64| {
            let [bound, rate] = tangent(angle);
            rate.depth(&self.other.deepest(&bound))
        };
        self.around(AT_SIDE, slope, |angle| tangent(angle)[0])
    }

    /// Of all planes that touch the side of another cylinder.
    fn at_side_of(&self, other: &Cylinder) -> Option<Bound> {
        let slope = |angle: f64| {
            let [bound, rate] = other.tangent(angle);
            self.cylinder.slope(&bound, &rate)
        };
        self.around(self.face(CAPS), slope, |angle| other.tangent(angle)[0])
    }

    fn around(
        &self,
        plane: Plane,
        slope: impl Fn(f64) -> f64,
        at: impl Fn(f64) -> Bound,
    ) -> Option<Bound> {
        let step = TAU / DIRECTIONS as f64;
        let first = slope(0.0);
        let ends = (0..=DIRECTIONS).map(|number| {
            let angle = step * number as f64;
            // Once around: round-off must not make the first and the last another one.
            let is_first = number % DIRECTIONS == 0;
            (angle, if is_first { first } else { slope(angle) })
        });
        self.least_of(plane, ends, &slope, at)
    }

    /// Of all planes through an edge between its two faces that of least overlap, where that is none of the two.
    fn at_edge(&self, flat: &Flat, number: usize) -> Option<Bound> {
        let [first, last] = flat.at(number);
        let place = flat.begin(number);
        let cosine = first.dot(last);
        // Across the first normal, in the plane of the two.
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

    /// Of a family of planes that of least overlap: of all between two of the `ends` from the first of which the overlap falls and
    /// towards the second of which it rises.
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
            // The slope is 0 throughout where the two have one axis.
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

    /// Where a plane is. One through an edge that there is not any more has come to one of the two faces there, another one to the
    /// plane that has taken over.
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

    /// The points of the cylinder come to be turned as they are behind the plane that is taken.
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

    /// The points of a rim turn.
    fn keeps_points(&self) -> bool {
        false
    }
}
