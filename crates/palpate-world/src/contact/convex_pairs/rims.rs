//! A cylinder at its current pose, and the depths of its rims behind a plane.
//!
//! The m points of each rim share the law evenly. Behind a plane the rim's centre is at a depth c, and its points are
//! at depths c + s cos(2 pi k/m), k from 0 to m - 1. Here s is the radius times the sine of the tilt; point 0 is the
//! rim's deepest point. If the whole rim is behind the plane, c >= s, the sum of the squared depths is m (c^2 +
//! s^2/2) for any rotation of the points about the axis. The points are then fixed to the body like the corners of a
//! box, so friction resists a twist of a standing cylinder. Otherwise the points rotate with the deepest point, so a
//! cylinder rolls smoothly.

use std::f64::consts::TAU;

use super::Bound;
use crate::geometry::rigid::{Rigid, Vector3};

/// Rotation of a rim's points about the axis.
#[derive(Clone, Copy, Debug)]
struct Turn {
    /// Whether the points are fixed to the body: the first point is `steps` steps before the body's x axis. Otherwise
    /// it is `steps` steps before the deepest point.
    is_held: bool,
    /// A whole number.
    steps: f64,
}

/// A cylinder in the world's axes.
#[derive(Clone, Debug)]
pub(super) struct Cylinder {
    pub radius: f64,
    pub half_length: f64,
    pub centre: Vector3,
    /// Its x, y and z axis; z is the cylinder's axis.
    pub axes: [Vector3; 3],
    /// Cosines of the angles of a rim's points from its deepest point. Their number is the number of points that
    /// share the law.
    cosines: Vec<f64>,
    /// Largest distance of its surface from its centre `[m]`.
    reach: f64,
    turns: [Turn; 2],
}

impl Cylinder {
    /// Creates a cylinder with `share` points per rim.
    pub fn new(radius: f64, half_length: f64, share: usize) -> Self {
        let step = TAU / share as f64;
        Self {
            radius,
            half_length,
            centre: Vector3::zeros(),
            axes: [Vector3::x(), Vector3::y(), Vector3::z()],
            reach: radius.hypot(half_length),
            cosines: (0..share).map(|k| (step * k as f64).cos()).collect(),
            turns: [Turn {
                is_held: true,
                steps: 0.0,
            }; 2],
        }
    }

    pub fn reach(&self) -> f64 {
        self.reach
    }

    pub fn place(&mut self, rigid: &Rigid) {
        let turned = rigid.orientation.to_rotation_matrix();
        self.centre = rigid.position;
        self.axes = [0, 1, 2].map(|axis| turned.matrix().column(axis).into_owned());
    }

    pub fn copy_from(&mut self, other: &Self) {
        self.turns = other.turns;
    }

    /// Returns the half-space bounded by a cap.
    pub fn cap(&self, number: usize) -> Bound {
        let normal = self.axes[2] * end(number);
        Bound {
            normal,
            offset: normal.dot(&self.centre) + self.half_length,
        }
    }

    /// Returns the half-space tangent to the side, and its derivative with respect to the angle about the axis.
    pub fn tangent(&self, angle: f64) -> [Bound; 2] {
        self.tangent_at(angle.sin_cos())
    }

    /// Returns the same for the sine and the cosine of the angle.
    pub fn tangent_at(&self, (sine, cosine): (f64, f64)) -> [Bound; 2] {
        let [x, y, _] = self.axes;
        let normal = x * cosine + y * sine;
        let rate = y * cosine - x * sine;
        [
            Bound {
                normal,
                offset: normal.dot(&self.centre) + self.radius,
            },
            Bound {
                normal: rate,
                offset: rate.dot(&self.centre),
            },
        ]
    }

    /// Returns the depths of the rim centres behind a plane, and s.
    fn depths(&self, bound: &Bound) -> ([f64; 2], f64) {
        let [x, y, z] = self.axes;
        let middle = bound.depth(&self.centre);
        let along = self.half_length * bound.normal.dot(&z);
        let s = self.radius * bound.normal.dot(&x).hypot(bound.normal.dot(&y));
        ([middle + along, middle - along], s)
    }

