//! Observer of the rotation of a device: a Kalman filter of orientation and angular momentum under the applied
//! torques.
//!
//! ```text
//! L' = alpha + sigma tau    alpha' = -lambda L' + w    w white
//! omega = R I0^-1 R^T L     R' = [omega] R
//! ```
//!
//! tau is the held torque along the world's axes, alpha the torque of everything else. The moments of inertia are
//! I0/sigma along the tool's axes, with the model value I0. L is therefore the angular momentum times sigma, and its
//! change by a torque does not depend on the orientation. An orientation error is a rotation vector phi in the
//! world's axes, with phi' = A (delta L + L x phi), A = R I0^-1 R^T.

use nalgebra::{Matrix3, Quaternion, SMatrix, SVector};

use crate::Prior;
use crate::device::observer::{EXPLAINED, SURPRISE};
use crate::geometry::rigid::{Rotation, Vector3};

/// Number of estimated states: phi, L, alpha, sigma, lambda.
const STATES: usize = 11;
/// Indices of L, sigma and lambda in the state.
const MOMENTUM: usize = 3;
const SIGMA: usize = 9;
const LAMBDA: usize = 10;
type Column = SVector<f64, STATES>;
type Covariance = SMatrix<f64, STATES, STATES>;
/// Number of fourth-order integration steps per interval.
const STEPS: u32 = 4;

/// Rotational state of a device at a sample.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TurningMotion {
    pub orientation: Rotation,
    /// L `[N m s]`.
    pub momentum: Vector3,
    /// alpha `[N m]`.
    pub external: Vector3,
    /// sigma.
    pub mobility: f64,
    /// lambda `[1/s]`.
    pub damping_rate: f64,
}

/// Torque on a device over an interval, along the world's axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Torque {
    /// Mean `[N m]`.
    pub mean: Vector3,
    /// Moment by which its impulse comes earlier than that of a constant torque `[N m s^2]`.
    pub lead: Vector3,
    /// Standard deviation of the impulse `[N m s]`.
    pub impulse_deviation: Vector3,
}

/// Initial values of an observer.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TurningPrior {
    /// Model moments of inertia along the tool's axes `[kg m^2]`; large values if no torque turns the device.
    pub moments: Vector3,
    /// Whether no torque turns the device, so that no impulse correction applies.
    pub is_immovable: bool,
    /// Whether the hand alone turns the device. It feels no torque, so no impulse correction applies and no inertia
    /// is estimated.
    pub led: bool,
    /// Variance of a measured orientation about each axis `[rad^2]`.
    pub measurement_variance: f64,
    pub prior: Prior,
}

/// Moments of inertia assumed if no torque turns the device: a torque of 1 N m turns it by 5e-13 rad in a millisecond
/// `[kg m^2]`.
const IMMOVABLE: f64 = 1e6;
/// Quantum assumed for an angle sensor with unknown quantum `[rad]`.
const FINEST_QUANTUM: f64 = 1e-8;

impl TurningPrior {
    pub fn new(moments: Vector3, quantum: f64, prior: Prior) -> Self {
        let quantum = quantum.max(FINEST_QUANTUM);
        let is_immovable = moments.iter().any(|moment| moment.is_infinite());
        Self {
            moments: if is_immovable {
                Vector3::repeat(IMMOVABLE)
            } else {
                moments
            },
            is_immovable,
            led: false,
            measurement_variance: quantum * quantum / 12.0,
            prior,
        }
    }

    /// Sets a device that exerts no torque.
    pub fn of_a_hand(self) -> Self {
        Self { led: true, ..self }
    }

    /// Returns the estimated moments of inertia for this mobility, if they are estimated `[kg m^2]`.
    pub fn known(&self, mobility: f64) -> Option<Vector3> {
        if self.led {
            None
        } else if self.is_immovable {
            Some(Vector3::repeat(f64::INFINITY))
        } else {
            Some(self.moments / mobility)
        }
    }
}

impl TurningMotion {
    fn start(orientation: Rotation) -> Self {
        Self {
            orientation,
            momentum: Vector3::zeros(),
            external: Vector3::zeros(),
            mobility: 1.0,
            damping_rate: 0.0,
        }
    }

