//! Device observer: a Kalman filter of the device's motion under the known forces.
//!
//! # The model
//!
//! Over one interval the device is a mass m with an acceleration a_u that changes slowly (the user, friction, gravity)
//! and the held force f. Damping, in the hand or in the device, changes a_u with the velocity at a rate lambda = b/m.
//! Theta = 1/m and lambda are parts of the state:
//!
//! ```text
//! xi+     = xi + u h + (a_u - theta f) h^2/2 + r h^3/6
//! u+      = u + (a_u - theta f) h + r h^2/2
//! a_u+    = a_u + r h + h w     w white, of variance q: the jerk of the hand
//! theta+  = theta
//! lambda+ = lambda              r = -lambda (a_u - theta f), the ramp of a_u
//! ```
//!
//! The force is known, so one interval is linear except for the products with lambda.
//!
//! The covariance is factorised: see [`Covariance`].
//!
//! # Adaptation
//!
//! - **q** follows the observed innovations: see [`ObserverParams`].
//! - **theta** is estimated from excitation only. The effect of a constant force cannot be distinguished from that of
//!   a_u; the variance of theta then stays constant, for hours. A sample far from the expected one widens the variance
//!   of theta: a hand may have grabbed the device.

use super::covariance::{Covariance, DAMPING_RATE, ExpectedInnovation, MOBILITY, PARTS, VELOCITY};
use crate::Scalar;
use crate::actuator::Held;
use crate::contact::Mass;
use crate::parameter::{Parameter, ParameterError};

/// Initial values of the observer.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ObserverParams<S> {
    /// Model value of 1/m `[1/kg]`; 0 for a device that no force can move.
    pub mobility: S,
    /// Initial standard deviation of 1/m, relative to it.
    pub mobility_deviation: S,
    /// Variance of a measured position `[m^2]`.
    pub measurement_variance: S,
    /// Initial variance of the jerk `[m^2/s^6]`.
    pub jerk_variance: S,
    /// Minimum variance of the jerk `[m^2/s^6]`.
    pub least_jerk_variance: S,
}

impl<S: Scalar> ObserverParams<S> {
    /// Creates parameters from the device's effective mass within a factor of 2 `[kg]`, and the sensor's quantum `[m]`,
    /// 0 if it has no known quantum.
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
            // The error is uniform within the quantum.
            measurement_variance: quantum * quantum * S::from_f64(1.0 / 12.0),
            jerk_variance: square(FIRST_JERK),
            least_jerk_variance: square(MIN_JERK),
        })
    }

    /// Returns parameters for a device of two masses and a spring, known from a calibration. Its mass is known better
    /// than within a factor of 2.
    pub fn with_flexure(self) -> Self {
        Self {
            mobility_deviation: S::from_f64(FIRST_MOBILITY_CALIBRATED),
            ..self
        }
    }
}

/// Measurement at the end of an interval.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Measurement<S> {
    /// Change of the measured position over the interval `[m]`.
    pub moved: S,
    /// Duration of the interval `[s]`.
    pub elapsed: S,
    /// Held force on the object; the device felt the opposite force.
    pub held: Held<S>,
}

/// Estimated motion of the device at a sample.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EstimatedMotion<S> {
    /// Position relative to the measured one `[m]`.
    pub offset: S,
    /// Velocity u `[m/s]`.
    pub velocity: S,
    /// Acceleration a_u by everything except the contact `[m/s^2]`.
    pub external: S,
    /// theta = 1/m `[1/kg]`.
    pub mobility: S,
    /// lambda: damping of hand and device divided by their mass `[1/s]`.
    pub damping_rate: S,
}

impl<S: Scalar> EstimatedMotion<S> {
    /// Returns the displacement and velocity change over `h` `[s]` under the force `held` on the object.
    #[inline]
    pub fn under(&self, held: &Held<S>, h: S) -> (S, S) {
        let gained = (self.external - self.mobility * held.mean) * h;
        let ramped = S::HALF * self.ramp(held.mean) * h * h;
        let travel = self.velocity + S::HALF * gained + ramped * S::from_f64(1.0 / 3.0);
        (travel * h - self.mobility * held.lead, gained + ramped)
    }

    /// Returns the rate of change of the external acceleration under `force` `[N]` on the object `[m/s^3]`.
    #[inline]
    pub fn ramp(&self, force: S) -> S {
        self.damping_rate * (self.mobility * force - self.external)
    }

    /// Returns the transition of the state to position, velocity and external acceleration at the end of an interval
    /// under the force `held` on the object. `jerk`: effect of a unit of jerk on these three.
    #[inline(always)]
    fn transition(&self, held: &Held<S>, jerk: [S; 3]) -> [[S; PARTS]; 3] {
        let f = held.mean;
        let [sixth, half, h] = jerk;
        // Factors of a_u, theta and lambda in the ramp.
        let by_a = -self.damping_rate;
        let by_theta = self.damping_rate * f;
        let by_lambda = self.mobility * f - self.external;
        let (o, l) = (S::ZERO, S::ONE);
        [
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
        ]
    }

