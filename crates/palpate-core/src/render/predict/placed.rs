//! Uncertainty of the position of an object that is placed relative to the device.
//!
//! During contact, the object is placed relative to the current estimate of the device. Its position is exact; whether
//! it belongs there is uncertain. That error is correlated with the errors in the device's motion: a device that was
//! faster than estimated has reached the object earlier, and both should separate faster. Later samples that improve
//! the velocity estimate therefore also improve the object's position. This is smoothing of a past collision, in the
//! form of the covariance of a Kalman filter of device and object together.

use super::covariance::PARTS;
use super::observer::{EstimatedMotion, Update};
use crate::Scalar;
use crate::response::Response;

/// Covariance of the errors of the object's position and velocity with those of the device's motion: zero, the default,
/// if the object's position is exact by definition.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Placed<S>([[S; PARTS]; 2]);

impl<S: Scalar> Placed<S> {
    /// Returns the corrections of the object's position `[m]` and velocity `[m/s]` at the beginning of the interval.
    #[inline]
    pub fn correction(&self, update: &Update<S>) -> [S; 2] {
        self.0.map(|row| {
            let mut sum = S::ZERO;
            for (entry, by) in row.into_iter().zip(update.transition[0]) {
                sum += entry * by;
            }
            sum * update.weight
        })
    }

    /// Returns the covariance at the end of the interval, after the sample that ends it. `device`: its motion at the
    /// beginning, `touched`: whether there was contact or a force.
    pub fn after(
        &self,
        update: &Update<S>,
        device: &EstimatedMotion<S>,
        response: &Response<S>,
        touched: bool,
        held_force: S,
    ) -> Self {
        let exact = self.0.iter().flatten().all(|entry| *entry == S::ZERO);
        if exact && !touched {
            return *self;
        }
        let ramp = response.ramp;
        let by = [
            -device.damping_rate,
            device.damping_rate * held_force,
            device.mobility * held_force - device.external,
        ];
        let before = if touched {
            update.before.dense()
        } else {
            [[S::ZERO; PARTS]; PARTS]
        };
        let mut after = [[S::ZERO; PARTS]; 2];
        for (i, answer) in [response.penetration, response.speed].iter().enumerate() {
            // The relative motion at the end follows from device and object at the beginning; the object is the device
            // minus the relative motion.
            let own = update.transition[i];
            let unlike = [
                own[0] - answer[0],
                own[1] - answer[1],
                own[2] - (answer[2] + ramp[i] * by[0]),
                own[3] - (answer[3] + ramp[i] * by[1]),
                own[4] - ramp[i] * by[2],
            ];
            let mut row = [S::ZERO; PARTS];
            for (j, entry) in row.iter_mut().enumerate() {
                *entry = answer[0] * self.0[0][j] + answer[1] * self.0[1][j];
                if touched {
                    for (k, difference) in unlike.iter().enumerate() {
                        *entry += *difference * before[k][j];
                    }
                }
            }
            let jerked = (update.jerk[i] - ramp[i]) * update.jerk_variance;
            let mut next = row;
            for (j, transition) in update.transition.iter().enumerate() {
                next[j] = jerked * update.jerk[j];
                for (entry, by) in row.into_iter().zip(*transition) {
                    next[j] += entry * by;
                }
            }
            let seen = next[0];
            for (entry, gain) in next.iter_mut().zip(update.gain) {
                *entry -= seen * gain;
            }
            after[i] = next;
        }
        Self(after)
    }
}