    /// Returns the angular velocity `[rad/s]`.
    pub fn turning(&self, moments: &Vector3) -> Vector3 {
        turning(&self.orientation, &self.momentum, moments)
    }

    /// Returns the rotational kinetic energy with the estimated inertia `[J]`.
    pub fn kinetic_energy(&self, moments: &Vector3) -> f64 {
        0.5 * self.momentum.dot(&self.turning(moments)) / self.mobility
    }

    /// Returns the device after `h` `[s]` under a torque, and the integral of its angular velocity `[rad]`.
    pub fn under(&self, moments: &Vector3, torque: &Torque, h: f64) -> (Self, Vector3) {
        let rate = self.external + torque.mean * self.mobility;
        let momentum = |time: f64| self.momentum + rate * decayed(self.damping_rate, time);
        let step = h / f64::from(STEPS);
        let (mut q, mut path) = (*self.orientation.quaternion(), Vector3::zeros());
        for number in 0..STEPS {
            let begin = f64::from(number) * step;
            let omega = |q: Quaternion<f64>, time: f64| {
                turning(&Rotation::new_normalize(q), &momentum(time), moments)
            };
            let slope =
                |q: Quaternion<f64>, omega: &Vector3| Quaternion::from_parts(0.0, omega * 0.5) * q;
            let (middle, end) = (begin + 0.5 * step, begin + step);
            let first = omega(q, begin);
            let by_first = slope(q, &first);
            let half = q + by_first * (0.5 * step);
            let second = omega(half, middle);
            let by_second = slope(half, &second);
            let half = q + by_second * (0.5 * step);
            let third = omega(half, middle);
            let by_third = slope(half, &third);
            let whole = q + by_third * step;
            let fourth = omega(whole, end);
            let by_fourth = slope(whole, &fourth);
            q += (by_first + (by_second + by_third) * 2.0 + by_fourth) * (step / 6.0);
            path += (first + (second + third) * 2.0 + fourth) * (step / 6.0);
        }
        let turned = Rotation::new_normalize(q);
        let early = turning(&turned, &(torque.lead * self.mobility), moments);
        let after = Self {
            orientation: rotated(&early, &turned),
            momentum: momentum(h),
            external: self.external - rate * (self.damping_rate * decayed(self.damping_rate, h)),
            ..*self
        };
        (after, path + early)
    }

    /// Returns the derivative of the state at the end with respect to that at the start, to second order in h.
    fn transition(&self, moments: &Vector3, torque: &Torque, h: f64) -> Covariance {
        let rate = self.external + torque.mean * self.mobility;
        let middle = self.momentum + rate * (0.5 * h);
        let omega = turning(&self.orientation, &middle, moments);
        let midway = rotated(&(omega * (0.5 * h)), &self.orientation);
        let axes = midway.to_rotation_matrix().into_inner();
        let inverse = Matrix3::from_diagonal(&moments.map(f64::recip));
        let a = axes * inverse * axes.transpose();
        let spin = a * middle.cross_matrix();
        let one = Matrix3::identity();
        let carried = one + spin * h + spin * spin * (0.5 * h * h);
        let decay = decayed(self.damping_rate, h);
        let slowed = 1.0 - self.damping_rate * h / 3.0;
        let by_momentum = (one * h + spin * (0.5 * h * h)) * a;
        let by_rate = (one * (0.5 * h * h) + spin * (h * h * h / 6.0)) * a * slowed;
        let lead = a * torque.lead;
        let mut transition = Covariance::identity();
        let mut block = |row: usize, column: usize, value: Matrix3<f64>| {
            transition
                .fixed_view_mut::<3, 3>(row, column)
                .copy_from(&value);
        };
        block(0, 0, carried);
        block(0, 3, by_momentum);
        block(0, 6, by_rate);
        block(3, 6, one * decay);
        block(6, 6, one * (1.0 - self.damping_rate * decay));
        let mut column = |row: usize, column: usize, value: Vector3| {
            transition
                .fixed_view_mut::<3, 1>(row, column)
                .copy_from(&value);
        };
        column(0, SIGMA, by_rate * torque.mean + lead);
        column(3, SIGMA, torque.mean * decay);
        column(6, SIGMA, torque.mean * (-self.damping_rate * decay));
        column(0, LAMBDA, a * rate * (-h * h * h / 6.0));
        column(3, LAMBDA, rate * (-0.5 * h * h));
        column(6, LAMBDA, rate * (-h * (1.0 - self.damping_rate * h)));
        transition
    }
}

