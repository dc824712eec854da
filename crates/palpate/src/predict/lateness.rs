//! By how much later than told the commands of a loop begin.

use super::covariance::PARTS;
use super::observer::{EstimatedMotion, Update};
use crate::Scalar;
use crate::actuator::Held;

/// A delay that was told with a standard deviation, learned from contact.
///
/// A force that changes by f, later than expected by d, pushes the device by f d more than expected. A
/// Kalman filter of this one number beside that of the device's state learns d from the innovations
/// (Friedland, "Treatment of bias in recursive filtering", IEEE Trans. Automatic Control 14(4), 1969):
/// `answer` says how the error of the state answers to a second of lateness, through all that the
/// observer has made of it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Lateness<S> {
    /// The lateness to use `[s]`: negative if commands begin earlier than modelled, 0 while the estimate is not significant.
    pub mean: S,
    /// Best guess, significant or not `[s]`.
    guess: S,
    /// Its variance `[s^2]`; none before the first sample.
    variance: Option<S>,
    answer: [S; PARTS],
}

/// By how much the deviation grows with every sample, in periods, up to what was told: a mass that is still
/// to be learned looks like lateness at first.
const DRIFT: f64 = 0.0003;
/// Standard deviation of the displacement by a held force that no lateness explains, as a part of that displacement
/// doubled: gain, hand and friction. Without it a contact at rest, whose force hardly changes, teaches a wrong lateness.
const UNSURE: f64 = 0.005;
/// The guess is used when it exceeds so many of its standard deviations.
const DOUBTS: f64 = 3.0;
/// The guess stays within so many of the deviations that were told.
const MOST: f64 = 4.0;

impl<S: Scalar> Lateness<S> {
    /// Takes what a sample tells, with the device's motion at the beginning of the interval of `h` `[s]`
    /// that it ends. `told`: standard deviation of the delay as told, above 0 `[s]`. The change of the
    /// device's state at the sample that follows from what was learned.
    pub fn learn(
        &mut self,
        update: &Update<S>,
        device: &EstimatedMotion<S>,
        held: &Held<S>,
        h: S,
        told: S,
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
        // An unknown part of the force looks like lateness, too.
        let unsure = S::from_f64(UNSURE) * device.mobility * held.mean * h * h;
        let variance = self.variance.unwrap_or(told * told);
        let gain = variance * seen / (seen * seen * variance + update.variance + unsure * unsure);
        let drift = S::from_f64(DRIFT) * h;
        let left = (S::ONE - gain * seen) * variance + drift * drift;
        for (entry, by) in answer.iter_mut().zip(&update.gain) {
            *entry -= *by * seen;
        }
        let most = S::from_f64(MOST) * told;
        // The innovation is against what is applied, not against the guess.
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
        self.variance = Some(left.min(told * told));
        self.answer = answer;
        answer.map(|entry| entry * learned)
    }

    /// Remaining standard deviation as a part of the modelled one, above 0 `[s]`: 1 at first.
    pub fn remaining(&self, told: S) -> S {
        self.variance.map_or(S::ONE, |left| left.sqrt() / told)
    }

    /// The device was lost: what its state answers with is not known any more.
    pub fn begin_anew(&mut self) {
        self.answer = [S::ZERO; PARTS];
    }
}
