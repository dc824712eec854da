//! The device observer: a Kalman filter of the device's motion under the forces it is known to
//! have felt.
//!
//! # The model
//!
//! Over one interval the device is a mass m pushed by an acceleration a_u that changes slowly (the
//! user, friction, gravity) and by the force f that is held. What damps it, in the hand or in the
//! device, changes a_u when the velocity changes, at a rate lambda = b/m. Theta = 1/m and lambda are
//! parts of the state:
//!
//! ```text
//! xi+     = xi + u h + (a_u - theta f) h^2/2 + r h^3/6
//! u+      = u + (a_u - theta f) h + r h^2/2
//! a_u+    = a_u + r h + h w     w white, of variance q: the jerk of the hand
//! theta+  = theta
//! lambda+ = lambda              r = -lambda (a_u - theta f), the ramp of a_u
//! ```
//!
//! The force is known, so but for the products with lambda one interval is linear.
//!
//! Its covariance is kept in factors: see [`Covariance`].
//!
//! # What it adapts to
//!
//! - **q** follows the observed innovations: see [`ObserverParams`].
//! - **theta** learns from excitation only. A force that does not change tells nothing that a_u
//!   could not have done as well, and then the variance of theta stays what it is, for hours. A
//!   sample far from what was expected puts theta in doubt again: a hand may have grabbed the device.

use super::covariance::{Covariance, DAMPING_RATE, MOBILITY, PARTS, VELOCITY};
use crate::Scalar;
use crate::actuator::Held;
use crate::contact::Mass;
use crate::parameter::{Parameter, ParameterError};

/// What the observer starts from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ObserverParams<S> {
    /// 1/m as told `[1/kg]`; 0 for a device that no force can move.
    pub mobility: S,
    /// Standard deviation of 1/m to begin with, as a part of it.
    pub mobility_deviation: S,
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
            Mass::Finite(mass) => S::ONE / Parameter::DeviceMass.positive(mass)?,
            Mass::Infinite => S::ZERO,
        };
        let quantum = Parameter::EncoderQuantum
            .not_negative(encoder_quantum)?
            .max(S::from_f64(FINEST_QUANTUM));
        let square = |x: f64| S::from_f64(x * x);
        Ok(Self {
            mobility,
            mobility_deviation: S::from_f64(FIRST_MOBILITY),
            // A position is anywhere within its quantum.
            measurement_variance: quantum * quantum * S::from_f64(1.0 / 12.0),
            jerk_variance: square(FIRST_JERK),
            least_jerk_variance: square(LEAST_JERK),
        })
    }

    /// The same for a device of two masses with a spring between them, which is known from a calibration: so
    /// its mass is known better than within a factor of 2.
    pub fn with_flexure(self) -> Self {
        Self {
            mobility_deviation: S::from_f64(FIRST_MOBILITY_CALIBRATED),
            ..self
        }
    }
}

/// What the sample at an interval's end tells.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Measurement<S> {
    /// By how much the measured position has changed over the interval `[m]`.
    pub moved: S,
    /// Duration of the interval `[s]`.
    pub elapsed: S,
    /// Force on the object that was held; the device felt its opposite.
    pub held: Held<S>,
}

/// The device at a sample, as far as it is known.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EstimatedMotion<S> {
    /// Position, counted from the measured one `[m]`.
    pub offset: S,
    /// Velocity u `[m/s]`.
    pub velocity: S,
    /// Acceleration by everything but the contact, a_u `[m/s^2]`.
    pub external: S,
    /// theta = 1/m `[1/kg]`.
    pub mobility: S,
    /// lambda: damping of hand and device over their mass `[1/s]`.
    pub damping_rate: S,
}

impl<S: Scalar> EstimatedMotion<S> {
    /// Displacement and change of velocity over `h` `[s]` under the force `held` on the object.
    #[inline]
    pub fn under(&self, held: &Held<S>, h: S) -> (S, S) {
        let gained = (self.external - self.mobility * held.mean) * h;
        let ramped = S::HALF * self.ramp(held.mean) * h * h;
        let travel = self.velocity + S::HALF * gained + ramped * S::from_f64(1.0 / 3.0);
        (travel * h - self.mobility * held.lead, gained + ramped)
    }

    /// Rate at which the external acceleration changes under `force` `[N]` on the object `[m/s^3]`.
    #[inline]
    pub fn ramp(&self, force: S) -> S {
        self.damping_rate * (self.mobility * force - self.external)
    }
}

/// What a sample has told of the interval it ends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Update<S> {
    /// By how much the position was another than expected `[m]`.
    pub innovation: S,
    /// Its expected variance `[m^2]`.
    pub variance: S,
    /// Innovation over its variance `[1/m]`.
    pub weight: S,
    /// Covariance at the interval's beginning, before the sample.
    pub before: Covariance<S>,
    /// How position, velocity and external acceleration at the interval's end come from the state
    /// at its beginning.
    pub transition: [[S; PARTS]; 3],
    /// What a unit of innovation adds to the state.
    pub gain: [S; PARTS],
    /// What a unit of jerk does to position, velocity and acceleration.
    pub jerk: [S; 3],
    /// Variance of the jerk `[m^2/s^6]`.
    pub jerk_variance: S,
}

