//! A cylinder on a solid with flat faces: which plane is between them, and the points by which they touch.
//!
//! Behind a plane that has the other solid on its far side lie the two rims of the cylinder. Each has m points that share the
//! law. Behind a plane that has the cylinder on its far side lie corners of the other solid. The deepest has the whole law: with
//! springs at all of them, the corners of a large table would pull a can that stands off its middle to one side. The two touch
//! across the plane of least overlap, as two solids with flat faces do.
//!
//! Where a rim is behind the plane with all of itself, they stay where they are on it (*held*): the sum of their squared
//! depths is the same wherever they are. Where it is not, they turn with the deepest place of the rim (*turned*).

use std::f64::consts::TAU;

use super::between::{Flat, MARGIN, number};
use super::contact::{Placed, Touch};
use super::vector::Vec3;

/// Points of a rim, at least.
const FEWEST: usize = 4;
/// Corners of which the depths differ by no more than this are equally deep `[m]`.
const ALIKE: f64 = 1e-14;
/// By how many parts of a family a plane's name may change at once.
const NEAR: u8 = 4;

/// Where the points of a rim are, but for a number of steps from point to point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Rim {
    /// So many steps back from the cylinder's x axis.
    Held(u8),
    /// So many steps back from the deepest place.
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
    /// One through an edge of the solid, by that edge's number and its own name.
    Edge(u8, u8),
}

impl Plane {
    /// The corner behind it, if it has the cylinder on its far side.
    fn corner(self) -> Option<usize> {
        match self {
            Self::End(_, corner) | Self::Side(corner) => Some(usize::from(corner)),
            Self::Face(_) | Self::Edge(..) => None,
        }
    }

    /// Whether it is another one only by a name that has changed.
    fn is_same(self, other: Self) -> bool {
        match (self, other) {
            (Self::Edge(edge, name), Self::Edge(of, other)) => {
                edge == of && name.abs_diff(other) <= NEAR
            }
            (one, other) => one == other,
        }
    }
}

/// How a cylinder and a solid touch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct OnCylinder {
    pub plane: Plane,
    pub rims: [Rim; 2],
}

impl OnCylinder {
    /// Whether each contact keeps its point, if the two come from another way to touch.
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
    /// Of the angles from one point of a rim to each.
    pub cosines: Vec<f64>,
}

/// A plane that moves.
#[derive(Debug, Clone, Copy)]
struct Moving {
    normal: Vec3,
    normal_rate: Vec3,
    /// A place in it, and the velocity of that place.
    on: Vec3,
    on_velocity: Vec3,
}

impl Moving {
    fn depth(&self, place: Vec3) -> f64 {
        self.normal.dot(self.on - place)
    }

    fn depth_rate(&self, place: Vec3, velocity: Vec3) -> f64 {
        self.normal_rate.dot(self.on - place) + self.normal.dot(self.on_velocity - velocity)
    }
}

/// A point of the two: where it is, how that moves, and how deep it lies.
struct Point {
    place: Vec3,
    velocity: Vec3,
    depth: f64,
    depth_rate: f64,
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
            cosines: angles.map(f64::cos).collect(),
        }
    }

    /// How many points share the law.
    pub fn share(&self) -> usize {
        self.cosines.len()
    }

    /// How many contacts there are.
    pub fn contacts(&self) -> usize {
        (2 * self.share()).max(self.flat.corners.len())
    }

    /// How the two should touch, if they touch as `now` tells.
    pub fn wanted(&self, now: Option<OnCylinder>, placed: [&Placed; 2], slack: f64) -> OnCylinder {
        let lying = Lying::new(self, placed);
        let plane = lying.least(now.map(|now| now.plane), slack);
        let same = now.filter(|now| now.plane.is_same(plane));
        OnCylinder {
            plane,
            rims: lying.rims(plane, same.map(|now| now.rims), slack),
        }
    }

    /// How the two lie at the contacts from `first` on, as many as there are places for.
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
            place: lying.round.position,
            velocity: lying.round.velocity,
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
    pub round: &'a Placed,
    pub flat: &'a Placed,
    /// Along the cylinder, and how that turns.
    pub axis: Vec3,
    pub axis_rate: Vec3,
    /// Of the other solid.
    pub corners: Vec<Vec3>,
}

/// How a rim lies behind a plane.
struct Behind {
    /// Of its centre, and by how much more its deepest place is deep.
    depth: f64,
    more: f64,
}

