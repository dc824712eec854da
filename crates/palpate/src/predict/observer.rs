//! The device observer: a Kalman filter of the device's motion under the forces it is known to
//! have felt.
//!
//! # The model
//!
//! Over one interval the device is a mass m pushed by an acceleration a_u that changes slowly (the
//! user, friction, gravity) and by the force f that is held. With theta = 1/m as a part of the
//! state, one interval is linear in the state, because f is known:
//!
//! ```text
//! xi+    = xi + u h + (a_u - theta f) h^2/2
//! u+     = u + (a_u - theta f) h
//! a_u+   = a_u + h w          w white, of variance q: the jerk of the hand
//! theta+ = theta
//! ```
//!
//! # The form
//!
//! The covariance is kept as U D U' with U unit upper triangular and D diagonal (Bierman,
//! *Factorization Methods for Discrete Sequential Estimation*, 1977; the time step after
//! Thornton). It cannot lose its symmetry or its sign, in single precision as in double, however
//! small a sensor's quantum is against the motion. The last diagonal entry is the variance of
//! theta itself.
//!
//! # What it adapts to
//!
//! - **q** follows the observed innovations: see [`ObserverParams`].
//! - **theta** learns from excitation only. A force that does not change tells nothing that a_u
//!   could not have done as well, and then the variance of theta stays what it is, for hours. A
//!   sample far from what was expected puts theta in doubt again: a hand may have grabbed the device.

use crate::Scalar;
use crate::contact::Mass;
use crate::parameter::{ParameterError, not_negative, positive};

/// What the observer starts from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ObserverParams<S> {
    /// 1/m as told `[1/kg]`; 0 for a device that no force can move.
    pub mobility: S,
    /// Variance of a measured position `[m^2]`.
    pub measurement_variance: S,
    /// Variance of the jerk to begin with `[m^2/s^6]`.
    pub jerk_variance: S,
    /// Least variance of the jerk `[m^2/s^6]`.
    pub least_jerk_variance: S,
}

impl<S: Scalar> ObserverParams<S> {
    /// From what a user knows: the device's effective mass within a factor of 2 `[kg]`, and its
    /// sensor's quantum `[m]`, 0 if it is not known to have one.
    pub fn new(device_mass: Mass<S>, encoder_quantum: S) -> Result<Self, ParameterError> {
        let mobility = match device_mass {
            Mass::Finite(mass) => S::ONE / positive("device_mass", "kg", mass)?,
            Mass::Infinite => S::ZERO,
        };
        let quantum =
            not_negative("encoder_quantum", "m", encoder_quantum)?.max(S::from_f64(FINEST_QUANTUM));
        let square = |x: f64| S::from_f64(x * x);
        Ok(Self {
            mobility,
            // A position is anywhere within its quantum.
            measurement_variance: quantum * quantum * S::from_f64(1.0 / 12.0),
            jerk_variance: square(FIRST_JERK),
            least_jerk_variance: square(LEAST_JERK),
        })
    }
}

/// What the sample at an interval's end tells.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen<S> {
    /// By how much the measured position has changed over the interval `[m]`.
    pub moved: S,
    /// Duration of the interval `[s]`.
    pub elapsed: S,
    /// Force on the object that was held `[N]`; the device felt its opposite.
    pub held_force: S,
}

/// The device at a sample, as far as it is known.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motion<S> {
    /// Position, counted from the measured one `[m]`.
    pub offset: S,
    /// Velocity u `[m/s]`.
    pub velocity: S,
    /// Acceleration by everything but the contact, a_u `[m/s^2]`.
    pub external: S,
    /// theta = 1/m `[1/kg]`.
    pub mobility: S,
}

impl<S: Scalar> Motion<S> {
    /// Displacement and change of velocity over `h` `[s]` under `force` `[N]` on the object.
    #[inline]
    pub fn under(&self, force: S, h: S) -> (S, S) {
        let gained = (self.external - self.mobility * force) * h;
        ((self.velocity + S::HALF * gained) * h, gained)
    }
}

/// The state of the observer. Positions count from the last sample, so that an origin far away
/// costs no digits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Observer<S> {
    /// The device at the last sample.
    pub motion: Motion<S>,
    /// U above its diagonal of ones: rows 0 to 2, columns 1 to 3.
    upper: [[S; 3]; 3],
    /// D.
    diagonal: [S; 4],
    /// q `[m^2/s^6]`.
    jerk_variance: S,
}