/// Returns R I^-1 R^T L `[rad/s]`.
fn turning(orientation: &Rotation, momentum: &Vector3, moments: &Vector3) -> Vector3 {
    let own = orientation.inverse_transform_vector(momentum);
    orientation * own.component_div(moments)
}

/// Rotates an orientation by a rotation vector in the world's axes.
pub(crate) fn rotated(vector: &Vector3, orientation: &Rotation) -> Rotation {
    Rotation::from_scaled_axis(*vector) * orientation
}

/// Returns (1 - exp(-lambda h))/lambda `[s]`.
fn decayed(rate: f64, h: f64) -> f64 {
    // rate h is at most one half, so eight terms are exact to rounding.
    let (mut term, mut sum) = (h, h);
    for k in 2..12_u32 {
        term *= -rate * h / f64::from(k);
        sum += term;
    }
    sum
}

/// Uncertainty expected at the end of an interval.
struct Expected {
    /// Covariance of the state at the end with that at the start.
    cross: Covariance,
    /// Covariance of the state at the end.
    covariance: Covariance,
    /// Inverse covariance of the measured rotation vector `[1/rad^2]`, if it exists.
    inverse: Option<Matrix3<f64>>,
}

/// Minimum of the estimated inertia, relative to its model value.
const LIGHTEST: f64 = 0.05;
/// Maximum of the estimated inertia, relative to its model value.
const HEAVIEST: f64 = 20.0;
/// Maximum of the hand damping over inertia, times the period.
const MAX_RATE: f64 = 0.5;

/// Observer of the rotation of a device.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TurningObserver {
    pub motion: TurningMotion,
    covariance: Covariance,
}

impl TurningObserver {
    pub fn new(from: &TurningPrior, orientation: Rotation) -> Self {
        let prior = &from.prior;
        let inertia = from.moments.mean();
        let mut variances = Column::zeros();
        for axis in 0..3 {
            variances[axis] = from.measurement_variance;
            variances[3 + axis] = (prior.angular_velocity * inertia).powi(2);
            variances[6 + axis] = (prior.angular_acceleration * inertia).powi(2);
        }
        variances[SIGMA] = prior.mobility * prior.mobility;
        variances[LAMBDA] = prior.damping_rate * prior.damping_rate;
        Self {
            motion: TurningMotion::start(orientation),
            covariance: Covariance::from_diagonal(&variances),
        }
    }

    /// Updates the estimate with the orientation at the end of an interval of `h` `[s]` under a held torque. Returns
    /// the smoothed state at the beginning of the interval (one-step smoothing). sigma and lambda are equal at both
    /// ends.
    pub fn see(
        &mut self,
        from: &TurningPrior,
        measured: &Rotation,
        torque: &Torque,
        h: f64,
    ) -> TurningMotion {
        let before = self.motion;
        let (end, _) = before.under(&from.moments, torque, h);
        let transition = before.transition(&from.moments, torque, h);
        let innovation = (measured * end.orientation.inverse()).scaled_axis();
        let kick = turning(
            &end.orientation,
            &(torque.impulse_deviation * (before.mobility * h)),
            &from.moments,
        );
        let expects = |at_start: &Covariance| {
            // Covariance of the state at the end with that at the start.
            let cross = transition * at_start;
            let mut covariance = cross * transition.transpose();
            add_jerk(&mut covariance, from, &end, h);
            let mut variance: Matrix3<f64> = covariance.fixed_view::<3, 3>(0, 0).into();
            for axis in 0..3 {
                variance[(axis, axis)] += from.measurement_variance + kick[axis] * kick[axis];
            }
            (cross, covariance, variance.try_inverse())
        };
        let (mut cross, mut covariance, mut inverse) = expects(&self.covariance);
        if inverse.is_some_and(|inverse| innovation.dot(&(inverse * innovation)) > SURPRISE) {
            // Kick at the start of the interval, as along an axis: the angular velocity becomes that of the last
            // step.
            let rate = innovation.norm_squared() / (EXPLAINED * h * h);
            let axes = before.orientation.to_rotation_matrix().into_inner();
            let inertia = axes * Matrix3::from_diagonal(&from.moments) * axes.transpose();
            let mut at_start = self.covariance;
            let mut momentum = at_start.fixed_view_mut::<3, 3>(MOMENTUM, MOMENTUM);
            momentum += inertia * inertia * rate;
            (cross, covariance, inverse) = expects(&at_start);
        }
        let expected = Expected {
            cross,
            covariance,
            inverse,
        };
        let Some(smoothed) = self.adapt(&innovation, &end, expected, h) else {
            *self = Self::new(from, *measured);
            return self.motion;
        };
        smoothed
    }