/// The state of the observer. Positions count from the last sample, so that an origin far away
/// costs no digits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Observer<S> {
    /// The device at the last sample.
    pub motion: EstimatedMotion<S>,
    covariance: Covariance<S>,
    /// q `[m^2/s^6]`.
    jerk_variance: S,
}

/// Quantum of a sensor that is not known to have one `[m]`.
const FINEST_QUANTUM: f64 = 1e-9;
/// Standard deviation of a hand's jerk to begin with `[m/s^3]`.
const FIRST_JERK: f64 = 50.0;
/// Standard deviation of the jerk that is always reckoned with `[m/s^3]`.
const LEAST_JERK: f64 = 0.1;
/// Largest standard deviation of the jerk that innovations are put down to `[m/s^3]`. Beyond it the
/// filter would follow every quantum.
const MOST_JERK: f64 = 2e4;
/// Standard deviation of the velocity to begin with `[m/s]`.
const FIRST_SPEED: f64 = 0.1;
/// Standard deviation of the external acceleration to begin with `[m/s^2]`.
const FIRST_ACCELERATION: f64 = 20.0;
/// Standard deviation of 1/m to begin with, as a part of what was told.
const FIRST_MOBILITY: f64 = 0.5;
/// The same of a mass that was calibrated together with a transmission: a hand may hold the device otherwise.
const FIRST_MOBILITY_CALIBRATED: f64 = 0.1;
/// Standard deviation of lambda to begin with `[1/s]`: a hand of some 0.3 kg damps with 1 or 2 N s/m.
const FIRST_DAMPING_RATE: f64 = 4.0;
/// The estimate of lambda stays within this `[1/s]`.
const MOST_DAMPING_RATE: f64 = 100.0;
/// The device is taken for no lighter than this part of what was told,
const LIGHTEST: f64 = 0.05;
/// and for no heavier than this multiple of it: a device may be clamped.
const HEAVIEST: f64 = 1e3;
/// Innovations whose square is beyond this multiple of what is expected put the mass in doubt.
const SURPRISE: f64 = 25.0;
/// Square of the standard deviations that are left of a surprise when a kick has been reckoned with.
const EXPLAINED: f64 = 4.0;
/// Largest standard deviation of a mobility in doubt, as a part of it.
const DOUBT: f64 = 0.25;
/// How fast the jerk's variance follows the innovations, per sample.
const JERK_GAIN: f64 = 0.2;
/// Innovation variances beyond this multiple of the expected one count as this.
const JERK_CAP: f64 = 9.0;

/// The part by which a kick of `kicked` `[m/s]` changes a velocity of `speed` `[m/s]`: [`DOUBT`] at most. A surprise is
/// rare: as a call of its own it takes no stack of every tick.
#[cold]
#[inline(never)]
fn part_kicked<S: Scalar>(kicked: S, speed: S) -> S {
    let most = S::from_f64(DOUBT);
    if kicked < most * speed {
        kicked / speed
    } else {
        most
    }
}

impl<S: Scalar> Observer<S> {
    pub fn new(params: &ObserverParams<S>) -> Self {
        let square = |x: f64| S::from_f64(x * x);
        let mobility = params.mobility;
        Self {
            motion: EstimatedMotion {
                offset: S::ZERO,
                velocity: S::ZERO,
                external: S::ZERO,
                mobility,
                damping_rate: S::ZERO,
            },
            covariance: Covariance {
                upper: [[S::ZERO; PARTS - 1]; PARTS - 1],
                diagonal: [
                    params.measurement_variance,
                    square(FIRST_SPEED),
                    square(FIRST_ACCELERATION),
                    params.mobility_deviation * params.mobility_deviation * mobility * mobility,
                    square(FIRST_DAMPING_RATE),
                ],
            },
            jerk_variance: params.jerk_variance,
        }
    }

