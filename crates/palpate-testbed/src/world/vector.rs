//! Vectors and rotations in space.

use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

/// Three numbers along the axes of the world's frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Vec3(pub [f64; 3]);

impl Vec3 {
    pub const ZERO: Self = Self([0.0; 3]);

    pub fn new(slice: &[f64]) -> Self {
        Self([slice[0], slice[1], slice[2]])
    }

    pub fn dot(self, other: Self) -> f64 {
        self.0[0] * other.0[0] + self.0[1] * other.0[1] + self.0[2] * other.0[2]
    }

    pub fn cross(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Self([b * z - c * y, c * x - a * z, a * y - b * x])
    }

    pub fn norm(self) -> f64 {
        self.dot(self).sqrt()
    }

    /// The part at right angles to a unit vector.
    pub fn across(self, unit: Self) -> Self {
        self - unit * unit.dot(self)
    }

    /// The unit vector along this one; `None` where there is none.
    pub fn direction(self) -> Option<Self> {
        let norm = self.norm();
        (norm > 0.0).then(|| self * (1.0 / norm))
    }

    pub fn write(self, to: &mut [f64]) {
        to[..3].copy_from_slice(&self.0);
    }
}

impl Add for Vec3 {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] + other.0[i]))
    }
}

impl Sub for Vec3 {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] - other.0[i]))
    }
}

impl Neg for Vec3 {
    type Output = Self;
    fn neg(self) -> Self {
        self * -1.0
    }
}

impl Mul<f64> for Vec3 {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        Self(self.0.map(|number| number * factor))
    }
}

impl AddAssign for Vec3 {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Vec3 {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

/// A rotation from a body's axes to the world's: the columns are the body's axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rotation([Vec3; 3]);

impl Rotation {
    /// Of a quaternion `[w, x, y, z]` of any length above 0.
    pub fn of_quaternion(q: [f64; 4]) -> Self {
        let [w, x, y, z] = q;
        let s = 2.0 / (w * w + x * x + y * y + z * z);
        Self([
            Vec3([
                1.0 - s * (y * y + z * z),
                s * (x * y + w * z),
                s * (x * z - w * y),
            ]),
            Vec3([
                s * (x * y - w * z),
                1.0 - s * (x * x + z * z),
                s * (y * z + w * x),
            ]),
            Vec3([
                s * (x * z + w * y),
                s * (y * z - w * x),
                1.0 - s * (x * x + y * y),
            ]),
        ])
    }

    /// From the body's axes to the world's.
    pub fn out(&self, v: Vec3) -> Vec3 {
        self.0[0] * v.0[0] + self.0[1] * v.0[1] + self.0[2] * v.0[2]
    }

    /// This rotation after another one.
    pub fn after(&self, first: &Self) -> Self {
        Self(first.0.map(|axis| self.out(axis)))
    }

    /// From the world's axes to the body's.
    pub fn back(&self, v: Vec3) -> Vec3 {
        Vec3([self.0[0].dot(v), self.0[1].dot(v), self.0[2].dot(v)])
    }
}

/// Rate of a quaternion that turns with an angular velocity ω in world axes: q′ = (0, ω) q/2.
pub(super) fn quaternion_rate(q: [f64; 4], omega: Vec3) -> [f64; 4] {
    let (w, v) = (q[0], Vec3::new(&q[1..]));
    let vector = (omega * w + omega.cross(v)) * 0.5;
    [-0.5 * omega.dot(v), vector.0[0], vector.0[1], vector.0[2]]
}

/// The smallest rotation that turns one unit vector into another, applied to `v`.
pub(super) fn turned(v: Vec3, from: Vec3, to: Vec3) -> Vec3 {
    // Rodrigues' formula; axis times sine is from × to.
    let axis = from.cross(to);
    let cosine = from.dot(to);
    if cosine <= -1.0 + 1e-12 {
        return v; // turned over: any axis would do, and none is better
    }
    v * cosine + axis.cross(v) + axis * (axis.dot(v) / (1.0 + cosine))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: Vec3, b: Vec3) -> bool {
        (a - b).norm() < 1e-14
    }

    #[test]
    fn a_quarter_turn_about_z_takes_x_to_y() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        // The quaternion need not have unit length.
        let rotation = Rotation::of_quaternion([3.0 * half, 0.0, 0.0, 3.0 * half]);
        assert!(close(
            rotation.out(Vec3([1.0, 0.0, 0.0])),
            Vec3([0.0, 1.0, 0.0])
        ));
        let v = Vec3([0.3, -1.2, 0.7]);
        assert!(close(rotation.back(rotation.out(v)), v));
    }

    #[test]
    fn the_rate_of_a_quaternion_is_that_of_the_points_it_turns() {
        let q = [0.8, 0.1, -0.5, 0.3];
        let (omega, point) = (Vec3([0.4, -2.0, 1.1]), Vec3([0.2, 0.5, -0.9]));
        let step = 1e-6;
        let rate = quaternion_rate(q, omega);
        let at = |t: f64| {
            let moved = std::array::from_fn(|i| q[i] + t * rate[i]);
            Rotation::of_quaternion(moved).out(point)
        };
        let numeric = (at(step) - at(-step)) * (0.5 / step);
        assert!((numeric - omega.cross(at(0.0))).norm() < 1e-9);
    }

    #[test]
    fn the_smallest_rotation_takes_one_vector_to_the_other_and_keeps_their_axis() {
        let a = Vec3([1.0, 2.0, 2.0]) * (1.0 / 3.0);
        let b = Vec3([2.0, -1.0, 2.0]) * (1.0 / 3.0);
        assert!(close(turned(a, a, b), b));
        let axis = a.cross(b);
        assert!(close(turned(axis, a, b), axis));
        let v = Vec3([0.1, 0.7, -0.2]);
        assert!((turned(v, a, b).norm() - v.norm()).abs() < 1e-14);
    }
}
