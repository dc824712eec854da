//! A solid by a smooth function: the points at which it is below 0.
//!
//! The function is a sum of cubic B-splines over a grid of nodes. Value, gradient and curvature are continuous.

use super::scene::Vector;
use super::vector::{Rotation, Vec3};

/// A function over a grid, in the axes of the body that has it.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    /// Place of the first node `[m]`, and how the grid is turned.
    first: Vec3,
    rotation: Rotation,
    spacing: f64,
    counts: [usize; 3],
    /// One for each node, x fastest `[m]`.
    coefficients: Vec<f64>,
}

/// The function at a place, in the body's axes.
#[derive(Debug, Clone, Copy)]
pub(super) struct At {
    /// `[m]`
    pub value: f64,
    pub gradient: Vec3,
    /// Rate of the gradient for a moving point `[1/s]`.
    pub gradient_rate: Vec3,
}

/// The cubic B-spline about a node, its first and its second derivative, at so many spacings from the node.
fn basis(off: f64) -> [f64; 3] {
    let (u, sign) = (off.abs(), off.signum());
    if u < 1.0 {
        [
            2.0 / 3.0 - u * u + 0.5 * u * u * u,
            sign * u * (1.5 * u - 2.0),
            3.0 * u - 2.0,
        ]
    } else if u < 2.0 {
        let v = 2.0 - u;
        [v * v * v / 6.0, -0.5 * sign * v * v, v]
    } else {
        [0.0; 3]
    }
}

impl Field {
    /// A function by its `coefficients` `[m]`, one for each of `counts` nodes along each axis, those along x fastest.
    /// The first node is at `first` `[m]`, others at multiples of `spacing` `[m]` along the axes that `orientation`
    /// turns the body's to.
    ///
    /// `None` if there are other coefficients than nodes, or fewer than four nodes along an axis.
    #[must_use]
    pub fn new(
        coefficients: Vec<f64>,
        counts: [usize; 3],
        spacing: f64,
        first: Vector,
        orientation: [f64; 4],
    ) -> Option<Self> {
        let is_whole = counts.iter().product::<usize>() == coefficients.len()
            && counts.iter().all(|&count| count >= 4)
            && spacing > 0.0;
        is_whole.then(|| Self {
            first: Vec3(first),
            rotation: Rotation::of_quaternion(orientation),
            spacing,
            counts,
            coefficients,
        })
    }