    /// Returns theta and lambda after an innovation `[m]`, each within its limits. `gain`: change of the state per unit
    /// of innovation.
    #[inline(always)]
    fn mobility_and_damping(
        &self,
        params: &ObserverParams<S>,
        gain: &[S; PARTS],
        innovation: S,
    ) -> (S, S) {
        let model = params.mobility;
        let mobility = within(
            self.mobility + gain[3] * innovation,
            model / S::from_f64(HEAVIEST),
            model / S::from_f64(LIGHTEST),
        );
        let most = S::from_f64(MAX_DAMPING_RATE);
        let damping_rate = within(self.damping_rate + gain[4] * innovation, -most, most);
        (mobility, damping_rate)
    }
}

/// Result of a measurement update.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Update<S> {
    /// Measured minus expected position `[m]`.
    pub innovation: S,
    /// Its expected variance `[m^2]`.
    pub variance: S,
    /// Innovation divided by its variance `[1/m]`.
    pub weight: S,
    /// Covariance at the interval's beginning, before the update.
    pub before: Covariance<S>,
    /// Transition from the state at the interval's beginning to position, velocity and external acceleration at its
    /// end.
    pub transition: [[S; PARTS]; 3],
    /// Change of the state per unit of innovation.
    pub gain: [S; PARTS],
    /// Effect of a unit of jerk on position, velocity and acceleration.
    pub jerk: [S; 3],
    /// Variance of the jerk `[m^2/s^6]`.
    pub jerk_variance: S,
}

/// State of the observer. Positions are relative to the last sample, so that a distant origin costs no precision.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Observer<S> {
    /// Device motion at the last sample.
    pub motion: EstimatedMotion<S>,
    covariance: Covariance<S>,
    /// q `[m^2/s^6]`.
    jerk_variance: S,
}

/// Quantum of a sensor without a known quantum `[m]`.
const FINEST_QUANTUM: f64 = 1e-9;
/// Initial standard deviation of a hand's jerk `[m/s^3]`.
const FIRST_JERK: f64 = 50.0;
/// Minimum standard deviation of the jerk `[m/s^3]`.
const MIN_JERK: f64 = 0.1;
/// Maximum standard deviation of the jerk inferred from innovations `[m/s^3]`. Above it the filter would follow every
/// quantum.
const MAX_JERK: f64 = 2e4;
/// Initial standard deviation of the velocity `[m/s]`.
const FIRST_SPEED: f64 = 0.1;
/// Initial standard deviation of the external acceleration `[m/s^2]`.
const FIRST_ACCELERATION: f64 = 20.0;
/// Initial standard deviation of 1/m, relative to its model value.
const FIRST_MOBILITY: f64 = 0.5;
/// The same for a mass that was calibrated together with a transmission: a hand may hold the device differently.
const FIRST_MOBILITY_CALIBRATED: f64 = 0.1;
/// Initial standard deviation of lambda `[1/s]`: a hand of about 0.3 kg has a damping of 1 or 2 N s/m.
const FIRST_DAMPING_RATE: f64 = 4.0;
/// Limit of the estimate of lambda `[1/s]`.
const MAX_DAMPING_RATE: f64 = 100.0;
/// Lower limit of the estimated mass, relative to the model value.
const LIGHTEST: f64 = 0.05;
/// Upper limit of the estimated mass, relative to the model value: a device may be clamped.
const HEAVIEST: f64 = 1e3;
/// A squared innovation above this multiple of its expected variance widens the variance of the mass.
const SURPRISE: f64 = 25.0;
/// Squared innovation that remains after allowing for a kick, in units of its variance.
const EXPLAINED: f64 = 4.0;
/// Largest standard deviation of a widened mobility, relative to it.
const DOUBT: f64 = 0.25;
/// Adaptation rate of the jerk's variance to the innovations, per sample.
const JERK_GAIN: f64 = 0.2;
/// Limit of a squared innovation, in units of its expected variance.
const JERK_CAP: f64 = 9.0;

/// Returns the fraction by which a kick of `kicked` `[m/s]` changes a velocity of `speed` `[m/s]`, at most [`DOUBT`].
/// Not inlined: a surprise is rare, and its stack must not burden every tick.
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

