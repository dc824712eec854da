//! Limits of the wrench on a device.

use std::time::Duration;

use crate::safety::recoveries::REMEMBERED;
use crate::safety::{OscillationParams, RecoveryParams};
use palpate_device::{Capabilities, Vector};

/// Limits of the wrench on a device. The default fits desktop devices; [`for_device`](Self::for_device) fits it to
/// one device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SafetyParams {
    /// Largest norm of the force `[N]`: of a command, and of a command times the modelled gain of the actuator.
    pub largest_force: f64,
    /// Largest norm of the torque, of a command and of a command times the gain `[N m]`.
    pub largest_torque: f64,
    /// Largest change of the same force per second `[N/s]`, also in soft starts; infinite: unlimited. Only a safety
    /// stop, a rejected sample or the end of the loop sets a force to 0 at once.
    pub slew_limit: f64,
    /// Largest change of the torque per second `[N m/s]`; infinite: unlimited.
    pub torque_slew_limit: f64,
    /// Workspace of the end-point, lower and upper corner `[m]`; outside it the motors are off.
    pub workspace: Option<[Vector; 2]>,
    /// Allowed interval of the device's coordinate along the contact's axis `[m]`; outside it the motors are off.
    pub range: Option<[f64; 2]>,
    /// Largest speed of the end-point `[m/s]`.
    pub largest_speed: f64,
    /// Number of periods without a fresh sample after which the force is 0: 1 immediately, 2 after holding the last
    /// force for one period.
    pub stale_after: u32,
    /// Ramp time of the force after a start or a recovery in contact `[s]`.
    pub soft_start: f64,
    /// Threshold for an oscillating contact.
    pub oscillation: OscillationParams,
    /// Threshold for frequent recoveries.
    pub recoveries: RecoveryParams,
    /// Maximum time between ticks before a supervisor commands zero force, in periods. The supervisor sleeps until the
    /// limit is over.
    pub stall_after_periods: f64,
    /// Minimum of the tolerated lateness of a tick `[s]`: wake-ups of an ordinary machine are late by up to 3 ms,
    /// whatever the period.
    pub tolerated_lateness: f64,
}

impl Default for SafetyParams {
    fn default() -> Self {
        Self {
            largest_force: 20.0,
            largest_torque: 1.0,
            slew_limit: f64::INFINITY,
            torque_slew_limit: f64::INFINITY,
            workspace: None,
            range: None,
            largest_speed: 5.0,
            stale_after: 2,
            soft_start: 0.2,
            oscillation: OscillationParams::default(),
            recoveries: RecoveryParams::default(),
            stall_after_periods: 1.5,
            tolerated_lateness: 3e-3,
        }
    }
}

impl SafetyParams {
    /// Returns the default limits, reduced to the largest force and the workspace of a device if these are known.
    #[must_use]
    pub fn for_device(device: &Capabilities) -> Self {
        let limits = Self::default();
        Self {
            largest_force: device.largest_force.map_or(limits.largest_force, |force| {
                limits.largest_force.min(force)
            }),
            largest_torque: device
                .largest_torque
                .map_or(limits.largest_torque, |torque| {
                    limits.largest_torque.min(torque)
                }),
            workspace: device.workspace,
            ..limits
        }
    }

    /// Creates limits for a caller-owned loop: largest force `[N]` and torque `[N m]` (`None`: unlimited) and
    /// soft-start time `[s]`. The stop on generated energy is that of [`ControlLoop`](crate::ControlLoop). Speed and
    /// the number of recoveries are not checked.
    #[must_use]
    pub fn bounding(force: Option<f64>, torque: Option<f64>, soft_start: f64) -> Self {
        let limits = Self::default();
        Self {
            largest_force: force.unwrap_or(f64::MAX),
            largest_torque: torque.unwrap_or(f64::MAX),
            soft_start,
            largest_speed: f64::INFINITY,
            recoveries: RecoveryParams {
                too_many: None,
                ..limits.recoveries
            },
            ..limits
        }
    }

    /// Returns the maximum time between ticks at this period before a supervisor or a watchdog process commands zero
    /// force: the longer of [`stall_after_periods`](Self::stall_after_periods) and a period plus
    /// [`tolerated_lateness`](Self::tolerated_lateness).
    #[must_use]
    pub fn stall_after(&self, period: Duration) -> Duration {
        let late = Duration::try_from_secs_f64(self.tolerated_lateness).unwrap_or_default();
        let periods = Duration::try_from_secs_f64(period.as_secs_f64() * self.stall_after_periods);
        periods
            .unwrap_or(Duration::MAX)
            .max(period.saturating_add(late))
    }

