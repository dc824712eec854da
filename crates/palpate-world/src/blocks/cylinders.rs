//! A cylinder and a half-space, a solid with flat faces or another cylinder, and the planes that may be between them.
//!
//! Each plane has one of the two solids behind it, and the corners, or the points of the rims, of the other overlap it:
//! E = K/2m sum of p^2, where m share the law. The planes are the flat faces of both; those that touch the side of a cylinder; those
//! through an edge of a flat solid, between its two faces; and of two cylinders those that touch a rim of each, as where two edges cross.
//! Of a family of planes the pair takes that of least E.
//!
//! Faces are numbered so: of a cylinder its caps, 0 and 1, and its side, 2; of a flat solid its faces, and then its edges.

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
/// Faces of a cylinder before its side.
const CAPS: usize = 2;
/// The plane at two rims.
const RIMS: Plane = Plane::Edges([0, 0]);

/// One of the two solids, as it lies.
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
    /// With one of the solids behind it; of two rims the second.
    bound: Bound,
    /// As of [`Between::least`] `[m]`.
    depth: f64,
}

/// A cylinder and another solid.
#[derive(Clone, Debug)]
pub(super) struct Cylinders {
    forms: [Form; 2],
    share: usize,
    /// Of these the first `known` have been looked at: a tick asks for no more room.
    candidates: Vec<Candidate>,
    known: usize,
}