/// Quantum of a sensor that is not known to have one `[m]`.
const FINEST_QUANTUM: f64 = 1e-9;
/// Standard deviation of a hand's jerk to begin with `[m/s^3]`.
const FIRST_JERK: f64 = 50.0;
/// Standard deviation of the jerk that is always reckoned with `[m/s^3]`.
const LEAST_JERK: f64 = 1.0;
/// Largest standard deviation of the jerk that innovations are put down to `[m/s^3]`. Beyond it the
/// filter would follow every quantum.
const MOST_JERK: f64 = 2e4;
/// Standard deviation of the velocity to begin with `[m/s]`.
const FIRST_SPEED: f64 = 0.1;
/// Standard deviation of the external acceleration to begin with `[m/s^2]`.
const FIRST_ACCELERATION: f64 = 20.0;
/// Standard deviation of 1/m to begin with, as a part of what was told.
const FIRST_MOBILITY: f64 = 0.5;
/// The estimate of 1/m stays within this factor of what was told.
const MOBILITY_RANGE: f64 = 20.0;
/// Innovations whose square is beyond this multiple of what is expected put the mass in doubt.
const SURPRISE: f64 = 25.0;
/// Square of the standard deviations that are left of a surprise when a kick has been reckoned with.
const EXPLAINED: f64 = 4.0;
/// Standard deviation of a mobility in doubt, as a part of it.
const DOUBT: f64 = 0.25;
/// How fast the jerk's variance follows the innovations, per sample.
const JERK_GAIN: f64 = 0.2;
/// Innovations are kept at this multiple of the variance that is expected of them. Above 1, because
/// where the sensor's quantum hides the motion the innovations say nothing of the jerk, and it is
/// then to be taken for small.
const JERK_TARGET: f64 = 1.2;
/// Innovation variances beyond this multiple of the expected one count as this.
const JERK_CAP: f64 = 9.0;

/// What a sample is expected to tell before it comes.
struct Foreseen<S> {
    /// Variance of the innovation `[m^2]`.
    variance: S,
    /// Covariance of the innovation with position, velocity and external acceleration at the
    /// interval's beginning.
    cross: [S; 3],
}

impl<S: Scalar> Observer<S> {
    pub fn new(params: &ObserverParams<S>) -> Self {
        let square = |x: f64| S::from_f64(x * x);
        let mobility = params.mobility;
        Self {
            motion: Motion {
                offset: S::ZERO,
                velocity: S::ZERO,
                external: S::ZERO,
                mobility,
            },
            upper: [[S::ZERO; 3]; 3],
            diagonal: [
                params.measurement_variance,
                square(FIRST_SPEED),
                square(FIRST_ACCELERATION),
                square(FIRST_MOBILITY) * mobility * mobility,
            ],
            jerk_variance: params.jerk_variance,
        }
    }