    pub(super) fn check(&self) -> Result<(), SafetyError> {
        check_value(
            "largest force",
            self.largest_force,
            self.largest_force > 0.0 && self.largest_force.is_finite(),
            "finite and above 0 [N]",
        )?;
        check_value(
            "largest torque",
            self.largest_torque,
            self.largest_torque > 0.0 && self.largest_torque.is_finite(),
            "finite and above 0 [N m]",
        )?;
        check_positive("slew limit", self.slew_limit)?;
        check_positive("slew limit of the torque", self.torque_slew_limit)?;
        check_positive("largest speed", self.largest_speed)?;
        check_positive("energy of an oscillation", self.oscillation.energy)?;
        check_positive("window of an oscillation", self.oscillation.window)?;
        self.check_recoveries()?;
        self.check_times()?;
        self.check_extents()
    }

    /// Rejects invalid thresholds for frequent recoveries.
    fn check_recoveries(&self) -> Result<(), SafetyError> {
        let RecoveryParams { too_many, window } = self.recoveries;
        check_positive("window of recoveries", window)?;
        if let Some(too_many) = too_many {
            check_value(
                "number of recoveries",
                too_many.into(),
                (2..=REMEMBERED).contains(&usize::try_from(too_many).unwrap_or(usize::MAX)),
                "2 to 32",
            )?;
        }
        Ok(())
    }

    /// Rejects an invalid number of periods or duration.
    fn check_times(&self) -> Result<(), SafetyError> {
        check_value(
            "periods without a sample",
            self.stale_after.into(),
            (1..=2).contains(&self.stale_after),
            "1 or 2: after two periods the force must be 0",
        )?;
        check_value(
            "soft start",
            self.soft_start,
            (0.0..=60.0).contains(&self.soft_start),
            "0 to 60 [s]",
        )?;
        check_value(
            "periods until a stall",
            self.stall_after_periods,
            (1.0..=1000.0).contains(&self.stall_after_periods),
            "1 to 1000",
        )?;
        check_value(
            "tolerated lateness",
            self.tolerated_lateness,
            (0.0..=1.0).contains(&self.tolerated_lateness),
            "0 to 1 [s]",
        )
    }

    /// Rejects a range or a workspace whose upper end is below its lower end.
    fn check_extents(&self) -> Result<(), SafetyError> {
        if let Some([from, to]) = self.range {
            let extent = to - from;
            check_value(
                "extent of the range",
                extent,
                extent >= 0.0,
                "0 or above [m]",
            )?;
        }
        if let Some([lower, upper]) = self.workspace {
            for (low, high) in lower.iter().zip(upper) {
                let extent = high - low;
                check_value(
                    "extent of the workspace",
                    extent,
                    extent >= 0.0,
                    "0 or above [m]",
                )?;
            }
        }
        Ok(())
    }
}

/// Rejects a value that is not `fine`.
pub(crate) fn check_value(
    name: &'static str,
    value: f64,
    fine: bool,
    allowed: &'static str,
) -> Result<(), SafetyError> {
    if fine {
        Ok(())
    } else {
        Err(SafetyError {
            name,
            value,
            allowed,
        })
    }
}

/// Rejects a value that is not above 0.
fn check_positive(name: &'static str, value: f64) -> Result<(), SafetyError> {
    check_value(name, value, value > 0.0, "above 0")
}

/// An invalid limit.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("safety: {name} is {value}; allowed: {allowed}")]
#[non_exhaustive]
pub struct SafetyError {
    /// Name of the limit.
    pub name: &'static str,
    /// Invalid value.
    pub value: f64,
    /// Allowed range.
    pub allowed: &'static str,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stall_is_half_a_period_late_or_later_than_machines_are() {
        let stall_after = |params: SafetyParams, period: f64| {
            let limit = params.stall_after(Duration::from_secs_f64(period));
            (limit.as_secs_f64() * 1e6).round()
        };
        let usual = SafetyParams::default();
        assert_eq!(stall_after(usual, 0.00025), 3250.0);
        assert_eq!(stall_after(usual, 0.001), 4000.0);
        assert_eq!(stall_after(usual, 0.004), 7000.0);
        assert_eq!(stall_after(usual, 0.01), 15_000.0);
        let asked = SafetyParams {
            stall_after_periods: 2.0,
            tolerated_lateness: 0.0,
            ..usual
        };
        assert_eq!(stall_after(asked, 0.00025), 500.0);
    }
}
