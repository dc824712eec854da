//! Joints: bodies that springs hold together, in all directions but one.

use super::contact::Placed;
use super::scene::{InvalidScene, Vector, above_zero, all_finite, not_negative, unit_length};
use super::vector::{Rotation, Vec3};
use crate::InvalidParameter;

/// Degree of freedom that a joint leaves to its body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Freedom {
    /// Turn about the axis.
    Turn,
    /// Slide along the axis.
    Slide,
}

/// Joint of a body, described in the state at t = 0.
///
/// Its coordinate q is the angle `[rad]` about the axis, or the displacement `[m]` along it, of the body relative to
/// the other one; q = 0 at t = 0. A revolute joint holds two points of the axis, half a span on both sides of the
/// joint's point, by a spring K/2 each. A prismatic joint holds four points, at the same distance along the axis and
/// across it, by K/4 each against motion across the axis. The transverse direction is the initial axis of the body that
/// is closest to perpendicular to the joint axis, projected onto the normal plane; ties go to the lower index.
#[derive(Debug, Clone, PartialEq)]
pub struct WorldJoint {
    /// Number of the body.
    pub body: usize,
    /// Number of the other body; `None` for the world.
    pub against: Option<usize>,
    /// Degree of freedom of the body.
    pub freedom: Freedom,
    /// Its middle, in world axes `[m]`.
    pub point: Vector,
    /// Unit vector along the axis, in world axes.
    pub axis: Vector,
    /// K, above 0 `[N/m]`.
    pub stiffness: f64,
    /// Damping parallel to K, distributed over the points in the same way, at least 0 `[N s/m]`.
    pub damping: f64,
    /// Length of the bearing, above 0 `[m]`.
    pub span: f64,
    /// Spring along q, `[N/m]` or `[N m/rad]`, at least 0.
    pub spring: f64,
    /// Rest value of the coordinate `[m]` or `[rad]`.
    pub rest: f64,
    /// Damping along q, `[N s/m]` or `[N m s/rad]`, at least 0.
    pub along_damping: f64,
    /// Beyond these, q is pushed back by K, or by K span²/4 where it is an angle.
    pub limits: Option<[f64; 2]>,
}

impl WorldJoint {
    pub(super) fn check(&self, name: &str, bodies: usize) -> Result<(), InvalidScene> {
        for number in [Some(self.body), self.against].into_iter().flatten() {
            InvalidParameter::unless(
                number < bodies && self.against != Some(self.body),
                format!("{name}.between"),
                number as f64,
                "the index of one body of the scene, from 0, or those of two different bodies",
            )?;
        }
        all_finite(&format!("{name}.point"), &self.point)?;
        unit_length(&format!("{name}.axis"), &self.axis)?;
        above_zero(&format!("{name}.stiffness"), &[self.stiffness])?;
        above_zero(&format!("{name}.span"), &[self.span])?;
        let rest = [self.damping, self.spring, self.along_damping];
        not_negative(&format!("{name}.damping and spring"), &rest)?;
        all_finite(&format!("{name}.rest"), &[self.rest])?;
        all_finite(
            &format!("{name}.limits"),
            self.limits.as_ref().map_or(&[], |limits| limits),
        )
    }
}

/// A joint made ready to be moved: places are in the axes of the members.
#[derive(Debug, Clone)]
pub(super) struct Bearing {
    joint: WorldJoint,
    members: [Option<usize>; 2],
    /// The joint's point, then the held points: each on the body and on its counterpart.
    points: Vec<[Vec3; 2]>,
    /// Axis and a direction across it, in the other's axes.
    axis: Vec3,
    across: Vec3,
    /// That direction in the body's axes.
    mark: Vec3,
}

/// State of a joint at an instant.
#[derive(Debug, Clone, Default)]
pub(super) struct Hold {
    /// Force and torque about the mass centre on each of the two.
    pub wrenches: Vec<(usize, Vec3, Vec3)>,
    /// `[J]`
    pub stored: f64,
    /// What damping takes `[W]`.
    pub power: f64,
}

fn still() -> Placed {
    Placed {
        position: Vec3::ZERO,
        rotation: Rotation::of_quaternion([1.0, 0.0, 0.0, 0.0]),
        velocity: Vec3::ZERO,
        turning: Vec3::ZERO,
    }
}

