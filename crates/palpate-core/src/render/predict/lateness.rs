//! Estimate of the actuation delay beyond its model value.

use super::covariance::PARTS;
use super::observer::{EstimatedMotion, Update};
use crate::Scalar;
use crate::actuator::Held;

/// Error of a model delay with a standard deviation, estimated from contact.
///
/// A force that changes by f, later than expected by d, pushes the device by f d more than expected. A Kalman filter of
/// this one number beside that of the device's state estimates d from the innovations (Friedland, "Treatment of bias in
/// recursive filtering", IEEE Trans. Automatic Control 14(4), 1969): `answer` is the sensitivity of the state's error
/// to the lateness, including all updates of the observer.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Lateness<S> {
    /// Lateness to use `[s]`: negative if commands begin earlier than modelled, 0 while the estimate is not
    /// significant.
    pub mean: S,
    /// Best estimate, significant or not `[s]`.
    guess: S,
    /// Its variance `[s^2]`; `None` before the first sample.
    variance: Option<S>,
    answer: [S; PARTS],
}

/// Growth of the deviation per sample, in periods, up to the model value: an unknown mass initially looks like
/// lateness.
const DRIFT: f64 = 0.0003;
/// Standard deviation of the displacement by a held force that lateness does not explain, relative to twice that
/// displacement: gain, hand and friction. Without it a contact at rest, whose force hardly changes, gives a wrong
/// estimate.
const UNSURE: f64 = 0.005;
/// The estimate is used if it exceeds this number of its standard deviations.
const DOUBTS: f64 = 3.0;
/// Limit of the estimate, in model standard deviations.
const MOST: f64 = 4.0;

impl<S: Scalar> Lateness<S> {
    /// Processes a sample, with the device's motion at the beginning of the interval of `h` `[s]` that it ends.
    /// `model`: model standard deviation of the delay, above 0 `[s]`. Returns the change of the device's state at the
    /// sample that follows from the new estimate.
    pub fn learn(
        &mut self,
        update: &Update<S>,
        device: &EstimatedMotion<S>,
        held: &Held<S>,
        h: S,
        model: S,
    ) -> [S; PARTS] {
        let mut answer = self.answer;
        for (entry, row) in answer.iter_mut().zip(&update.transition) {
            *entry = S::ZERO;
            for (by, from) in row.iter().zip(&self.answer) {
                *entry += *by * *from;
            }
        }
        let pushed = device.mobility * held.step;
        answer[0] += device.mobility * held.step_moment;
        answer[1] += pushed;
        let seen = answer[0];
        // An unknown part of the force also looks like lateness.
        let unsure = S::from_f64(UNSURE) * device.mobility * held.mean * h * h;
        let variance = self.variance.unwrap_or(model * model);
        let gain = variance * seen / (seen * seen * variance + update.variance + unsure * unsure);
        let drift = S::from_f64(DRIFT) * h;
        let left = (S::ONE - gain * seen) * variance + drift * drift;
        for (entry, by) in answer.iter_mut().zip(&update.gain) {
            *entry -= *by * seen;
        }
        let most = S::from_f64(MOST) * model;
        // The innovation is relative to the lateness in use, not to the best estimate.
        let surprise = update.innovation - seen * (self.guess - self.mean);
        let guess = (self.guess + gain * surprise).within(most);
        let doubt = S::from_f64(DOUBTS * DOUBTS) * left;
        let mean = if guess * guess > doubt {
            guess
        } else {
            S::ZERO
        };
        let learned = mean - self.mean;
        let mut sum = guess.abs() + left;
        for entry in answer {
            sum += entry.abs();
        }
        if !sum.is_finite() {
            *self = Self::default();
            return [S::ZERO; PARTS];
        }
        self.mean = mean;
        self.guess = guess;
        self.variance = Some(left.min(model * model));
        self.answer = answer;
        answer.map(|entry| entry * learned)
    }

    /// Returns the remaining standard deviation relative to the model value `model`, above 0 `[s]`: 1 at first.
    pub fn remaining(&self, model: S) -> S {
        self.variance.map_or(S::ONE, |left| left.sqrt() / model)
    }

    /// Clears the sensitivity, because the device was lost.
    pub fn begin_anew(&mut self) {
        self.answer = [S::ZERO; PARTS];
    }
}
