//! Contact of a cylinder with a solid with flat faces or with another cylinder: the separating plane and the contact
//! points.
//!
//! A plane whose far side contains the other solid has the two rims of the cylinder behind it. Each rim has m points
//! that share the law. A plane whose far side contains the cylinder has corners of the other solid behind it. The
//! deepest corner takes the whole law: with springs at all corners, those of a large table would pull an off-centre can
//! to one side. As for two solids with flat faces, the contact plane is the one with the least overlap.
//!
//! Two cylinders have planes of the same kinds. The ends and the side of the other cylinder have the rims of this one
//! behind them. The planes of this cylinder have the deepest point of the other cylinder's rims behind them. If a rim
//! meets a rim, the plane touches both.
//!
//! If a whole rim is behind the plane, its points keep their positions on it (*held*), because the sum of their squared
//! depths does not depend on the rotation. Otherwise they turn with the deepest point of the rim (*turned*).

use std::f64::consts::TAU;

use super::between::{Flat, MARGIN, number};
use super::contact::{Placed, Touch};
use super::crossing::Crossing;
use super::tangent::{Family, PARTS, Through};
use super::tube::{Behind, Moving, Point, Tube, side_of};
use super::vector::Vec3;

/// Points of a rim, at least.
const FEWEST: usize = 4;
/// Corners of which the depths differ by no more than this are equally deep `[m]`.
const ALIKE: f64 = 1e-14;
/// Largest change of a plane's name at once, in parts of a family.
const NEAR: u8 = 4;

/// Position of the points of a rim, up to a number of steps from point to point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Rim {
    /// This number of steps back from the cylinder's x axis.
    Held(u8),
    /// This number of steps back from the deepest point.
    Turned(u8),
}

/// A plane between a cylinder and a solid with flat faces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Plane {
    /// A face of the solid, by its number.
    Face(u8),
    /// An end of the cylinder: 0 or 1, as its rim; and the deepest corner behind it, by its number.
    End(u8, u8),
    /// The one that is tangent to the cylinder's side next to a corner of the solid, by that corner's number.
    Side(u8),
    /// One that is tangent to the cylinder's side next to a rim of another cylinder, by that rim and its own name.
    SideAtRim(u8, u8),
    /// One that is tangent to another cylinder's side, by its name.
    Around(u8),
    /// One that touches a rim of each of two cylinders, and its name.
    Rims(Crossing, u8),
    /// One through an edge of the solid, by that edge's number and its own name.
    Edge(u8, u8),
}

impl Plane {
    /// The corner behind it, or the rim whose deepest place is, if it has the cylinder on its far side.
    fn corner(self) -> Option<usize> {
        match self {
            Self::End(_, corner) | Self::Side(corner) | Self::SideAtRim(corner, _) => {
                Some(usize::from(corner))
            }
            Self::Rims(Crossing { rims, .. }, _) => Some(usize::from(rims[1])),
            Self::Face(_) | Self::Edge(..) | Self::Around(_) => None,
        }
    }

    /// Whether it is another one only by a name that has changed.
    fn is_same(self, other: Self) -> bool {
        let is_near = |one: u8, other: u8| {
            let off = one.abs_diff(other);
            off.min(PARTS.abs_diff(off)) <= NEAR
        };
        match (self, other) {
            (Self::Edge(edge, name), Self::Edge(of, other)) => {
                edge == of && name.abs_diff(other) <= NEAR
            }
            (Self::SideAtRim(rim, name), Self::SideAtRim(of, other)) => {
                rim == of && is_near(name, other)
            }
            (Self::Around(name), Self::Around(other)) => is_near(name, other),
            (Self::Rims(one, name), Self::Rims(of, other)) => one == of && is_near(name, other),
            (one, other) => one == other,
        }
    }
}

/// Contact state of a cylinder and a solid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct OnCylinder {
    pub plane: Plane,
    pub rims: [Rim; 2],
}

