//! The way of a command to the device: a delay of any number of periods, and the actuator's lag.

use palpate::Method;
use palpate_scene::Delay;
use palpate_sim::sampled_loop::{LoopDevice, SampledLoop};
use palpate_testbed::InvalidParameter;
use palpate_testbed::actuator::{Actuator, ActuatorParams};
use palpate_testbed::hold::DelayedHold;

use super::bounce::Bounce;

/// The way of a command to the device of a bounce.
#[derive(Clone, Debug)]
pub(super) struct Way {
    hold: DelayedHold,
    /// Part of a period by which commands come later than whole samples.
    fraction: f64,
    /// The command that acts until the next one comes `[N]`.
    before: f64,
    actuator: Actuator,
}

impl Way {
    /// The way of `bounce`, on which no command is yet.
    pub fn of(bounce: &Bounce) -> Result<Self, InvalidParameter> {
        let delay = Delay::of_periods(bounce.delay);
        Ok(Self {
            hold: DelayedHold::new(delay.whole_samples())?,
            fraction: delay.fraction(),
            before: 0.0,
            actuator: Actuator::new(ActuatorParams {
                lag: bounce.lag,
                ..ActuatorParams::default()
            })?,
        })
    }

    /// What lies between a command that has come and the device.
    pub fn actuator(&self) -> Actuator {
        self.actuator
    }

    /// Sends `command` and lets a period pass; the mean force on the object in it `[N]`.
    #[inline]
    pub fn drive<M: Method<f64>, D: LoopDevice>(
        &mut self,
        in_progress: &mut SampledLoop<'_, M, D>,
        command: f64,
        period: f64,
    ) -> f64 {
        if self.fraction == 0.0 && self.actuator.params().lag == 0.0 {
            // One force over the whole period, which the renderer is told.
            let held = in_progress.given_force(self.hold.exchange(command));
            in_progress.report_held(held);
            in_progress.advance(held, period);
            return held;
        }
        let sent = in_progress.given_force(command);
        in_progress.report_sent(sent);
        let next = self.hold.exchange(sent);
        let (early, late) = (self.fraction, 1.0 - self.fraction);
        let of_before = in_progress.drive(self.before, early * period).mean_force;
        let of_next = in_progress.drive(next, late * period).mean_force;
        self.before = next;
        early * of_before + late * of_next
    }
}