impl Candidate {
    fn none() -> Self {
        Self {
            plane: RIMS,
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

    /// How many points overlap others' planes.
    fn points(&self) -> usize {
        match self {
            Self::Cylinder(cylinder) => cylinder.points(),
            Self::Flat(flat) => flat.corners.len(),
            Self::HalfSpace { .. } => 0,
        }
    }

    /// Depth of the deepest point behind a plane `[m]`, and the sum of the squares of the depths above 0 `[m^2]`.
    fn behind(&self, bound: &Bound) -> (f64, f64) {
        match self {
            Self::Cylinder(cylinder) => cylinder.behind(bound),
            Self::Flat(flat) => {
                let (mut deepest, mut squares) = (f64::NEG_INFINITY, 0.0);
                for corner in &flat.corners {
                    let depth = bound.depth(corner);
                    deepest = depth.max(deepest);
                    squares += depth.max(0.0).powi(2);
                }
                (deepest, squares)
            }
            // None of its points is at an end of it.
            Self::HalfSpace { .. } => (f64::INFINITY, f64::INFINITY),
        }
    }

    /// The slope of that, as of [`Cylinder::slope`].
    fn slope(&self, bound: &Bound, rate: &Bound) -> f64 {
        match self {
            Self::Cylinder(cylinder) => cylinder.slope(bound, rate),
            Self::Flat(flat) => {
                let (mut deepest, mut of_deepest, mut slope) = (f64::NEG_INFINITY, 0.0, 0.0);
                for corner in &flat.corners {
                    let (depth, by) = (bound.depth(corner), rate.depth(corner));
                    if depth > deepest {
                        (deepest, of_deepest) = (depth, by);
                    }
                    slope += depth.max(0.0) * by;
                }
                if deepest > 0.0 { slope } else { of_deepest }
            }
            Self::HalfSpace { .. } => 0.0,
        }
    }
}

impl Cylinders {
    /// `share`: how many points have the law together, as many as each rim has. One of the two is a cylinder.
    pub fn new(forms: [Form; 2], share: usize) -> Self {
        // As many planes as there can be.
        let most = forms.iter().map(|form| match form {
            Form::Flat(flat) => flat.normals.len() + flat.along.len(),
            form => form.faces() + 1,
        });
        let most = most.sum::<usize>() + 1;
        Self {
            forms,
            share,
            candidates: vec![Candidate::none(); most],
            known: 0,
        }
    }

    pub fn reaches(&self) -> [f64; 2] {
        self.forms.each_ref().map(Form::reach)
    }

    #[cfg(test)]
    pub fn forms(&self) -> &[Form; 2] {
        &self.forms
    }

    pub fn points(&self) -> usize {
        self.forms.iter().map(Form::points).max().unwrap_or(0)
    }

    pub fn copy_from(&mut self, other: &Self) {
        for (form, other) in self.forms.iter_mut().zip(&other.forms) {
            if let (Form::Cylinder(form), Form::Cylinder(other)) = (form, other) {
                form.copy_from(other);
            }
        }
    }

    /// They lie so now: looks at all planes, or until one is between the two.
    pub fn place(&mut self, rigids: [&Rigid; 2]) {
        for (form, rigid) in self.forms.iter_mut().zip(rigids) {
            form.place(rigid);
        }
        let mut candidates = std::mem::take(&mut self.candidates);
        self.known = self.look(&mut candidates);
        self.candidates = candidates;
    }

    /// Looks at the planes until one is between the two. Says at how many.
    fn look(&self, candidates: &mut [Candidate]) -> usize {
        let mut known = 0;
        self.look_at_each(|plane, bound| {
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

    /// Gives all planes, or those up to one that is between the two; `take` says by how much the two overlap there.
    fn look_at_each(&self, mut take: impl FnMut(Plane, Bound) -> f64) {
        if let Some(of) = self.half_space() {
            take(Plane::Face { of, number: 0 }, self.forms[of].face(0));
            return;
        }
        let mut least = [(f64::INFINITY, None); 2];
        for (of, form) in self.forms.iter().enumerate() {
            for number in 0..form.faces() {
                let bound = form.face(number);
                let depth = take(Plane::Face { of, number }, bound);
                if depth <= 0.0 {
                    return;
                }
                if depth < least[of].0 {
                    least[of] = (depth, Some(bound));
                }
            }
        }
        let sides = [0, 1].map(|of| self.at_side(of));
        let mut depth = least[0].0.min(least[1].0);
        for (of, side) in sides.into_iter().enumerate() {
            if let Some(bound) = side {
                depth = depth.min(take(Plane::Face { of, number: CAPS }, bound));
            }
        }
        if depth <= 0.0 {
            return;
        }
        for of in [0, 1] {
            let (Form::Flat(flat), Form::Cylinder(cylinder), Some(bound)) =
                (&self.forms[of], &self.forms[1 - of], least[of].1)
            else {
                continue;
            };
            // A place of the cylinder: whatever plane is between the faces at an edge, it is as deep as behind one of these.
            let place = cylinder.deepest(&bound);
            for edge in 0..flat.along.len() {
                let faces = flat.own.edges[edge].faces;
                let least_depth = faces
                    .map(|face| self.forms[of].face(face).depth(&place))
                    .into_iter()
                    .fold(f64::INFINITY, f64::min);
                if least_depth > depth * (self.share as f64).sqrt() {
                    continue;
                }
                let number = flat.normals.len() + edge;
                if let Some(bound) = self.at_edge(of, edge) {
                    let here = take(Plane::Face { of, number }, bound);
                    if here <= 0.0 {
                        return;
                    }
                    depth = depth.min(here);
                }
            }
        }
        if let [Form::Cylinder(first), Form::Cylinder(second)] = &self.forms
            && let Some(bound) = across_rims([first, second], sides)
        {
            take(RIMS, bound);
        }
    }

    fn half_space(&self) -> Option<usize> {
        let is_half_space = |form: &Form| matches!(form, Form::HalfSpace { .. });
        self.forms.iter().position(is_half_space)
    }

    fn depth(&self, plane: Plane, bound: &Bound) -> f64 {
        let points_of = plane.corners_of();
        let (deepest, squares) = self.forms[points_of.unwrap_or(0)].behind(bound);
        if deepest > 0.0 && points_of.is_some() {
            (squares / self.share as f64).sqrt()
        } else {
            deepest
        }
    }

    /// Of all planes that touch the side of a cylinder, that of least overlap.
    fn at_side(&self, of: usize) -> Option<Bound> {
        let Form::Cylinder(cylinder) = &self.forms[of] else {
            return None;
        };
        let other = &self.forms[1 - of];
        let slope = |angle: f64| {
            let [bound, rate] = cylinder.tangent(angle);
            other.slope(&bound, &rate)
        };
        let step = TAU / DIRECTIONS as f64;
        let first = slope(0.0);
        let ends = (0..=DIRECTIONS).map(|number| {
            let angle = step * number as f64;
            // Once around: round-off must not make the first and the last another one.
            let is_first = number % DIRECTIONS == 0;
            (angle, if is_first { first } else { slope(angle) })
        });
        self.least_of(of, ends, slope, |angle| cylinder.tangent(angle)[0])
    }

    /// Of all planes through an edge between its two faces that of least overlap, where that is none of the two.
    fn at_edge(&self, of: usize, number: usize) -> Option<Bound> {
        let Form::Flat(flat) = &self.forms[of] else {
            return None;
        };
        let other = &self.forms[1 - of];
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
            other.slope(&bound, &rate)
        };
        let step = sine.atan2(cosine) / PARTS as f64;
        let ends = (0..=PARTS).map(|number| {
            let angle = step * number as f64;
            (angle, slope(angle))
        });
        self.least_of(of, ends, slope, |angle| at(angle)[0])
    }

    /// Of a family of planes that have the solid `of` behind them, that of least overlap: of all between two of the `ends` from the first
    /// of which the overlap falls and towards the second of which it rises.
    fn least_of(
        &self,
        of: usize,
        mut ends: impl Iterator<Item = (f64, f64)>,
        slope: impl Fn(f64) -> f64,
        at: impl Fn(f64) -> Bound,
    ) -> Option<Bound> {
        let mut least: Option<(f64, Bound)> = None;
        let mut low = ends.next()?;
        for high in ends {
            if low.1 < 0.0 && high.1 >= 0.0 {
                let angle = if high.1 > 0.0 {
                    rising_zero(low, high, &slope)
                } else {
                    high.0
                };
                let bound = at(angle);
                let depth = self.depth(Plane::Face { of, number: 0 }, &bound);
                if least.is_none_or(|(least, _)| depth < least) {
                    least = Some((depth, bound));
                }
            }
            low = high;
        }
        Some(least?.1)
    }

    /// Where a plane is. One through an edge that there is not any more has come to one of the two faces there, and one at two rims to
    /// the plane that has taken over.
    fn bound(&self, plane: Plane) -> Bound {
        let known = &self.candidates[..self.known];
        if let Some(candidate) = known.iter().find(|candidate| candidate.plane == plane) {
            return candidate.bound;
        }
        match plane {
            Plane::Face { of, number } => match &self.forms[of] {
                Form::Flat(flat) if number >= flat.normals.len() => {
                    let faces = flat.own.edges[number - flat.normals.len()].faces;
                    let [one, other] = faces.map(|face| self.forms[of].face(face));
                    if self.depth(plane, &one) <= self.depth(plane, &other) {
                        one
                    } else {
                        other
                    }
                }
                form => form.face(number.min(form.faces() - 1)),
            },
            Plane::Edges(_) => match self.least(None).0 {
                Plane::Edges(_) => self.forms[1].face(0),
                after @ Plane::Face { of: 0, .. } => self.bound(after).turned_round(),
                after => self.bound(after),
            },
        }
    }

    /// The points of a cylinder come to be turned as they are behind the plane that is taken.
    pub fn turn(&mut self, plane: Plane) {
        let bound = self.bound(plane);
        if let Some(of) = plane.corners_of()
            && let Form::Cylinder(cylinder) = &mut self.forms[of]
        {
            cylinder.turn(&bound);
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
        if plane.corners_of() == Some(1) {
            -out
        } else {
            out
        }
    }

    fn points(&self, plane: Plane, found: &mut [Found]) {
        let bound = self.bound(plane);
        let Some(of) = plane.corners_of() else {
            if let [Form::Cylinder(first), Form::Cylinder(second)] = &self.forms {
                let one = first.deepest(&bound);
                let other = second.deepest(&bound.turned_round());
                let penetration = bound.normal.dot(&(other - one));
                Found::cross(found, penetration, 0.5 * (one + other), self.share);
            }
            return;
        };
        found.fill(Found::none());
        let at = |place: Vector3| {
            let depth = bound.depth(&place);
            Found {
                penetration: depth,
                place: place + bound.normal * (0.5 * depth),
            }
        };
        match &self.forms[of] {
            Form::Cylinder(cylinder) => {
                for (found, place) in found.iter_mut().zip(cylinder.places(&bound)) {
                    *found = at(place);
                }
            }
            Form::Flat(flat) => {
                for (found, corner) in found.iter_mut().zip(&flat.corners) {
                    *found = at(*corner);
                }
            }
            Form::HalfSpace { .. } => {}
        }
    }

    /// The corners of a flat solid do, the points of a rim do not.
    fn keeps_points(&self, of: usize) -> bool {
        matches!(self.forms[of], Form::Flat(_))
    }
}
