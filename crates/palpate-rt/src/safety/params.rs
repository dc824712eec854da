//! Limits of what may reach a device.

use std::time::Duration;

use crate::safety::recoveries::REMEMBERED;
use crate::safety::{OscillationParams, RecoveryParams};
use palpate_device::{Capabilities, Vector};

/// Limits of what may reach a device. The default lets through what a desktop device can do;
/// [`for_device`](Self::for_device) fits it to one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SafetyParams {
    /// Largest length of the force `[N]`: of a command, and of a command times the modelled gain of the actuator.
    pub largest_force: f64,
    /// Largest length of the torque, of a command and of a command times the gain `[N m]`.
    pub largest_torque: f64,
    /// Largest change of the same force per second `[N/s]`, also in soft starts; infinite: none. Only a safety stop, a refused
    /// sample or the end of the loop takes a force to 0 at once.
    pub slew_limit: f64,
    /// Largest change of the torque per second `[N m/s]`; infinite: none.
    pub torque_slew_limit: f64,
    /// Box of the end-point, lower and upper corner `[m]`; outside it the motors are off.
    pub workspace: Option<[Vector; 2]>,
    /// Where the device may be along the contact's axis, from the first to the second `[m]`; outside
    /// it the motors are off.
    pub range: Option<[f64; 2]>,
    /// Largest speed of the end-point `[m/s]`.
    pub largest_speed: f64,
    /// Periods without a fresh sample after which the force is none: 1 at once, 2 after having held
    /// the last force for a period.
    pub stale_after: u32,
    /// Time over which a force comes in when a start or a recovery finds contact `[s]`.
    pub soft_start: f64,
    /// When a contact counts as oscillating.
    pub oscillation: OscillationParams,
    /// When recoveries come too often.
    pub recoveries: RecoveryParams,
    /// How long the loop's thread may take from one tick to the next before a supervisor commands no
    /// force, in periods. It looks twice a period, so a limit of 1.5 acts within 2.
    pub stall_after_periods: f64,
    /// By how much a tick may be late in any case before that `[s]`: the wake-ups of an ordinary
    /// machine are late by up to 3 ms, however short the period is.
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
    /// The default limits, tightened to the largest force and the workspace of a device that says
    /// what these are.
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

    /// Limits for a loop of somebody else's: a largest force `[N]` and torque `[N m]`, none where there is no number, and a
    /// soft start `[s]`. Created energy stops it as it stops [`ControlLoop`](crate::ControlLoop); speed and the number of
    /// recoveries do not.
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

    /// How long the loop's thread may take from one tick to the next, at this period, before a
    /// supervisor or a guardian commands no force:
    /// [`stall_after_periods`](Self::stall_after_periods), or a period and
    /// [`tolerated_lateness`](Self::tolerated_lateness) where that is longer.
    #[must_use]
    pub fn stall_after(&self, period: Duration) -> Duration {
        let late = Duration::try_from_secs_f64(self.tolerated_lateness).unwrap_or_default();
        let periods = Duration::try_from_secs_f64(period.as_secs_f64() * self.stall_after_periods);
        periods
            .unwrap_or(Duration::MAX)
            .max(period.saturating_add(late))
    }

    pub(super) fn check(&self) -> Result<(), SafetyError> {
        let named = |name, value: f64, fine: bool, allowed| {
            if fine {
                Ok(())
            } else {
                Err(SafetyError {
                    name,
                    value,
                    allowed,
                })
            }
        };
        let positive = |name, value: f64| named(name, value, value > 0.0, "above 0");
        named(
            "largest force",
            self.largest_force,
            self.largest_force > 0.0 && self.largest_force.is_finite(),
            "finite and above 0 [N]",
        )?;
        named(
            "largest torque",
            self.largest_torque,
            self.largest_torque > 0.0 && self.largest_torque.is_finite(),
            "finite and above 0 [N m]",
        )?;
        positive("slew limit", self.slew_limit)?;
        positive("slew limit of the torque", self.torque_slew_limit)?;
        positive("largest speed", self.largest_speed)?;
        positive("energy of an oscillation", self.oscillation.energy)?;
        positive("window of an oscillation", self.oscillation.window)?;
        let RecoveryParams { too_many, window } = self.recoveries;
        positive("window of recoveries", window)?;
        if let Some(too_many) = too_many {
            named(
                "number of recoveries that is too many",
                too_many.into(),
                (2..=REMEMBERED).contains(&usize::try_from(too_many).unwrap_or(usize::MAX)),
                "2 to 32",
            )?;
        }
        named(
            "periods without a sample",
            self.stale_after.into(),
            (1..=2).contains(&self.stale_after),
            "1 or 2: after two periods no force may be left on",
        )?;
        named(
            "soft start",
            self.soft_start,
            (0.0..=60.0).contains(&self.soft_start),
            "0 to 60 [s]",
        )?;
        named(
            "periods until a stall",
            self.stall_after_periods,
            (1.0..=1000.0).contains(&self.stall_after_periods),
            "1 to 1000",
        )?;
        named(
            "tolerated lateness",
            self.tolerated_lateness,
            (0.0..=1.0).contains(&self.tolerated_lateness),
            "0 to 1 [s]",
        )?;
        if let Some([from, to]) = self.range {
            let extent = to - from;
            named(
                "extent of the range",
                extent,
                extent >= 0.0,
                "0 or above [m]",
            )?;
        }
        if let Some([lower, upper]) = self.workspace {
            for (low, high) in lower.iter().zip(upper) {
                let extent = high - low;
                named(
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

/// A limit that cannot be kept.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("safety: {name} is {value}; allowed: {allowed}")]
#[non_exhaustive]
pub struct SafetyError {
    /// Which.
    pub name: &'static str,
    /// What it was.
    pub value: f64,
    /// What it may be.
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