    /// Returns the depth of the deepest point of both rims `[m]`, and the sum of the squares of all positive depths
    /// `[m^2]`.
    pub fn behind(&self, bound: &Bound) -> (f64, f64) {
        let (centres, s) = self.depths(bound);
        let mut squares = 0.0;
        for c in centres {
            if c >= s {
                squares += self.cosines.len() as f64 * (c * c + 0.5 * s * s);
            } else if c > -s {
                for cosine in &self.cosines {
                    squares += (c + s * cosine).max(0.0).powi(2);
                }
            }
        }
        (centres[0].max(centres[1]) + s, squares)
    }

    /// Returns the derivative of half that sum, or of the deepest point's depth if no depth is positive. `rate`:
    /// derivative of the plane.
    pub fn slope(&self, bound: &Bound, rate: &Bound) -> f64 {
        let (centres, s) = self.depths(bound);
        let axis = self.axes[2];
        let middle = rate.depth(&self.centre);
        let along = self.half_length * rate.normal.dot(&axis);
        let rates = [middle + along, middle - along];
        // s^2 = r^2 (1 - (n a)^2) for a normal n of constant unit length.
        let product = -self.radius.powi(2) * bound.normal.dot(&axis) * rate.normal.dot(&axis);
        let s_rate = if s > 0.0 { product / s } else { 0.0 };
        if centres[0].max(centres[1]) + s <= 0.0 {
            let deeper = usize::from(centres[1] > centres[0]);
            return rates[deeper] + s_rate;
        }
        let mut slope = 0.0;
        for (c, c_rate) in centres.into_iter().zip(rates) {
            if c >= s {
                slope += self.cosines.len() as f64 * (c * c_rate + 0.5 * product);
            } else if c > -s {
                for cosine in &self.cosines {
                    slope += (c + s * cosine).max(0.0) * (c_rate + s_rate * cosine);
                }
            }
        }
        slope
    }

    /// Returns the position that is deepest behind a plane.
    pub fn deepest(&self, bound: &Bound) -> Vector3 {
        let axis = self.axes[2];
        let along = bound.normal.dot(&axis);
        let across = bound.normal - axis * along;
        let on_rim = across.try_normalize(0.0).unwrap_or(self.axes[0]);
        self.centre - axis * self.half_length.copysign(along) - on_rim * self.radius
    }

    /// Returns the current rotation of the rims' points behind a plane, and the angle of the first point of each.
    fn turned(&self, bound: &Bound) -> [(Turn, f64); 2] {
        let (centres, s) = self.depths(bound);
        let share = self.cosines.len();
        let step = TAU / share as f64;
        let [x, y, _] = self.axes;
        let deepest = (-bound.normal.dot(&y)).atan2(-bound.normal.dot(&x));
        let way = (deepest / step).round();
        [0, 1].map(|rim| {
            let before = self.turns[rim];
            let is_held = centres[rim] >= s;
            // At a switch of the mode each point moves by at most half a step.
            let steps = match (before.is_held, is_held) {
                (true, false) => before.steps + way,
                (false, true) => before.steps - way,
                _ => before.steps,
            };
            let steps = steps.rem_euclid(share as f64);
            let from = if is_held { 0.0 } else { deepest };
            (Turn { is_held, steps }, from - step * steps)
        })
    }

    /// Updates the rotation of the rims' points for a plane.
    pub fn turn(&mut self, bound: &Bound) {
        self.turns = self.turned(bound).map(|(turn, _)| turn);
    }

    /// Returns all points of the rims, for the rotation behind a plane.
    pub fn places(&self, bound: &Bound) -> impl Iterator<Item = Vector3> {
        let share = self.cosines.len();
        let step = TAU / share as f64;
        let [x, y, z] = self.axes;
        let turned = self.turned(bound);
        (0..2 * share).map(move |number| {
            let (rim, point) = (number / share, number % share);
            let (sine, cosine) = (turned[rim].1 + step * point as f64).sin_cos();
            self.centre + z * (end(rim) * self.half_length) + (x * cosine + y * sine) * self.radius
        })
    }
}

/// Returns the sign of a rim or cap along the axis.
fn end(number: usize) -> f64 {
    if number == 0 { -1.0 } else { 1.0 }
}