impl Bearing {
    pub fn new(joint: &WorldJoint, devices: usize, start: &[Placed]) -> Self {
        let members = [Some(joint.body), joint.against].map(|body| body.map(|body| devices + body));
        let [one, other] = members.map(|member| member.map_or(still(), |member| start[member]));
        let axis = Vec3(joint.axis);
        // The transverse direction follows the body axis that is closest to perpendicular to the joint axis; ties go to
        // the lower index. The tolerance keeps the choice independent of rounding if the whole scene is rotated.
        let own = one.rotation.back(axis).0.map(f64::abs);
        let is_least = |i: &usize| own.iter().all(|other| own[*i] <= other + 1e-6);
        let mut unit = Vec3::ZERO;
        unit.0[(0..3).find(is_least).unwrap_or(0)] = 1.0;
        let unit = one.rotation.out(unit);
        let across = unit.across(axis);
        let across = across.direction().unwrap_or(unit);
        let half = 0.5 * joint.span;
        let mut ways = vec![Vec3::ZERO, axis * half, axis * -half];
        if joint.freedom == Freedom::Slide {
            ways.extend([across * half, across * -half]);
        }
        let on = |placed: &Placed, way: Vec3| {
            placed
                .rotation
                .back(Vec3(joint.point) + way - placed.position)
        };
        Self {
            joint: joint.clone(),
            members,
            points: ways
                .into_iter()
                .map(|way| [on(&one, way), on(&other, way)])
                .collect(),
            axis: other.rotation.back(axis),
            across: other.rotation.back(across),
            mark: one.rotation.back(across),
        }
    }

    /// Force along q, without damping, and the energy stored.
    fn along(&self, q: f64) -> (f64, f64) {
        let joint = &self.joint;
        let stop = match joint.freedom {
            Freedom::Turn => joint.stiffness * (0.5 * joint.span).powi(2),
            Freedom::Slide => joint.stiffness,
        };
        let beyond = match joint.limits {
            Some([low, _]) if q < low => q - low,
            Some([_, high]) if q > high => q - high,
            _ => 0.0,
        };
        let stretched = q - joint.rest;
        (
            -joint.spring * stretched - stop * beyond,
            0.5 * joint.spring * stretched * stretched + 0.5 * stop * beyond * beyond,
        )
    }

    pub fn hold(&self, placed: &[Placed]) -> Hold {
        let [one, other] = self
            .members
            .map(|member| member.map_or(still(), |at| placed[at]));
        let axis = other.rotation.out(self.axis);
        let joint = &self.joint;
        let (mut stored, mut power) = (0.0, 0.0);
        let (mut force, mut about_one, mut about_other) = (Vec3::ZERO, Vec3::ZERO, Vec3::ZERO);
        let mut push = |place: Vec3, by: Vec3| {
            force += by;
            about_one += (place - one.position).cross(by);
            about_other += (place - other.position).cross(by);
        };
        let share = 1.0 / (self.points.len() - 1) as f64;
        for (number, [on_one, on_other]) in self.points.iter().enumerate() {
            let place = one.position + one.rotation.out(*on_one);
            let off = place - other.position - other.rotation.out(*on_other);
            // Both at the body's place: the other's frame turns with it.
            let speed = one.velocity_at(place) - other.velocity_at(place);
            if number == 0 {
                if joint.freedom == Freedom::Slide {
                    let (pull, energy) = self.along(axis.dot(off));
                    let rate = axis.dot(speed);
                    stored += energy;
                    power += joint.along_damping * rate * rate;
                    push(place, axis * (pull - joint.along_damping * rate));
                }
                continue;
            }
            let (held, rate) = match joint.freedom {
                Freedom::Turn => (off, speed),
                Freedom::Slide => (off.across(axis), speed.across(axis)),
            };
            stored += 0.5 * share * joint.stiffness * held.dot(held);
            power += share * joint.damping * rate.dot(rate);
            push(
                place,
                held * (-share * joint.stiffness) - rate * (share * joint.damping),
            );
        }
        if joint.freedom == Freedom::Turn {
            let across = other.rotation.out(self.across);
            let third = axis.cross(across);
            let mark = one.rotation.out(self.mark);
            let (x, y) = (mark.dot(across), mark.dot(third));
            // q = atan2(y, x); its rate is `by` · (ω₁ − ω₂).
            let by = mark.cross(third * x - across * y) * (1.0 / (x * x + y * y));
            let (pull, energy) = self.along(y.atan2(x));
            let rate = by.dot(one.turning - other.turning);
            stored += energy;
            power += joint.along_damping * rate * rate;
            let torque = by * (pull - joint.along_damping * rate);
            about_one += torque;
            about_other += torque;
        }
        let [of_one, of_other] = self.members;
        let wrenches = [
            of_one.map(|member| (member, force, about_one)),
            of_other.map(|member| (member, -force, -about_other)),
        ];
        Hold {
            wrenches: wrenches.into_iter().flatten().collect(),
            stored,
            power,
        }
    }
}