    /// Takes the sample at the end of an interval. Returns the device at the interval's beginning as
    /// the sample makes it look now (the one-step smoothed state, but for theta and lambda, which are
    /// the same at both ends), and what else it tells: nothing, where its numbers overflow and it
    /// begins anew. `measurement_variance`: of the sample's position, not below the one that is told `[m^2]`.
    // A function of its own wherever a tick is compiled: it needs most of the registers, and a tick around it more.
    #[inline(never)]
    pub fn update(
        &mut self,
        params: &ObserverParams<S>,
        measurement: &Measurement<S>,
        measurement_variance: S,
    ) -> (EstimatedMotion<S>, Option<Update<S>>) {
        let Measurement {
            moved,
            elapsed: h,
            held,
        } = *measurement;
        let f = held.mean;
        let before = self.motion;
        let (travel, gained) = before.under(&held, h);
        let innovation = moved - (before.offset + travel);

        let half = S::HALF * h * h;
        let sixth = half * h * S::from_f64(1.0 / 3.0);
        let jerk = [sixth, half, h];
        let q = self.jerk_variance;
        // Of the ramp by a_u, theta and lambda.
        let by_a = -before.damping_rate;
        let by_theta = before.damping_rate * f;
        let by_lambda = before.mobility * f - before.external;
        let (o, l) = (S::ZERO, S::ONE);
        let transition = [
            [
                l,
                h,
                half + sixth * by_a,
                sixth * by_theta - half * f - held.lead,
                sixth * by_lambda,
            ],
            [
                o,
                l,
                h + half * by_a,
                half * by_theta - h * f,
                half * by_lambda,
            ],
            [o, o, l + h * by_a, h * by_theta, h * by_lambda],
        ];
        // What is not known of the force that was held: a kick that is not there, or is there twice.
        let kicked = before.mobility * held.impulse_deviation * h;
        let measurement_variance = measurement_variance + kicked * kicked;
        let unseen = measurement_variance + q * sixth * sixth;
        let mut covariance = self.covariance;
        let mut expected = covariance.expected_innovation(&transition[0], unseen);
        let square = innovation * innovation;
        let surprised = square > S::from_f64(SURPRISE) * expected.variance;
        if surprised {
            // Nothing the filter reckons with: something kicked the device, or it was grabbed. Let
            // the kick come first in the interval, which makes the velocity that of the last step.
            let kick = square / S::from_f64(EXPLAINED) - expected.variance;
            covariance.widen(VELOCITY, kick / (h * h));
            expected = covariance.expected_innovation(&transition[0], unseen);
        }
        let (mut known, gain) = covariance
            .stepped(&transition, &expected.row, jerk, q)
            .measured(measurement_variance);

        let within = |x: S, least: S, most: S| x.min(most).max(least);
        let told = params.mobility;
        let mobility = within(
            before.mobility + gain[3] * innovation,
            told / S::from_f64(HEAVIEST),
            told / S::from_f64(LIGHTEST),
        );
        let most = S::from_f64(MOST_DAMPING_RATE);
        let damping_rate = within(before.damping_rate + gain[4] * innovation, -most, most);
        if surprised {
            // The device may have been grabbed or let go. That part of its mass which came or went changes the
            // velocity, and what a force does to it, by the same part. A kick that is small against both is of
            // friction or of a hand, and says as little of the mass.
            let speed = before.velocity.abs() + S::HALF * h * mobility * f.abs();
            let deviation = part_kicked(innovation.abs() / h, speed) * mobility;
            let u = known.upper[MOBILITY][DAMPING_RATE - 1];
            let has = known.diagonal[MOBILITY] + u * u * known.diagonal[DAMPING_RATE];
            known.widen(MOBILITY, deviation * deviation - has);
        }
        let weight = innovation / expected.variance;
        let smoothed = EstimatedMotion {
            offset: before.offset + expected.cross[0] * weight,
            velocity: before.velocity + expected.cross[1] * weight,
            external: before.external + expected.cross[2] * weight,
            mobility,
            damping_rate,
        };
        let ratio = (square / expected.variance).min(S::from_f64(JERK_CAP));
        let factor = (S::from_f64(JERK_GAIN) * (ratio - S::ONE)).exp();
        let adapted = Self {
            motion: EstimatedMotion {
                offset: innovation * (gain[0] - S::ONE),
                velocity: before.velocity + gained + gain[1] * innovation,
                external: before.external + before.ramp(f) * h + gain[2] * innovation,
                mobility,
                damping_rate,
            },
            covariance: known,
            jerk_variance: within(
                q * factor,
                params.least_jerk_variance,
                S::from_f64(MOST_JERK * MOST_JERK),
            ),
        };
        if !adapted.is_finite() {
            *self = Self::new(params);
            return (self.motion, None);
        }
        let update = Update {
            innovation,
            variance: expected.variance,
            weight,
            before: covariance,
            transition,
            gain,
            jerk,
            jerk_variance: q,
        };
        *self = adapted;
        (smoothed, Some(update))
    }

    /// Changes the motion by what was learned beside it.
    pub fn shift(&mut self, by: [S; PARTS]) {
        let [offset, velocity, external, ..] = by;
        self.motion.offset += offset;
        self.motion.velocity += velocity;
        self.motion.external += external;
    }

    /// How certain lambda is: 1 where it is known, 0 where it cannot be told from none. A damping that is
    /// only an error of the mass weighs next to nothing by it.
    pub fn damping_certainty(&self) -> S {
        let square = self.motion.damping_rate * self.motion.damping_rate;
        let sum = square + self.covariance.diagonal[DAMPING_RATE];
        if sum > S::ZERO { square / sum } else { S::ZERO }
    }

    fn is_finite(&self) -> bool {
        let EstimatedMotion {
            offset,
            velocity,
            external,
            mobility,
            damping_rate,
        } = self.motion;
        let mut sum =
            offset.abs() + velocity.abs() + external.abs() + mobility.abs() + damping_rate.abs();
        for row in self.covariance.upper {
            for entry in row {
                sum += entry.abs();
            }
        }
        for entry in self.covariance.diagonal {
            sum += entry.abs();
        }
        (sum + self.jerk_variance).is_finite()
    }
}
