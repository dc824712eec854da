//! A capsule on another convex solid: the position of its two ends behind the separating plane.
//!
//! Two forces with the shares cos θ and sin θ at the ends are equivalent to a single one at their balance point on the
//! segment. There a sphere overlaps the other solid by p, and the two ends can hold p (cos θ + sin θ) cos θ and p (cos
//! θ + sin θ) sin θ. The pair uses the θ with the largest p (cos θ + sin θ). This construction uses no plane; tests
//! show that the plane has the least overlap.

use std::f64::consts::FRAC_PI_2;

use super::contact::{Placed, Touch};
use super::ridders::falls_through_zero;
use super::scene::Shape;
use super::surface::{feature, nearest};
use super::vector::{Rotation, Vec3};
use super::wrapping::{Wrapped, normal_of};

/// Time difference for numerical derivatives `[s]`. Short, because it reaches back over the start of a contact.
const STEP: f64 = 5e-8;

/// The solid that a capsule is on.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Base {
    Round(Shape),
    Flat(Faces),
}

/// A convex solid by its faces: normal, how far along it, and the corners in their order.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Faces(Vec<(Vec3, f64, Vec<Vec3>)>);

/// A capsule and its counterpart.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Rod {
    /// Whether the capsule is the first of the two.
    pub is_first: bool,
    pub radius: f64,
    pub half_length: f64,
    pub base: Base,
}

/// Geometry of a capsule contact.
#[derive(Clone, Copy)]
struct Lying {
    /// Unit vector from the second member to the first.
    normal: Vec3,
    penetration: f64,
    point: Vec3,
}

impl Faces {
    pub fn of(wrapped: &Wrapped) -> Self {
        let faces = wrapped.faces.iter().map(|face| {
            let corners: Vec<Vec3> = face.iter().map(|&corner| wrapped.corners[corner]).collect();
            let normal = normal_of(&corners).unwrap_or(Vec3::ZERO);
            (normal, normal.dot(corners[0]), corners)
        });
        Self(faces.collect())
    }

    /// Distance of a point and the normal there; inside, of the face of least depth.
    pub fn nearest(&self, point: Vec3) -> (f64, Vec3) {
        let mut highest = (f64::NEG_INFINITY, Vec3::ZERO);
        let mut found: Option<Vec3> = None;
        let mut take = |off: Vec3| {
            if found.is_none_or(|other| off.norm() < other.norm()) {
                found = Some(off);
            }
        };
        for (normal, offset, corners) in &self.0 {
            let height = normal.dot(point) - offset;
            if height > highest.0 {
                highest = (height, *normal);
            }
            if height <= 0.0 {
                continue;
            }
            let sides =
                || (0..corners.len()).map(|i| (corners[i], corners[(i + 1) % corners.len()]));
            let is_over =
                |(from, to): (Vec3, Vec3)| normal.cross(to - from).dot(point - from) >= 0.0;
            if sides().all(is_over) {
                take(*normal * height);
                continue;
            }
            for (from, to) in sides() {
                let along = to - from;
                let share = along.dot(point - from) / along.dot(along);
                take(point - from - along * share.clamp(0.0, 1.0));
            }
        }
        match found.and_then(|off| Some((off.norm(), off.direction()?))) {
            Some(near) if highest.0 > 1e-12 => near,
            _ => highest,
        }
    }
}

impl Rod {
    fn lying(&self, placed: [&Placed; 2], end: usize) -> Lying {
        let [rod, base] = if self.is_first {
            placed
        } else {
            [placed[1], placed[0]]
        };
        let half = rod.rotation.out(Vec3([0.0, 0.0, self.half_length]));
        let ends = [rod.position - half, rod.position + half];
        let along = ends[1] - ends[0];
        let parts = |angle: f64| {
            let (sine, cosine) = angle.sin_cos();
            // At a quarter turn the cosine is round-off.
            (sine, if angle < FRAC_PI_2 { cosine } else { 0.0 })
        };
        let at = |angle: f64| {
            let (sine, cosine) = parts(angle);
            let sum = sine + cosine;
            let place = base
                .rotation
                .back(ends[0] + along * (sine / sum) - base.position);
            let (distance, out) = match &self.base {
                Base::Round(shape) => {
                    let near = nearest(shape, feature(shape, place), place);
                    (near.distance, near.normal)
                }
                Base::Flat(faces) => faces.nearest(place),
            };
            let (out, overlap) = (base.rotation.out(out), self.radius - distance);
            let grows = overlap.max(0.0) * (cosine - sine) - out.dot(along) / sum;
            (overlap, out, grows)
        };
        let angle = falls_through_zero(|angle| at(angle).2, 0.0, FRAC_PI_2);
        let (overlap, out, _) = at(angle);
        let (sine, cosine) = parts(angle);
        let sum = sine + cosine;
        let share = [cosine, sine][end];
        let penetration = if overlap > 0.0 && share > 0.0 {
            overlap * sum * share
        } else {
            // Depth of an end relative to the plane through the nearest point.
            overlap - out.dot(ends[end] - (ends[0] + along * (sine / sum)))
        };
        Lying {
            normal: if self.is_first { out } else { -out },
            penetration,
            point: ends[end] - out * (self.radius - 0.5 * penetration),
        }
    }

    /// Returns the touch at one of the two ends.
    pub fn touch(&self, end: usize, placed: [&Placed; 2]) -> Touch {
        let here = self.lying(placed, end);
        let after = |time: f64| {
            let [first, second] = placed.map(|placed| moved(placed, time));
            self.lying([&first, &second], end)
        };
        let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(|steps| after(steps * STEP));
        let rate = |of: fn(&Lying) -> Vec3| {
            ((of(&c) - of(&b)) * 8.0 - (of(&d) - of(&a))) * (1.0 / (12.0 * STEP))
        };
        let growth =
            |of: fn(&Lying) -> f64| ((of(&c) - of(&b)) * 8.0 - (of(&d) - of(&a))) / (12.0 * STEP);
        let mut touch = Touch::across(
            here.penetration,
            here.normal,
            rate(|lying| lying.normal),
            here.point,
            rate(|lying| lying.point),
            placed,
        );
        touch.growth = growth(|lying| lying.penetration);
        touch
    }
}

/// Returns the pose of a member after `time` at its present velocities.
fn moved(placed: &Placed, time: f64) -> Placed {
    let rate = placed.turning.norm();
    let rotation = placed.turning.direction().map_or(placed.rotation, |axis| {
        let (sine, cosine) = (0.5 * rate * time).sin_cos();
        let [x, y, z] = (axis * sine).0;
        let turn = Rotation::of_quaternion([cosine, x, y, z]);
        turn.after(&placed.rotation)
    });
    Placed {
        position: placed.position + placed.velocity * time,
        rotation,
        ..*placed
    }
}
