//! Passivity observer and controller that follow a reference energy.

use super::method::{Method, MethodParams, Plan, Situation};
use super::named::{FromSettings, MethodInfo, MethodName};
use super::popc::{
    DAMPING_CAP, DEFAULT_SPEED_THRESHOLD, SPEED_THRESHOLD, cap_of, dissipating_force,
};
use super::setting::{Basis, SettingKey, Settings, SettingsError};
use crate::Scalar;
use crate::contact::{Contact, LoopParams};
use crate::motion::ObjectMotion;
use crate::parameter::{ParameterError, ParameterValue};

/// Reference energy following by name.
pub(super) const POPC_REF: MethodInfo = MethodInfo {
    name: "popc-ref",
    summary: "passivity controller that follows a reference energy",
    colour: 3,
    settings: &[DAMPING_CAP, SPEED_THRESHOLD],
};

impl<S: Scalar> FromSettings<S> for PopcRefParams<S> {
    fn from_settings(
        _: MethodName,
        given: &Settings,
        basis: &Basis,
    ) -> Result<Self, SettingsError> {
        let threshold = given.number(SettingKey::SPEED_THRESHOLD);
        Ok(Self {
            damping_cap: cap_of(given, basis),
            speed_threshold: S::from_f64(threshold.unwrap_or(DEFAULT_SPEED_THRESHOLD)),
        })
    }
}

/// Parameters of reference energy following.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct PopcRefParams<S> {
    /// Largest injected damping alpha_max `[N s/m]`, greater than 0. Without a cap the force diverges whenever the
    /// device reverses its motion; 5 to 8 suits the paper's first experiment.
    pub damping_cap: S,
    /// Device speed v_eps up to which no damping is injected `[m/s]`, not below 0.
    pub speed_threshold: S,
}

impl<S: Scalar> PopcRefParams<S> {
    /// Creates a controller that injects up to `damping_cap` `[N s/m]` above 0.1 mm/s.
    pub fn new(damping_cap: S) -> Self {
        Self {
            damping_cap,
            speed_threshold: S::from_f64(DEFAULT_SPEED_THRESHOLD),
        }
    }
}

/// Reference energy following: the passivity controller acts when the object stores more than it
/// received, `d = (V_i - V_0) - E_i > 0`, with `alpha_i = min(alpha_max, d / (T v_i^2))` and
/// `f_i = K p_i + alpha_i v_i` while `p_i > 0`.
///
/// The deficit d is the accumulated leak of the held force in the ledger.
#[derive(Clone, Copy, Debug)]
pub struct PopcRef<S> {
    params: PopcRefParams<S>,
}

impl<S: Scalar> MethodParams<S> for PopcRefParams<S> {
    type Method = PopcRef<S>;

    fn check(self, _: &Contact<S>, _: &LoopParams<S>) -> Result<Self::Method, ParameterError> {
        DAMPING_CAP.check(self.damping_cap)?;
        SPEED_THRESHOLD.check(self.speed_threshold)?;
        Ok(PopcRef { params: self })
    }

    fn name(&self) -> &'static str {
        POPC_REF.name
    }

    fn describe(&self, take: &mut dyn FnMut(&'static str, ParameterValue<S>)) {
        let number = ParameterValue::Number;
        take(DAMPING_CAP.key.as_str(), number(self.damping_cap));
        take(SPEED_THRESHOLD.key.as_str(), number(self.speed_threshold));
    }
}

impl<S: Scalar> Method<S> for PopcRef<S> {
    type Memory = ();

    #[inline]
    fn plan(&self, motion: &ObjectMotion<S>, now: &Situation<'_, S>, (): &mut ()) -> Plan<S> {
        now.unswitched(motion, || {
            now.spring_force(motion)
                + dissipating_force(
                    now.held_leak,
                    now.start.device_velocity,
                    self.params.damping_cap,
                    self.params.speed_threshold,
                    motion.period(),
                )
        })
    }
}