    /// Corrects the estimate by an `innovation` `[rad]`. Returns the smoothed start, or `None` if that is impossible.
    #[inline(always)]
    fn adapt(
        &mut self,
        innovation: &Vector3,
        end: &TurningMotion,
        expected: Expected,
        h: f64,
    ) -> Option<TurningMotion> {
        let before = self.motion;
        let Expected {
            cross,
            mut covariance,
            inverse,
        } = expected;
        let inverse = inverse?;
        let weighed = inverse * innovation;
        let seen: SMatrix<f64, STATES, 3> = covariance.fixed_columns::<3>(0).into();
        let update = seen * weighed;
        let smoothing = cross.fixed_rows::<3>(0).transpose() * weighed;
        covariance -= seen * inverse * seen.transpose();
        covariance = (covariance + covariance.transpose()) * 0.5;
        for state in 0..STATES {
            // Negative only by rounding.
            covariance[(state, state)] = covariance[(state, state)].max(0.0);
        }
        let part = |column: &Column, row: usize| -> Vector3 { column.fixed_rows::<3>(row).into() };
        let mobility = (before.mobility + update[SIGMA]).clamp(1.0 / HEAVIEST, 1.0 / LIGHTEST);
        let damping_rate = (before.damping_rate + update[LAMBDA]).clamp(0.0, MAX_RATE / h);
        let with = |motion: &TurningMotion, column: &Column| TurningMotion {
            orientation: rotated(&part(column, 0), &motion.orientation),
            momentum: motion.momentum + part(column, 3),
            external: motion.external + part(column, 6),
            mobility,
            damping_rate,
        };
        let adapted = Self {
            motion: with(end, &update),
            covariance,
        };
        if !adapted.is_sound() {
            return None;
        }
        *self = adapted;
        Some(with(&before, &smoothing))
    }

    fn is_sound(&self) -> bool {
        let motion = &self.motion;
        let sum = motion.momentum.sum() + motion.external.sum() + motion.orientation.coords.sum();
        (sum + motion.mobility + motion.damping_rate + self.covariance.sum()).is_finite()
    }
}