impl OnCylinder {
    /// Returns whether each contact keeps its point in a change from the state `other`.
    pub fn has_points_of(self, other: Self) -> bool {
        self.plane.is_same(other.plane)
    }

    /// Whether it is the other one but for a name.
    pub fn is_same(self, other: Self) -> bool {
        self.plane.is_same(other.plane) && self.rims == other.rims
    }
}

/// A cylinder and the solid that it is on.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Cylinder {
    /// Whether the cylinder is the first of the two.
    pub is_first: bool,
    pub radius: f64,
    pub half_length: f64,
    pub flat: Flat,
    /// Radius and half length of the other, if that is a cylinder as well; its ends are its flat faces.
    pub other: Option<[f64; 2]>,
    /// Of the angles from one point of a rim to each.
    pub cosines: Vec<f64>,
}

impl Cylinder {
    pub fn new(is_first: bool, [radius, half_length]: [f64; 2], flat: Flat) -> Self {
        let share = flat.most.max(FEWEST);
        let angles = (0..share).map(|point| TAU * point as f64 / share as f64);
        Self {
            is_first,
            radius,
            half_length,
            flat,
            other: None,
            cosines: angles.map(f64::cos).collect(),
        }
    }

    /// A cylinder on another one.
    pub fn on_another(is_first: bool, one: [f64; 2], other: [f64; 2]) -> Self {
        let ends = [-1.0, 1.0].map(|side| (Vec3([0.0, 0.0, side]), other[1]));
        let flat = Flat {
            corners: Vec::new(),
            faces: ends.to_vec(),
            edges: Vec::new(),
            most: 0,
        };
        Self {
            other: Some(other),
            ..Self::new(is_first, one, flat)
        }
    }

    /// Returns the number of points that share the law.
    pub fn share(&self) -> usize {
        self.cosines.len()
    }

    /// Returns the number of contacts.
    pub fn contacts(&self) -> usize {
        (2 * self.share()).max(self.flat.corners.len())
    }

    /// Returns the required contact state, for the present state `now`.
    pub fn wanted(&self, now: Option<OnCylinder>, placed: [&Placed; 2], slack: f64) -> OnCylinder {
        let lying = Lying::new(self, placed);
        let plane = lying.least(now.map(|now| now.plane), slack);
        let same = now.filter(|now| now.plane.is_same(plane));
        OnCylinder {
            plane,
            rims: lying.rims(plane, same.map(|now| now.rims), slack),
        }
    }

    /// Computes the contacts from `first` on, as many as `found` has space for.
    pub fn touch(&self, first: usize, at: OnCylinder, placed: [&Placed; 2], found: &mut [Touch]) {
        let lying = Lying::new(self, placed);
        let plane = lying.moving(at.plane);
        for (number, found) in (first..self.contacts()).zip(found) {
            *found = self.touch_across(&lying, &plane, at, number, placed);
        }
    }

    fn touch_across(
        &self,
        lying: &Lying,
        plane: &Moving,
        at: OnCylinder,
        number: usize,
        placed: [&Placed; 2],
    ) -> Touch {
        // The plane's normal is out of the solid that it bounds.
        let (point, is_towards_first) = match at.plane.corner() {
            Some(corner) => {
                let is_there = number < self.share();
                let point = is_there.then(|| lying.corner(corner, plane));
                (point, !self.is_first)
            }
            None => (lying.point_of_rim(number, at.rims, plane), self.is_first),
        };
        let towards_first = if is_towards_first { 1.0 } else { -1.0 };
        let (normal, normal_rate) = (plane.normal, plane.normal_rate);
        let found = point.unwrap_or(Point {
            place: lying.tube.placed.position,
            velocity: lying.tube.placed.velocity,
            depth: f64::NEG_INFINITY,
            depth_rate: 0.0,
        });
        let depth = found.depth.max(-self.radius - self.half_length);
        let mut touch = Touch::across(
            found.depth,
            normal * towards_first,
            normal_rate * towards_first,
            found.place + normal * (0.5 * depth),
            found.velocity + (normal_rate * depth + normal * found.depth_rate) * 0.5,
            placed,
        );
        touch.growth = found.depth_rate;
        touch
    }
}

