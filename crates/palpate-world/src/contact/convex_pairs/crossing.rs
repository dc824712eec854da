//! Separating plane at the crossing of two cylinder rims.
//!
//! D(n) is the overlap of the second cylinder with the plane that has the first behind it and the outward normal n.
//! At a minimum of D with n neither along an axis nor perpendicular to one, the plane touches a rim of each cylinder
//! where the rims cross. The vector between the outermost points of the two rims is then along n.

use std::f64::consts::FRAC_PI_2;

use super::Bound;
use super::rims::Cylinder;
use super::zero::rising_zero;
use crate::geometry::rigid::Vector3;

/// Maximum number of Newton steps.
const MAX_STEPS: usize = 40;
/// Longest step `[rad]`.
const LONGEST: f64 = 0.3;
/// Slope, relative to the size of the solids, below which it is zero.
const NO_SLOPE: f64 = 1e-13;
/// Sine and cosine below which a normal is parallel or perpendicular to an axis.
const ALONG: f64 = 1e-9;

/// Two cylinders projected on a direction.
struct Across<'a> {
    cylinders: [&'a Cylinder; 2],
    /// Half-space with the first cylinder behind it.
    bound: Bound,
    /// Vector from the second cylinder's outermost point against the normal to the first's along it `[m]`.
    way: Vector3,
}

impl<'a> Across<'a> {
    fn new(cylinders: [&'a Cylinder; 2], normal: Vector3) -> Self {
        let bound = Bound {
            normal,
            offset: 0.0,
        };
        let [first, second] = cylinders;
        let outermost = first.deepest(&bound.turned_round());
        Self {
            cylinders,
            bound: Bound {
                normal,
                offset: normal.dot(&outermost),
            },
            way: outermost - second.deepest(&bound),
        }
    }

    fn overlap(&self) -> f64 {
        self.way.dot(&self.bound.normal)
    }

    fn slope(&self) -> Vector3 {
        self.way - self.bound.normal * self.overlap()
    }

    /// Returns whether the normal is neither parallel nor perpendicular to an axis, so that the plane touches the
    /// rims.
    fn is_at_rims(&self) -> bool {
        self.cylinders.iter().all(|cylinder| {
            let along = self.bound.normal.dot(&cylinder.axes[2]).abs();
            along > ALONG && (1.0 - along * along).max(0.0).sqrt() > ALONG
        })
    }

    /// Returns a Newton step, or a gradient step if D is not convex.
    fn step(&self) -> Vector3 {
        let slope = self.slope();
        let one = self.bound.normal.cross(&self.cylinders[0].axes[2]);
        let basis = match one.try_normalize(0.0) {
            Some(one) => [one, self.bound.normal.cross(&one)],
            None => return -slope,
        };
        let mut second = nalgebra::Matrix2::identity() * -self.overlap();
        let mut most = 0.0;
        for cylinder in self.cylinders {
            let axis = cylinder.axes[2];
            let across = axis.cross(&self.bound.normal);
            let sine = across.norm();
            // Direction of the rim's curvature.
            let along = nalgebra::Vector2::from(basis.map(|basis| basis.dot(&across) / sine));
            let bend = cylinder.radius / sine;
            second += along * along.transpose() * bend;
            most += bend;
        }
        let flat = nalgebra::Vector2::from(basis.map(|basis| basis.dot(&slope)));
        let is_convex = second[(0, 0)] > 0.0 && second.determinant() > 0.0;
        let step = second
            .try_inverse()
            .filter(|_| is_convex)
            .map_or(-flat / most, |inverse| -(inverse * flat));
        let step = if step.norm() > LONGEST {
            step * (LONGEST / step.norm())
        } else {
            step
        };
        basis[0] * step.x + basis[1] * step.y
    }

    fn moved(&self, way: &Vector3) -> Self {
        Self::new(self.cylinders, (self.bound.normal + way).normalize())
    }

    /// Descends to the nearest minimum of the overlap, or to any separating direction.
    fn least(mut self) -> Option<Self> {
        let size: f64 = self.cylinders.iter().map(|cylinder| cylinder.reach()).sum();
        for _ in 0..MAX_STEPS {
            if self.overlap() <= 0.0 {
                return Some(self);
            }
            if !self.is_at_rims() {
                return None;
            }
            if self.slope().norm() < NO_SLOPE * size {
                return Some(self);
            }
            let mut step = self.step();
            let mut next = self.moved(&step);
            // Near the minimum the overlaps differ only by rounding.
            while next.overlap() > self.overlap() && step.norm() > 1e-6 {
                step *= 0.5;
                next = self.moved(&step);
            }
            self = next;
        }
        None
    }
}

/// Returns the plane at the crossing of two rims, if they cross. `sides` are the planes at the side of each cylinder.
/// A separating plane is returned as soon as one is found.
pub(super) fn across_rims(cylinders: [&Cylinder; 2], sides: [Option<Bound>; 2]) -> Option<Bound> {
    let mut least: Option<(f64, Bound)> = None;
    for of in [0, 1] {
        let (own, other) = (cylinders[of], cylinders[1 - of]);
        let axis = own.axes[2];
        let caps = [0, 1].map(|number| Some(own.cap(number)));
        for (number, bound) in caps.into_iter().chain([sides[of]]).enumerate() {
            let Some(bound) = bound else { continue };
            // The overlap decreases from a cap or side towards the direction in which the other's deepest point is
            // beyond it.
            let place = other.deepest(&bound) - own.centre;
            let along = axis * axis.dot(&place);
            let (beyond, reach) = if number < 2 {
                (place - along, own.radius)
            } else {
                (along, own.half_length)
            };
            if beyond.norm() <= reach {
                continue;
            }
            let towards = beyond.normalize();
            let at = |angle: f64| {
                let (sine, cosine) = angle.sin_cos();
                let sign = if of == 0 { 1.0 } else { -1.0 };
                let here = Across::new(cylinders, (bound.normal * cosine + towards * sine) * sign);
                let rate = (towards * cosine - bound.normal * sine) * sign;
                (here.way.dot(&rate), here)
            };
            let (low, high) = (ALONG, FRAC_PI_2 - ALONG);
            let (of_low, of_high) = (at(low).0, at(high).0);
            if !(of_low < 0.0 && of_high > 0.0) {
                continue;
            }
            let ends = ((low, of_low), (high, of_high));
            let angle = rising_zero(ends.0, ends.1, |angle| at(angle).0);
            let Some(found) = at(angle).1.least() else {
                continue;
            };
            let overlap = found.overlap();
            if least.is_none_or(|(least, _)| overlap < least) {
                least = Some((overlap, found.bound));
            }
            if overlap <= 0.0 {
                return Some(found.bound);
            }
        }
    }
    Some(least?.1)
}