/// Adds the covariance due to the hand's angular jerk over an interval of `h` `[s]`.
#[inline]
fn add_jerk(covariance: &mut Covariance, from: &TurningPrior, end: &TurningMotion, h: f64) {
    for axis in 0..3 {
        let own = end.orientation * Vector3::ith(axis, from.prior.angular_jerk);
        let moment = from.moments[axis];
        let mut jerk = Column::zeros();
        jerk.fixed_rows_mut::<3>(0)
            .copy_from(&(own * (h * h * h / 6.0)));
        jerk.fixed_rows_mut::<3>(3)
            .copy_from(&(own * (moment * h * h / 2.0)));
        jerk.fixed_rows_mut::<3>(6).copy_from(&(own * (moment * h)));
        *covariance += jerk * jerk.transpose();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MOMENTS: Vector3 = Vector3::new(3e-5, 2e-4, 1.2e-4);

    fn some_motion() -> TurningMotion {
        TurningMotion {
            orientation: Rotation::from_scaled_axis(Vector3::new(0.3, -1.1, 0.4)),
            momentum: Vector3::new(1e-4, -4e-4, 3e-4),
            external: Vector3::new(-0.004, 0.002, 0.003),
            mobility: 1.3,
            damping_rate: 17.0,
        }
    }

    fn some_torque() -> Torque {
        Torque {
            mean: Vector3::new(0.02, -0.01, 0.015),
            lead: Vector3::zeros(),
            impulse_deviation: Vector3::zeros(),
        }
    }

    /// Comparison with many small steps of the same equations.
    #[test]
    fn the_motion_is_that_of_a_turning_body() {
        let (motion, torque, h) = (some_motion(), some_torque(), 0.004);
        let (end, path) = motion.under(&MOMENTS, &torque, h);
        let steps = 200_000;
        let step = h / f64::from(steps);
        let mut orientation = motion.orientation;
        let (mut momentum, mut external) = (motion.momentum, motion.external);
        let mut way = Vector3::zeros();
        for _ in 0..steps {
            let rate = external + torque.mean * motion.mobility;
            let middle = momentum + rate * (0.5 * step);
            let omega = turning(&orientation, &middle, &MOMENTS);
            way += omega * step;
            orientation = rotated(&(omega * step), &orientation);
            momentum += rate * step;
            external -= rate * (motion.damping_rate * step);
        }
        assert!(end.orientation.angle_to(&orientation) < 1e-7);
        assert!((end.momentum - momentum).norm() < 1e-6 * momentum.norm());
        assert!((end.external - external).norm() < 1e-4 * external.norm());
        assert!((path - way).norm() < 1e-7);
    }

    #[test]
    fn the_transition_is_the_derivative_of_the_motion() {
        let (motion, torque, h) = (some_motion(), some_torque(), 0.001);
        let transition = motion.transition(&MOMENTS, &torque, h);
        let at_end = motion.under(&MOMENTS, &torque, h).0;
        let sizes = [1.0, 4e-4, 0.02, 1.0, 10.0];
        for state in 0..STATES {
            let kind = if state < SIGMA { state / 3 } else { state - 6 };
            let step = 1e-4 * sizes[kind];
            let end = |by: f64| {
                let mut moved = motion;
                let along = Vector3::ith(state % 3, by);
                match kind {
                    0 => moved.orientation = rotated(&along, &moved.orientation),
                    1 => moved.momentum += along,
                    2 => moved.external += along,
                    3 => moved.mobility += by,
                    _ => moved.damping_rate += by,
                }
                let end = moved.under(&MOMENTS, &torque, h).0;
                let phi = (end.orientation * at_end.orientation.inverse()).scaled_axis();
                [
                    phi,
                    end.momentum - at_end.momentum,
                    end.external - at_end.external,
                ]
            };
            let (more, less) = (end(step), end(-step));
            for row in 0..3 {
                let slope = (more[row] - less[row]) / (2.0 * step);
                let model: Vector3 = transition.fixed_view::<3, 1>(3 * row, state).into();
                // Relative to the effect of a typical state error on a typical value.
                let off = (slope - model).norm() * sizes[kind] / sizes[row];
                assert!(off < 2e-3, "{row} {state}: {slope:?} {model:?} {off}");
            }
        }
    }

    /// Inertia with a wrong model value, under known torques in a hand with damping: the observer estimates the
    /// inertia.
    #[test]
    fn inertia_is_learned_from_torques() {
        let model = MOMENTS * 1.6;
        let from = TurningPrior::new(model, 1e-5, Prior::default());
        let mut real = TurningMotion::start(Rotation::identity());
        let mut observer = TurningObserver::new(&from, real.orientation);
        for sample in 0..3000_u32 {
            let sign = |shift: u32| {
                if ((sample + shift) / 37).is_multiple_of(2) {
                    1.0
                } else {
                    -1.0
                }
            };
            let torque = Torque {
                mean: Vector3::new(sign(0), sign(11), -sign(23)) * 0.01,
                ..some_torque()
            };
            real.external = -real.momentum * 8.0;
            real = real.under(&MOMENTS, &torque, 0.001).0;
            observer.see(&from, &real.orientation, &torque, 0.001);
        }
        let found = observer.motion;
        assert!((found.mobility / 1.6 - 1.0).abs() < 0.05, "{found:?}");
        let off = found.turning(&model) - real.turning(&MOMENTS);
        assert!(
            off.norm() < 0.05 * real.turning(&MOMENTS).norm().max(1.0),
            "{off:?}"
        );
    }
}