    /// The function at a place that moves with a velocity. Beyond the nodes that have neighbours it is the distance
    /// from these and a spacing.
    pub(super) fn at(&self, place: Vec3, velocity: Vec3) -> At {
        let inv = 1.0 / self.spacing;
        let steps = self.rotation.back(place - self.first) * inv;
        let moving = self.rotation.back(velocity) * inv;
        let mut beyond = Vec3::ZERO;
        let mut nearest = [0; 3];
        for (axis, nearest) in nearest.iter_mut().enumerate() {
            let most = (self.counts[axis] - 2) as f64;
            let held = steps.0[axis].clamp(1.0, most);
            beyond.0[axis] = steps.0[axis] - held;
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "it lies between two numbers of nodes, or is no number and 0"
            )]
            let before = held as usize;
            *nearest = before.min(self.counts[axis] - 3);
        }
        let outside = beyond.norm();
        if outside.is_nan() || outside > 0.0 {
            let out = beyond.direction().unwrap_or(Vec3([1.0, 0.0, 0.0]));
            return At {
                value: (outside + 1.0) * self.spacing,
                gradient: self.rotation.out(out),
                gradient_rate: Vec3::ZERO,
            };
        }
        let [along_x, along_y, along_z] = [0, 1, 2].map(|axis| {
            let of = |k: usize| basis(steps.0[axis] - (nearest[axis] + k - 1) as f64);
            [of(0), of(1), of(2), of(3)]
        });
        let [u, v, w] = moving.0;
        let mut value = 0.0;
        let mut gradient = Vec3::ZERO;
        let mut rate = Vec3::ZERO;
        for (k, [bz, dz, cz]) in along_z.into_iter().enumerate() {
            for (j, [by, dy, cy]) in along_y.into_iter().enumerate() {
                let row = nearest[1] + j - 1 + self.counts[1] * (nearest[2] + k - 1);
                let from = nearest[0] - 1 + self.counts[0] * row;
                // The sums over x of the splines and of their two derivatives.
                let mut sums = [0.0; 3];
                for (of, splines) in self.coefficients[from..from + 4].iter().zip(along_x) {
                    for (sum, spline) in sums.iter_mut().zip(splines) {
                        *sum += of * spline;
                    }
                }
                let [b, d, c] = sums;
                value += b * by * bz;
                gradient += Vec3([d * by * bz, b * dy * bz, b * by * dz]);
                let [xy, xz, yz] = [d * dy * bz, d * by * dz, b * dy * dz];
                rate += Vec3([
                    c * by * bz * u + xy * v + xz * w,
                    xy * u + b * cy * bz * v + yz * w,
                    xz * u + yz * v + b * by * cz * w,
                ]);
            }
        }
        At {
            value,
            gradient: self.rotation.out(gradient * inv),
            gradient_rate: self.rotation.out(rate * inv),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn field() -> Field {
        let mut numbers = crate::random::SplitMix64::new(3);
        let coefficients = (0..6 * 7 * 8).map(|_| numbers.unit() - 0.5).collect();
        let half = 0.5_f64.sqrt();
        let first = [0.1, -0.2, 0.3];
        Field::new(coefficients, [6, 7, 8], 0.2, first, [half, 0.3, -0.4, 0.5]).unwrap()
    }

    /// Places that have a function, in the body's axes.
    fn places(field: &Field) -> impl Iterator<Item = Vec3> {
        let mut numbers = crate::random::SplitMix64::new(5);
        (0..300).map(move |_| {
            let steps = Vec3([3.0, 4.0, 5.0].map(|cells| 1.0 + cells * numbers.unit()));
            field.first + field.rotation.out(steps * field.spacing)
        })
    }

    #[test]
    fn gradient_and_its_rate_are_the_derivatives() {
        let field = field();
        let velocity = Vec3([0.3, -0.8, 0.5]);
        for place in places(&field) {
            let here = field.at(place, velocity);
            let step = 1e-6;
            for axis in 0..3 {
                let mut by = Vec3::ZERO;
                by.0[axis] = step;
                let [far, near] = [place + by, place - by].map(|x| field.at(x, Vec3::ZERO).value);
                let slope = (far - near) / (2.0 * step);
                assert!((slope - here.gradient.0[axis]).abs() < 1e-7, "{place:?}");
            }
            let [after, before] =
                [step, -step].map(|t| field.at(place + velocity * t, Vec3::ZERO).gradient);
            let rate = (after - before) * (0.5 / step);
            assert!((rate - here.gradient_rate).norm() < 1e-5 * (1.0 + rate.norm()));
        }
    }

    /// Splines of equal coefficients are that number everywhere, and those of places are the place.
    #[test]
    fn the_splines_share_one_whole_among_them() {
        let counts = [5, 6, 7];
        let all = (0..7).flat_map(|z| (0..6).flat_map(move |y| (0..5).map(move |x| [x, y, z])));
        let linear =
            all.map(|[x, y, z]| 0.3 + f64::from(x) - 2.0 * f64::from(y) + 0.5 * f64::from(z));
        let field = Field::new(
            linear.collect(),
            counts,
            1.0,
            [0.0; 3],
            [1.0, 0.0, 0.0, 0.0],
        );
        let at = field
            .unwrap()
            .at(Vec3([2.2, 1.7, 3.4]), Vec3([1.0, 1.0, 1.0]));
        assert!((at.value - (0.3 + 2.2 - 3.4 + 1.7)).abs() < 1e-14);
        assert!((at.gradient - Vec3([1.0, -2.0, 0.5])).norm() < 1e-14);
        assert!(at.gradient_rate.norm() < 1e-13);
    }

    #[test]
    fn other_coefficients_than_nodes_make_no_field() {
        let turn = [1.0, 0.0, 0.0, 0.0];
        assert!(Field::new(vec![0.0; 63], [4; 3], 1.0, [0.0; 3], turn).is_none());
        assert!(Field::new(vec![0.0; 48], [4, 4, 3], 1.0, [0.0; 3], turn).is_none());
        assert!(Field::new(vec![0.0; 64], [4; 3], 0.0, [0.0; 3], turn).is_none());
    }
}
