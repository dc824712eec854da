//! Motor with amplifier: from the commanded torque to the produced one.

use palpate_testbed::InvalidParameter;
use palpate_testbed::actuator::{Actuator, ActuatorParams};

/// Longest step over which a settling torque is replaced by its mean, in lags.
const STEP_IN_LAGS: f64 = 0.25;

/// A motor: y' = (g u - y) / lag, with the commanded torque u.
#[derive(Clone, Copy, Debug)]
pub struct Motor {
    params: ActuatorParams,
    /// Commanded torque `[N m]`.
    pub messages: f64,
    /// Produced torque `[N m]`.
    given: f64,
}

impl Motor {
    /// Creates a motor with zero torque.
    pub fn new(params: ActuatorParams) -> Result<Self, InvalidParameter> {
        let params = Actuator::new(params)?.params();
        Ok(Self {
            params,
            messages: 0.0,
            given: 0.0,
        })
    }

    /// Returns the longest step for which [`mean_over`](Self::mean_over) is accurate `[s]`.
    pub fn longest_step(&self) -> f64 {
        if self.params.lag > 0.0 {
            // A lag below a microsecond has no effect on an arm.
            (STEP_IN_LAGS * self.params.lag).max(2.5e-7)
        } else {
            f64::INFINITY
        }
    }

    /// Advances by `step` `[s]` and returns the mean torque over the step `[N m]`.
    pub fn mean_over(&mut self, step: f64) -> f64 {
        let ActuatorParams { gain, lag } = self.params;
        let aim = gain * self.messages;
        if lag <= 0.0 {
            self.given = aim;
            return aim;
        }
        let excess = self.given - aim;
        let settled = -(-step / lag).exp_m1();
        self.given = aim + excess * (1.0 - settled);
        aim + excess * settled * lag / step
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_torque_settles_with_its_lag_and_by_its_gain() {
        let params = ActuatorParams {
            gain: 0.9,
            lag: 1e-3,
        };
        let mut motor = Motor::new(params).unwrap();
        motor.messages = 0.1;
        let mut impulse = 0.0;
        for _ in 0..10 {
            impulse += motor.mean_over(1e-4) * 1e-4;
        }
        let kept = (-1.0_f64).exp();
        assert!((motor.given - 0.09 * (1.0 - kept)).abs() < 1e-15);
        assert!((impulse - 0.09 * (1e-3 - 1e-3 * (1.0 - kept))).abs() < 1e-15);
    }

    #[test]
    fn a_gain_or_a_lag_that_no_motor_has_is_named() {
        for (gain, lag, name) in [(0.0, 0.0, "gain"), (1.0, -1e-3, "lag")] {
            let error = Motor::new(ActuatorParams { gain, lag }).unwrap_err();
            assert!(error.to_string().contains(name), "{error}");
        }
    }
}