/// Returns the expected innovation of a sample, and whether the squared innovation `square` `[m^2]` is outside the
/// model. In that case widens the variance of the velocity first. `first` and `unseen`: see
/// [`Covariance::expected_innovation`]. `h`: duration of the interval `[s]`.
#[inline(always)]
fn explain_innovation<S: Scalar>(
    covariance: &mut Covariance<S>,
    first: &[S; PARTS],
    unseen: S,
    square: S,
    h: S,
) -> (ExpectedInnovation<S>, bool) {
    let mut expected = covariance.expected_innovation(first, unseen);
    let surprised = square > S::from_f64(SURPRISE) * expected.variance;
    if surprised {
        // Outside the model: the device was kicked or grabbed. Assume the kick at the beginning of the interval, so
        // that the velocity is that of the last step.
        let kick = square / S::from_f64(EXPLAINED) - expected.variance;
        covariance.widen(VELOCITY, kick / (h * h));
        expected = covariance.expected_innovation(first, unseen);
    }
    (expected, surprised)
}

/// Raises the variance of theta to the square of `deviation` `[1/kg]`, if it is lower.
#[inline(always)]
fn widen_mobility<S: Scalar>(covariance: &mut Covariance<S>, deviation: S) {
    let u = covariance.upper[MOBILITY][DAMPING_RATE - 1];
    let has = covariance.diagonal[MOBILITY] + u * u * covariance.diagonal[DAMPING_RATE];
    covariance.widen(MOBILITY, deviation * deviation - has);
}

/// Returns the next variance of the jerk `[m^2/s^6]` from the present one, `q`, and the squared innovation divided by
/// its expected variance.
#[inline(always)]
fn adapted_jerk_variance<S: Scalar>(params: &ObserverParams<S>, q: S, ratio: S) -> S {
    let ratio = ratio.min(S::from_f64(JERK_CAP));
    let factor = (S::from_f64(JERK_GAIN) * (ratio - S::ONE)).exp();
    within(
        q * factor,
        params.least_jerk_variance,
        S::from_f64(MAX_JERK * MAX_JERK),
    )
}

/// Returns `x` limited to the range from `least` to `most`.
#[inline(always)]
fn within<S: Scalar>(x: S, least: S, most: S) -> S {
    x.min(most).max(least)
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

    /// Processes the sample at the end of an interval. Returns the device motion at the interval's beginning given this
    /// sample (the one-step smoothed state; theta and lambda are the same at both ends) and the details of the update,
    /// or `None` if numbers overflow and the observer restarts. `measurement_variance`: variance of the sample's
    /// position, not below the model value `[m^2]`.
    // Not inlined: it needs most of the registers, and the surrounding tick needs more.
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
        let transition = before.transition(&held, jerk);
        // Uncertainty of the held force: a kick that is missing or occurs twice.
        let kicked = before.mobility * held.impulse_deviation * h;
        let measurement_variance = measurement_variance + kicked * kicked;
        let unseen = measurement_variance + q * sixth * sixth;
        let mut covariance = self.covariance;
        let square = innovation * innovation;
        let (expected, surprised) =
            explain_innovation(&mut covariance, &transition[0], unseen, square, h);
        let (mut known, gain) = covariance
            .stepped(&transition, &expected.row, jerk, q)
            .measured(measurement_variance);

        let (mobility, damping_rate) = before.mobility_and_damping(params, &gain, innovation);
        if surprised {
            // The device may have been grabbed or released. A change of its mass changes the velocity, and the effect
            // of a force, by the same factor. A kick that is small against both comes from friction or a hand and gives
            // no information on the mass.
            let speed = before.velocity.abs() + S::HALF * h * mobility * f.abs();
            let deviation = part_kicked(innovation.abs() / h, speed) * mobility;
            widen_mobility(&mut known, deviation);
        }
        let weight = innovation / expected.variance;
        let smoothed = EstimatedMotion {
            offset: before.offset + expected.cross[0] * weight,
            velocity: before.velocity + expected.cross[1] * weight,
            external: before.external + expected.cross[2] * weight,
            mobility,
            damping_rate,
        };
        let adapted = Self {
            motion: EstimatedMotion {
                offset: innovation * (gain[0] - S::ONE),
                velocity: before.velocity + gained + gain[1] * innovation,
                external: before.external + before.ramp(f) * h + gain[2] * innovation,
                mobility,
                damping_rate,
            },
            covariance: known,
            jerk_variance: adapted_jerk_variance(params, q, square / expected.variance),
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

    /// Adds a correction to the motion.
    pub fn shift(&mut self, by: [S; PARTS]) {
        let [offset, velocity, external, ..] = by;
        self.motion.offset += offset;
        self.motion.velocity += velocity;
        self.motion.external += external;
    }

    /// Returns the certainty of lambda: 1 if it is known, 0 if it is not significantly different from zero. A damping
    /// that is only an error of the mass then has almost no weight.
    pub fn damping_certainty(&self) -> S {
        let square = self.motion.damping_rate * self.motion.damping_rate;
        let sum = square + self.covariance.diagonal[DAMPING_RATE];
        if sum > S::ZERO { square / sum } else { S::ZERO }
    }

    /// Returns the variance of a quantity with these derivatives by the state, at the last sample.
    pub fn variance_of(&self, by: &[S; PARTS]) -> S {
        self.covariance.of_sum(by)
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