/// A cylinder and a solid as they lie in the world.
pub(super) struct Lying<'a> {
    pub cylinder: &'a Cylinder,
    pub tube: Tube<'a>,
    pub flat: &'a Placed,
    /// The other solid, if that is a cylinder.
    pub other: Option<Tube<'a>>,
    /// Of the other solid.
    pub corners: Vec<Vec3>,
}

impl<'a> Lying<'a> {
    fn new(cylinder: &'a Cylinder, placed: [&'a Placed; 2]) -> Self {
        let [round, flat] = if cylinder.is_first {
            placed
        } else {
            [placed[1], placed[0]]
        };
        Self {
            tube: Tube::new([cylinder.radius, cylinder.half_length], round),
            other: cylinder.other.map(|of| Tube::new(of, flat)),
            cylinder,
            flat,
            corners: cylinder
                .flat
                .corners
                .iter()
                .map(|corner| flat.position + flat.rotation.out(*corner))
                .collect(),
        }
    }

    fn moving(&self, plane: Plane) -> Moving {
        match plane {
            Plane::Face(face) => {
                let (own, offset) = self.cylinder.flat.faces[usize::from(face)];
                let normal = self.flat.rotation.out(own);
                let on = self.flat.position + normal * offset;
                Moving {
                    normal,
                    normal_rate: self.flat.turning.cross(normal),
                    on,
                    on_velocity: self.flat.velocity_at(on),
                }
            }
            Plane::End(end, _) => {
                let normal = self.tube.axis * side_of(usize::from(end));
                let on = self.tube.centre(usize::from(end));
                Moving {
                    normal,
                    normal_rate: self.tube.placed.turning.cross(normal),
                    on,
                    on_velocity: self.tube.placed.velocity_at(on),
                }
            }
            Plane::Side(corner) => {
                let (round, place) = (self.tube.placed, self.corners[usize::from(corner)]);
                let off = place - round.position;
                let off_rate = self.flat.velocity_at(place) - round.velocity;
                let (a, a_rate) = (self.tube.axis, self.tube.axis_rate);
                let out = off.across(a);
                let normal = out.direction().unwrap_or(Vec3::ZERO);
                let out_rate =
                    off_rate - a_rate * a.dot(off) - a * (a_rate.dot(off) + a.dot(off_rate));
                let normal_rate =
                    out_rate.across(normal) * (1.0 / out.norm().max(f64::MIN_POSITIVE));
                Moving {
                    normal,
                    normal_rate,
                    on: round.position + normal * self.cylinder.radius,
                    on_velocity: round.velocity + normal_rate * self.cylinder.radius,
                }
            }
            Plane::Edge(edge, name) => self.of_family(Family::Edge(edge), name),
            Plane::SideAtRim(rim, name) => self.of_family(Family::SideAtRim(rim), name),
            Plane::Around(name) => self.of_family(Family::Around, name),
            Plane::Rims(crossing, name) => self.between_rims(crossing, name),
        }
    }

    /// The plane of least overlap of a family.
    fn of_family(&self, family: Family, name: u8) -> Moving {
        let turn = self.turn(family);
        let angle = self.least_about(family, &turn, name);
        let angle = angle.unwrap_or_else(|| turn.angle(name));
        let (normal, onward) = turn.at(angle);
        let rate = self.bend(family, &turn, angle).turning();
        let normal_rate = turn.turning.cross(normal) + onward * rate;
        let Through {
            on,
            on_velocity,
            lift,
        } = self.through(family);
        Moving {
            normal,
            normal_rate,
            on: on + normal * lift,
            on_velocity: on_velocity + normal_rate * lift,
        }
    }

    /// The plane of least overlap, which is another one than `now` where that is less by a margin; of two that are
    /// apart, any plane between them.
    fn least(&self, now: Option<Plane>, slack: f64) -> Plane {
        let (mut plane, mut least) =
            now.map_or((Plane::Face(0), f64::INFINITY), |now| self.overlap(now));
        if now.is_some() && least <= slack {
            return plane;
        }
        let mut look = |other: Plane, overlap: f64| {
            let margin = if least.is_finite() {
                MARGIN * least.abs()
            } else {
                0.0
            };
            if overlap < least - margin.max(slack) {
                (plane, least) = (other, overlap);
            }
        };
        let solid = &self.cylinder.flat;
        let overlaps = |planes: Vec<Plane>| -> Vec<(Plane, f64)> {
            planes
                .into_iter()
                .map(|plane| self.overlap(plane))
                .collect()
        };
        let faces = (0..solid.faces.len()).map(|face| Plane::Face(number(face)));
        let faces = overlaps(faces.collect());
        let corners = || (0..solid.corners.len()).map(number);
        let ends = [Plane::End(0, 0), Plane::End(1, 0)].into_iter();
        let ends = ends.filter(|_| self.count() > 0);
        let corners = overlaps(ends.chain(corners().map(Plane::Side)).collect());
        let all = faces.iter().chain(&corners);
        let so_far = all.fold(f64::INFINITY, |least, (_, overlap)| least.min(*overlap));
        // Ties go to a plane that has the rims of the cylinder behind it.
        for (face, overlap) in faces {
            look(face, overlap);
        }
        // For separated solids any plane between them is valid.
        if so_far > 0.0 {
            for edge in (0..solid.edges.len()).map(number) {
                if self.least_that_can_be(edge) > so_far {
                    continue;
                }
                for (name, overlap) in self.overlaps_of(Family::Edge(edge)) {
                    look(Plane::Edge(edge, name), overlap);
                }
            }
            if self.other.is_some() {
                for (name, overlap) in self.overlaps_of(Family::Around) {
                    look(Plane::Around(name), overlap);
                }
            }
        }
        for (plane, overlap) in corners {
            look(plane, overlap);
        }
        if so_far > 0.0 && self.other.is_some() {
            for rim in [0, 1] {
                for (name, overlap) in self.overlaps_of(Family::SideAtRim(rim)) {
                    look(Plane::SideAtRim(rim, name), overlap);
                }
            }
            for (crossing, name, overlap) in self.crossings() {
                look(Plane::Rims(crossing, name), overlap);
            }
        }
        plane
    }

    /// Returns the plane with its present name, and its overlap.
    fn overlap(&self, plane: Plane) -> (Plane, f64) {
        let share = self.cylinder.share() as f64;
        match plane {
            Plane::Face(_) => {
                let at = self.moving(plane);
                let behind = [0, 1].map(|rim| self.tube.behind(rim, &at));
                let deepest = behind[0].deepest().max(behind[1].deepest());
                if deepest <= 0.0 {
                    return (plane, deepest);
                }
                let squares: f64 = behind
                    .iter()
                    .map(|of| of.squares(&self.cylinder.cosines))
                    .sum();
                (plane, (squares / share).sqrt())
            }
            Plane::End(end, corner) => {
                let at = self.moving(plane);
                let (deepest, depth) = self.deepest(&at, usize::from(corner));
                (Plane::End(end, number(deepest)), depth)
            }
            Plane::Side(corner) => {
                let at = self.moving(plane);
                let (deepest, depth) = self.deepest(&at, usize::from(corner));
                // If another corner is deeper, the plane is not a local minimum of the overlap.
                let is_least = deepest == usize::from(corner);
                (plane, if is_least { depth } else { f64::INFINITY })
            }
            Plane::Edge(edge, name) => {
                let (overlap, name) = self.overlap_about(Family::Edge(edge), name);
                (Plane::Edge(edge, name), overlap)
            }
            Plane::SideAtRim(rim, name) => {
                let (overlap, name) = self.overlap_about(Family::SideAtRim(rim), name);
                (Plane::SideAtRim(rim, name), overlap)
            }
            Plane::Around(name) => {
                let (overlap, name) = self.overlap_about(Family::Around, name);
                (Plane::Around(name), overlap)
            }
            Plane::Rims(crossing, name) => {
                let (overlap, name) = self.overlap_of_rims(crossing, name);
                (Plane::Rims(crossing, name), overlap)
            }
        }
    }

    /// Steps from the cylinder's x axis to the deepest place of its rims.
    fn steps(&self, normal: Vec3) -> f64 {
        let [x, y, _] = self.tube.placed.rotation.back(-normal).0;
        let steps = self.cylinder.share() as f64 / TAU;
        (y.atan2(x) * steps).round()
    }

    fn rims(&self, plane: Plane, now: Option<[Rim; 2]>, slack: f64) -> [Rim; 2] {
        if plane.corner().is_some() {
            return [Rim::Turned(0); 2];
        }
        let plane = self.moving(plane);
        let behind = [0, 1].map(|rim| self.tube.behind(rim, &plane));
        let Some(now) = now else {
            return behind.map(|of| {
                if of.depth >= of.more {
                    Rim::Held(0)
                } else {
                    Rim::Turned(0)
                }
            });
        };
        let count = self.cylinder.share() as f64;
        let steps = || self.steps(plane.normal);
        let moved = |back: u8, by: f64| small((f64::from(back) + by).rem_euclid(count));
        [0, 1].map(|rim| {
            let Behind { depth, more } = behind[rim];
            match now[rim] {
                Rim::Held(back) if depth < more - slack => Rim::Turned(moved(back, steps())),
                Rim::Turned(back) if depth > more + slack => Rim::Held(moved(back, -steps())),
                as_it_is => as_it_is,
            }
        })
    }

    /// Returns the number of corners, or rims, that can lie behind a plane of the cylinder.
    fn count(&self) -> usize {
        match self.other {
            Some(_) => 2,
            None => self.corners.len(),
        }
    }

    /// A corner behind a plane, or the deepest place of a rim.
    fn corner(&self, corner: usize, plane: &Moving) -> Point {
        if let Some(other) = &self.other {
            return other.turned(corner, plane, (0.0, 1.0));
        }
        let place = self.corners[corner];
        plane.point(place, self.flat.velocity_at(place))
    }

    /// The deepest corner behind a plane, which is another one than `now` where that is deeper by a margin; and how
    /// deep.
    fn deepest(&self, plane: &Moving, now: usize) -> (usize, f64) {
        let depth = |corner: usize| match &self.other {
            Some(other) => other.behind(corner, plane).deepest(),
            None => plane.depth(self.corners[corner]),
        };
        let here = depth(now);
        let margin = MARGIN * here.abs() + ALIKE;
        let depths = (0..self.count()).map(|corner| (corner, depth(corner)));
        let deeper = depths.filter(|(_, depth)| *depth > here + margin);
        deeper
            .max_by(|(_, one), (_, other)| one.total_cmp(other))
            .unwrap_or((now, here))
    }

    fn point_of_rim(&self, number: usize, rims: [Rim; 2], plane: &Moving) -> Option<Point> {
        let share = self.cylinder.share();
        let rim = number / share;
        let (Rim::Held(back) | Rim::Turned(back)) = *rims.get(rim)?;
        let steps = (number % share + share - usize::from(back)) % share;
        let angle = (TAU * steps as f64 / share as f64).sin_cos();
        Some(if let Rim::Held(_) = rims[rim] {
            self.tube.held(rim, plane, angle)
        } else {
            self.tube.turned(rim, plane, angle)
        })
    }
}

/// A small whole number that stands as a float.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "from 0 to the number of points or parts"
)]
pub(super) fn small(number: f64) -> u8 {
    number as u8
}
