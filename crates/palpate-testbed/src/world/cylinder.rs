//! A cylinder on a solid with flat faces: which plane is between them, and the points by which they touch.
//!
//! Behind a plane that has the other solid on its far side lie the two rims of the cylinder. Each has m points that share the
//! law. Where a rim is behind the plane with all of itself, they stay where they are on it (*held*): the sum of their squared
//! depths is the same wherever they are. Where it is not, they turn with the deepest place of the rim (*turned*).

use std::f64::consts::TAU;

use super::between::Flat;
use super::contact::{Placed, Touch};
use super::vector::Vec3;

/// Points of a rim, at least.
const FEWEST: usize = 4;

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
        self.plane == other.plane
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
    /// How many points share the law.
    pub fn share(&self) -> usize {
        self.flat.most.max(FEWEST)
    }

    /// How many contacts there are.
    pub fn contacts(&self) -> usize {
        (2 * self.share()).max(self.flat.corners.len())
    }

    /// How the two should touch, if they touch as `now` tells.
    pub fn wanted(&self, now: Option<OnCylinder>, placed: [&Placed; 2], slack: f64) -> OnCylinder {
        let lying = Lying::new(self, placed);
        let plane = Plane::Face(0);
        let same = now.filter(|now| now.plane == plane);
        OnCylinder {
            plane,
            rims: lying.rims(plane, same.map(|now| now.rims), slack),
        }
    }

    /// How the two lie at one of the contacts.
    pub fn touch(&self, number: usize, at: OnCylinder, placed: [&Placed; 2]) -> Touch {
        let lying = Lying::new(self, placed);
        let plane = lying.moving(at.plane);
        let point = lying.point_of_rim(number, at.rims, &plane);
        // The plane's normal is out of the solid that it bounds.
        let towards_first = if self.is_first { 1.0 } else { -1.0 };
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
struct Lying<'a> {
    cylinder: &'a Cylinder,
    round: &'a Placed,
    flat: &'a Placed,
    /// Along the cylinder, and how that turns.
    axis: Vec3,
    axis_rate: Vec3,
}

/// How a rim lies behind a plane.
struct Behind {
    /// Of its centre, and by how much more its deepest place is deep.
    depth: f64,
    more: f64,
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
        }
    }

    fn centre(&self, rim: usize) -> Vec3 {
        let side = if rim == 0 { -1.0 } else { 1.0 };
        self.round.position + self.axis * (side * self.cylinder.half_length)
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

/// A small whole number that stands as a float.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn small(number: f64) -> u8 {
    number as u8
}