impl Behind {
    /// The squared depths of the points of the rim that are behind the plane, one of them at the deepest place.
    fn squares(&self, cosines: &[f64]) -> f64 {
        if self.depth >= self.more {
            return cosines.len() as f64 * (self.depth * self.depth + 0.5 * self.more * self.more);
        }
        let depths = cosines.iter().map(|cosine| self.depth + self.more * cosine);
        depths.map(|depth| depth.max(0.0).powi(2)).sum()
    }
}

impl<'a> Lying<'a> {
    fn new(cylinder: &'a Cylinder, placed: [&'a Placed; 2]) -> Self {
        let [round, flat] = if cylinder.is_first {
            placed
        } else {
            [placed[1], placed[0]]
        };
        let axis = round.rotation.out(Vec3([0.0, 0.0, 1.0]));
        Self {
            cylinder,
            round,
            flat,
            axis,
            axis_rate: round.turning.cross(axis),
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
                let normal = self.axis * side_of(usize::from(end));
                let on = self.centre(usize::from(end));
                Moving {
                    normal,
                    normal_rate: self.round.turning.cross(normal),
                    on,
                    on_velocity: self.round.velocity_at(on),
                }
            }
            Plane::Side(corner) => {
                let off = self.corners[usize::from(corner)] - self.round.position;
                let velocity = self.flat.velocity_at(self.corners[usize::from(corner)]);
                let off_rate = velocity - self.round.velocity;
                let (a, a_rate) = (self.axis, self.axis_rate);
                let out = off.across(a);
                let normal = out.direction().unwrap_or(Vec3::ZERO);
                let out_rate =
                    off_rate - a_rate * a.dot(off) - a * (a_rate.dot(off) + a.dot(off_rate));
                let normal_rate =
                    out_rate.across(normal) * (1.0 / out.norm().max(f64::MIN_POSITIVE));
                Moving {
                    normal,
                    normal_rate,
                    on: self.round.position + normal * self.cylinder.radius,
                    on_velocity: self.round.velocity + normal_rate * self.cylinder.radius,
                }
            }
            Plane::Edge(edge, name) => {
                let (normal, normal_rate) = self.normal(edge, name);
                let on = self.on_edge(edge);
                Moving {
                    normal,
                    normal_rate,
                    on,
                    on_velocity: self.flat.velocity_at(on),
                }
            }
        }
    }

    /// The normal of least overlap about an edge, and how that turns.
    fn normal(&self, edge: u8, name: u8) -> (Vec3, Vec3) {
        let turn = self.turn(edge);
        let angle = self.least_about(edge, &turn, name);
        let angle = angle.unwrap_or_else(|| turn.angle(name));
        let (normal, onward) = turn.at(angle);
        let rate = self.bend(edge, &turn, angle).turning();
        (normal, turn.turning.cross(normal) + onward * rate)
    }

    /// The plane of least overlap, which is another one than `now` where that is less by a margin; of two that are apart, any
    /// plane between them.
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
        let ends = corners()
            .take(1)
            .flat_map(|at| [Plane::End(0, at), Plane::End(1, at)]);
        let corners = overlaps(ends.chain(corners().map(Plane::Side)).collect());
        let all = faces.iter().chain(&corners);
        let so_far = all.fold(f64::INFINITY, |least, (_, overlap)| least.min(*overlap));
        // Of equals, one that the cylinder has its rims behind comes first.
        for (face, overlap) in faces {
            look(face, overlap);
        }
        // Of two that are apart, any plane between them will do.
        if so_far > 0.0 {
            for edge in (0..solid.edges.len()).map(number) {
                if self.least_that_can_be(edge) > so_far {
                    continue;
                }
                for (name, overlap) in self.overlaps_of(edge) {
                    look(Plane::Edge(edge, name), overlap);
                }
            }
        }
        for (plane, overlap) in corners {
            look(plane, overlap);
        }
        plane
    }

    /// The overlap of a plane, and what the plane is called now.
    fn overlap(&self, plane: Plane) -> (Plane, f64) {
        let share = self.cylinder.share() as f64;
        match plane {
            Plane::Face(_) => {
                let at = self.moving(plane);
                let behind = [0, 1].map(|rim| self.behind(rim, &at));
                let [one, other] = behind.each_ref().map(|of| of.depth + of.more);
                let deepest = one.max(other);
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
                let (deepest, depth) = deepest(&at, &self.corners, usize::from(corner));
                (Plane::End(end, number(deepest)), depth)
            }
            Plane::Side(corner) => {
                let at = self.moving(plane);
                let (deepest, depth) = deepest(&at, &self.corners, usize::from(corner));
                // Where another one is deeper, the plane has not the least overlap of those about it.
                let is_least = deepest == usize::from(corner);
                (plane, if is_least { depth } else { f64::INFINITY })
            }
            Plane::Edge(edge, name) => {
                let (overlap, name) = self.overlap_about(edge, name);
                (Plane::Edge(edge, name), overlap)
            }
        }
    }

    pub fn centre(&self, rim: usize) -> Vec3 {
        self.round.position + self.axis * (side_of(rim) * self.cylinder.half_length)
    }

    fn behind(&self, rim: usize, plane: &Moving) -> Behind {
        Behind {
            depth: plane.depth(self.centre(rim)),
            more: self.cylinder.radius * plane.normal.across(self.axis).norm(),
        }
    }

    /// Steps from the cylinder's x axis to the deepest place of its rims.
    fn steps(&self, normal: Vec3) -> f64 {
        let [x, y, _] = self.round.rotation.back(-normal).0;
        let steps = self.cylinder.share() as f64 / TAU;
        (y.atan2(x) * steps).round()
    }

    fn rims(&self, plane: Plane, now: Option<[Rim; 2]>, slack: f64) -> [Rim; 2] {
        if plane.corner().is_some() {
            return [Rim::Turned(0); 2];
        }
        let plane = self.moving(plane);
        let behind = [0, 1].map(|rim| self.behind(rim, &plane));
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

    fn corner(&self, corner: usize, plane: &Moving) -> Point {
        let place = self.corners[corner];
        let velocity = self.flat.velocity_at(place);
        Point {
            place,
            velocity,
            depth: plane.depth(place),
            depth_rate: plane.depth_rate(place, velocity),
        }
    }

    fn point_of_rim(&self, number: usize, rims: [Rim; 2], plane: &Moving) -> Option<Point> {
        let (share, radius) = (self.cylinder.share(), self.cylinder.radius);
        let rim = number / share;
        let centre = self.centre(rim);
        let (Rim::Held(back) | Rim::Turned(back)) = *rims.get(rim)?;
        let steps = (number % share + share - usize::from(back)) % share;
        let (sine, cosine) = (TAU * steps as f64 / share as f64).sin_cos();
        if let Rim::Held(_) = rims[rim] {
            let out = self.round.rotation.out(Vec3([cosine, sine, 0.0]));
            let place = centre + out * radius;
            let velocity = self.round.velocity_at(place);
            return Some(Point {
                place,
                velocity,
                depth: plane.depth(place),
                depth_rate: plane.depth_rate(place, velocity),
            });
        }
        let (a, a_rate) = (self.axis, self.axis_rate);
        let (along, along_rate) = (
            plane.normal.dot(a),
            plane.normal_rate.dot(a) + plane.normal.dot(a_rate),
        );
        // Part of the normal across the axis; the deepest place is on the other side.
        let across = plane.normal.across(a);
        let size = across.norm();
        let up = across.direction().unwrap_or(Vec3::ZERO);
        let across_rate = plane.normal_rate - a * along_rate - a_rate * along;
        let up_rate = if size > 0.0 {
            across_rate.across(up) * (1.0 / size)
        } else {
            Vec3::ZERO
        };
        let side = a.cross(up);
        let side_rate = a_rate.cross(up) + a.cross(up_rate);
        let (out, out_rate) = (
            (up * cosine + side * sine) * -1.0,
            (up_rate * cosine + side_rate * sine) * -1.0,
        );
        let centre_velocity = self.round.velocity_at(centre);
        Some(Point {
            place: centre + out * radius,
            velocity: centre_velocity + out_rate * radius,
            depth: plane.depth(centre) + radius * size * cosine,
            depth_rate: plane.depth_rate(centre, centre_velocity)
                + radius * up.dot(across_rate) * cosine,
        })
    }
}

/// The deepest of some places behind a plane, which is another one than `now` where that is deeper by a margin; and how deep.
fn deepest(plane: &Moving, places: &[Vec3], now: usize) -> (usize, f64) {
    let depths = places.iter().map(|place| plane.depth(*place)).enumerate();
    let here = plane.depth(places[now]);
    let margin = MARGIN * here.abs() + ALIKE;
    let deeper = depths.filter(|(_, depth)| *depth > here + margin);
    deeper
        .max_by(|(_, one), (_, other)| one.total_cmp(other))
        .unwrap_or((now, here))
}

/// On which side of the centre a rim is.
fn side_of(rim: usize) -> f64 {
    if rim == 0 { -1.0 } else { 1.0 }
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
