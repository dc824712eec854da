//! Passivity observer and passivity controller.

use super::method::{Method, MethodParams, Plan, Situation};
use crate::Scalar;
use crate::contact::{Contact, LoopParams};
use crate::motion::ObjectMotion;
use crate::parameter::{ParameterError, ParameterValue, not_negative, positive};

/// Slowest device speed `[m/s]` at which a passivity controller acts unless told otherwise.
pub(super) const DEFAULT_SPEED_THRESHOLD: f64 = 1e-4;

/// Parameters of the passivity observer and controller.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct PopcParams<S> {
    /// Largest injected damping alpha_max `[N s/m]`, greater than 0.
    pub damping_cap: S,
    /// Device speed v_eps up to which no damping is injected `[m/s]`, not below 0.
    pub speed_threshold: S,
    /// Energy E_0 the object stores at the start and may give out `[J]`, not below 0.
    pub initial_energy: S,
}

impl<S: Scalar> PopcParams<S> {
    /// A controller that injects up to `damping_cap` `[N s/m]` above 0.1 mm/s, for an object that
    /// may give out nothing.
    pub fn new(damping_cap: S) -> Self {
        Self {
            damping_cap,
            speed_threshold: S::from_f64(DEFAULT_SPEED_THRESHOLD),
            initial_energy: S::ZERO,
        }
    }
}

/// Passivity observer and controller (Hannaford and Ryu): when more energy has come out through
/// the port than went in and was there at the start, inject the damping that takes it back within
/// one period, `alpha_i = -(E_i + E_0) / (T v_i^2)`, `f_i = K p_i + alpha_i v_i` while `p_i > 0`.
#[derive(Clone, Copy, Debug)]
pub struct Popc<S> {
    params: PopcParams<S>,
}

impl<S: Scalar> MethodParams<S> for PopcParams<S> {
    type Method = Popc<S>;

    fn check(self, _: &Contact<S>, _: &LoopParams<S>) -> Result<Self::Method, ParameterError> {
        positive("damping_cap", "N s/m", self.damping_cap)?;
        not_negative("speed_threshold", "m/s", self.speed_threshold)?;
        not_negative("initial_energy", "J", self.initial_energy)?;
        Ok(Popc { params: self })
    }

    fn name(&self) -> &'static str {
        "popc"
    }

    fn describe(&self, take: &mut dyn FnMut(&'static str, ParameterValue<S>)) {
        let number = ParameterValue::Number;
        take("damping_cap_n_s_per_m", number(self.damping_cap));
        take("speed_threshold_m_per_s", number(self.speed_threshold));
        take("initial_energy_j", number(self.initial_energy));
    }
}

impl<S: Scalar> Method<S> for Popc<S> {
    type Memory = ();

    #[inline]
    fn plan(&self, motion: &ObjectMotion<S>, now: &Situation<'_, S>, (): &mut ()) -> Plan<S> {
        let overdrawn = -(now.port_work + self.params.initial_energy);
        now.unswitched(motion, || {
            now.spring_force(motion)
                + dissipating_force(
                    overdrawn,
                    now.start.device_velocity,
                    self.params.damping_cap,
                    self.params.speed_threshold,
                    motion.period(),
                )
        })
    }
}

/// Force `[N]` that takes `deficit` `[J]` out of the device within one `period` `[s]` while it
/// keeps its `velocity` `[m/s]`, by no more than a damping of `cap` `[N s/m]`; 0 up to the speed
/// `threshold` `[m/s]`.
#[inline]
pub(super) fn dissipating_force<S: Scalar>(
    deficit: S,
    velocity: S,
    cap: S,
    threshold: S,
    period: S,
) -> S {
    if deficit > S::ZERO && velocity.abs() > threshold {
        cap.min(deficit / (period * velocity * velocity)) * velocity
    } else {
        S::ZERO
    }
}