    /// Takes the sample at the end of an interval, and returns the device at its beginning as the
    /// sample makes it look now: the one-step smoothed state, but for theta, which is the same at
    /// both ends.
    pub fn see(&mut self, params: &ObserverParams<S>, seen: &Seen<S>) -> Motion<S> {
        let Seen {
            moved,
            elapsed: h,
            held_force: f,
        } = *seen;
        let before = self.motion;
        let (travel, gained) = before.under(f, h);
        let innovation = moved - (before.offset + travel);

        let half_square = S::HALF * h * h;
        let jerk = [half_square * h * S::from_f64(1.0 / 3.0), half_square, h];
        let jerk_variance = self.jerk_variance;
        let unseen = params.measurement_variance + jerk_variance * jerk[0] * jerk[0];
        let row = [h, half_square, -(f * half_square)];
        let mut foreseen = self.foreseen(row, unseen);
        let square = innovation * innovation;
        let surprised = square > S::from_f64(SURPRISE) * foreseen.variance;
        if surprised {
            // Nothing the filter reckons with: something kicked the device, or it was grabbed. Let
            // the kick come first in the interval, which makes the velocity that of the last step.
            self.kick((square / S::from_f64(EXPLAINED) - foreseen.variance) / (h * h));
            foreseen = self.foreseen(row, unseen);
        }
        let Foreseen {
            variance: expected,
            cross,
        } = foreseen;
        let [[u01, u02, u03], [_, u12, u13], [_, _, u23]] = self.upper;
        let [d0, d1, d2, d3] = self.diagonal;

        let [u01, u02, u03, u12, u13, u23, d0, d1, d2] = {
            // Time step: U over the transition, D, and the jerk as a fifth column, orthogonalised
            // from the last row up.
            let mut r0 = [
                u01 + h,
                u02 + h * u12 + half_square,
                u03 + h * u13 + half_square * (u23 - f),
            ];
            let r1 = [u12 + h, u13 + h * (u23 - f)];
            let q = jerk_variance;
            let [mut g0, mut g1, g2] = jerk;

            let e2 = d2 + q * g2 * g2;
            let c1 = (r1[0] * d2 + q * g1 * g2) / e2;
            let c0 = (r0[1] * d2 + q * g0 * g2) / e2;
            let left1 = r1[0] - c1;
            g1 -= c1 * g2;
            r0[1] -= c0;
            g0 -= c0 * g2;

            let e1 = d1 + d2 * left1 * left1 + q * g1 * g1;
            let b0 = (r0[0] * d1 + r0[1] * d2 * left1 + q * g0 * g1) / e1;
            let rest0 = r0[0] - b0;
            let rest1 = r0[1] - b0 * left1;
            g0 -= b0 * g1;
            let e0 = d0 + rest0 * rest0 * d1 + rest1 * rest1 * d2 + q * g0 * g0;
            [b0, c0, r0[2], c1, r1[1], u23, e0, e1, e2]
        };

        // Measurement step (Bierman).
        let mut alpha = params.measurement_variance;
        let v0 = d0;
        alpha += v0;
        let new_d0 = d0 * params.measurement_variance / alpha;
        let mut gain = [v0, S::ZERO, S::ZERO, S::ZERO];

        let v1 = d1 * u01;
        let beta = alpha;
        alpha += v1 * u01;
        let new_d1 = d1 * beta / alpha;
        let new_u01 = u01 - (u01 / beta) * gain[0];
        gain[0] += v1 * u01;
        gain[1] = v1;

        let v2 = d2 * u02;
        let beta = alpha;
        alpha += v2 * u02;
        let new_d2 = d2 * beta / alpha;
        let lambda = -(u02 / beta);
        let new_u02 = u02 + lambda * gain[0];
        let new_u12 = u12 + lambda * gain[1];
        gain[0] += v2 * u02;
        gain[1] += v2 * u12;
        gain[2] = v2;

        let v3 = d3 * u03;
        let beta = alpha;
        alpha += v3 * u03;
        let new_d3 = d3 * beta / alpha;
        let lambda = -(u03 / beta);
        let new_u03 = u03 + lambda * gain[0];
        let new_u13 = u13 + lambda * gain[1];
        let new_u23 = u23 + lambda * gain[2];
        gain[0] += v3 * u03;
        gain[1] += v3 * u13;
        gain[2] += v3 * u23;
        gain[3] = v3;

        let step = innovation / alpha;
        let told = params.mobility;
        let range = S::from_f64(MOBILITY_RANGE);
        let mobility = (before.mobility + gain[3] * step)
            .min(told * range)
            .max(told / range);
        let after = Motion {
            offset: innovation * (gain[0] / alpha - S::ONE),
            velocity: before.velocity + gained + gain[1] * step,
            external: before.external + gain[2] * step,
            mobility,
        };
        let smoothed = Motion {
            offset: before.offset + cross[0] * innovation / expected,
            velocity: before.velocity + cross[1] * innovation / expected,
            external: before.external + cross[2] * innovation / expected,
            mobility,
        };

        let new_d3 = if surprised {
            // The device may have been grabbed or let go.
            let doubt = S::from_f64(DOUBT) * mobility;
            new_d3.max(doubt * doubt)
        } else {
            new_d3
        };
        let ratio = (square / expected).min(S::from_f64(JERK_CAP));
        let factor = (S::from_f64(JERK_GAIN) * (ratio - S::from_f64(JERK_TARGET))).exp();
        let adapted = Self {
            motion: after,
            upper: [
                [new_u01, new_u02, new_u03],
                [S::ZERO, new_u12, new_u13],
                [S::ZERO, S::ZERO, new_u23],
            ],
            diagonal: [new_d0, new_d1, new_d2, new_d3],
            jerk_variance: (jerk_variance * factor)
                .max(params.least_jerk_variance)
                .min(S::from_f64(MOST_JERK * MOST_JERK)),
        };
        if adapted.is_finite() {
            *self = adapted;
            smoothed
        } else {
            *self = Self::new(params);
            self.motion
        }
    }

    /// What the next sample is expected to add to what is known, by the state's covariance C = U D U'
    /// and the transition's first row `(1, row)`.
    #[inline]
    fn foreseen(&self, row: [S; 3], unseen: S) -> Foreseen<S> {
        let [[u01, u02, u03], [_, u12, u13], [_, _, u23]] = self.upper;
        let [d0, d1, d2, d3] = self.diagonal;
        let w1 = u01 + row[0];
        let w2 = u02 + row[0] * u12 + row[1];
        let w3 = u03 + row[0] * u13 + row[1] * u23 + row[2];
        let (v1, v2, v3) = (d1 * w1, d2 * w2, d3 * w3);
        Foreseen {
            variance: d0 + v1 * w1 + v2 * w2 + v3 * w3 + unseen,
            cross: [
                d0 + u01 * v1 + u02 * v2 + u03 * v3,
                v1 + u12 * v2 + u13 * v3,
                v2 + u23 * v3,
            ],
        }
    }

    /// Adds `variance` `[m^2/s^2]` to that of the velocity, by no doing of the other parts of the
    /// state.
    fn kick(&mut self, variance: S) {
        let (u01, d1) = (self.upper[0][0], self.diagonal[1]);
        let kicked = d1 + variance.max(S::ZERO);
        // As long as the position has a variance there is a quotient.
        let left = if kicked > S::ZERO {
            d1 / kicked
        } else {
            S::ONE
        };
        self.upper[0][0] = u01 * left;
        self.diagonal[0] += d1 * u01 * u01 * (S::ONE - left);
        self.diagonal[1] = kicked;
    }

    fn is_finite(&self) -> bool {
        let Motion {
            offset,
            velocity,
            external,
            mobility,
        } = self.motion;
        let mut sum = offset.abs() + velocity.abs() + external.abs() + mobility.abs();
        for row in self.upper {
            for entry in row {
                sum += entry.abs();
            }
        }
        for entry in self.diagonal {
            sum += entry.abs();
        }
        (sum + self.jerk_variance).is_finite()
    }
}
