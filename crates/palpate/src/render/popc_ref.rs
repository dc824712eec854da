//! Passivity observer and controller that follow a reference energy.

use super::method::{Method, MethodParams, Plan, Situation};
use super::popc::{DEFAULT_SPEED_THRESHOLD, dissipating_force};
use crate::Scalar;
use crate::contact::{Contact, LoopParams};
use crate::motion::ObjectMotion;
use crate::parameter::{ParameterError, ParameterValue, not_negative, positive};

/// Parameters of reference energy following.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct PopcRefParams<S> {
    /// Largest injected damping alpha_max `[N s/m]`, greater than 0. Without a cap the force
    /// explodes whenever the device turns round; 5 to 8 suits the paper's first experiment.
    pub damping_cap: S,
    /// Device speed v_eps up to which no damping is injected `[m/s]`, not below 0.
    pub speed_threshold: S,
}

impl<S: Scalar> PopcRefParams<S> {
    /// A controller that injects up to `damping_cap` `[N s/m]` above 0.1 mm/s.
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
/// The deficit d is what the ledger calls the accumulated leak of the held force.
#[derive(Clone, Copy, Debug)]
pub struct PopcRef<S> {
    params: PopcRefParams<S>,
}

impl<S: Scalar> MethodParams<S> for PopcRefParams<S> {
    type Method = PopcRef<S>;

    fn check(self, _: &Contact<S>, _: &LoopParams<S>) -> Result<Self::Method, ParameterError> {
        positive("damping_cap", "N s/m", self.damping_cap)?;
        not_negative("speed_threshold", "m/s", self.speed_threshold)?;
        Ok(PopcRef { params: self })
    }

    fn name(&self) -> &'static str {
        "popc-ref"
    }

    fn describe(&self, take: &mut dyn FnMut(&'static str, ParameterValue<S>)) {
        let number = ParameterValue::Number;
        take("damping_cap_n_s_per_m", number(self.damping_cap));
        take("speed_threshold_m_per_s", number(self.speed_threshold));
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
