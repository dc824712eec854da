//! `[render]` of a scene file.

use palpate_core::{Guard, LoopParams, Parameter};
use serde::Deserialize;
use toml::Spanned;

use super::fault::Places;
use super::guard::{GuardBounds, GuardMode};
use super::parameter::SceneParameter;

/// Method, limits and guard.
#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawRender {
    pub method: Option<Spanned<String>>,
    pub unilateral: Option<Spanned<bool>>,
    pub force_limit_n: Option<Spanned<f64>>,
    pub torque_limit_n_m: Option<Spanned<f64>>,
    pub slew_limit_n_per_s: Option<Spanned<f64>>,
    pub speed_limit_m_per_s: Option<Spanned<f64>>,
    pub largest_gap_s: Option<Spanned<f64>>,
    pub guard: Option<RawGuard>,
}

/// A bound on the energy that held forces give out.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawGuard {
    pub mode: Spanned<GuardMode>,
    pub speed_m_per_s: Option<Spanned<f64>>,
    pub turning_rad_per_s: Option<Spanned<f64>>,
    pub allowance_j: Option<Spanned<f64>>,
    pub acceleration_m_per_s2: Option<Spanned<f64>>,
    pub turning_acceleration_rad_per_s2: Option<Spanned<f64>>,
    pub hand_force_n: Option<Spanned<f64>>,
    pub hand_torque_n_m: Option<Spanned<f64>>,
    pub least_mass_kg: Option<Spanned<f64>>,
    pub learn_mass: Option<Spanned<bool>>,
    pub least_inertia_kg_m2: Option<Spanned<f64>>,
    pub recovery_w: Option<Spanned<f64>>,
    pub late_samples: Option<Spanned<usize>>,
}

impl RawRender {
    /// Returns the loop of a period `[s]` with limits and guard.
    pub fn of_one_contact(
        self,
        period: f64,
        places: &mut Places<SceneParameter>,
    ) -> LoopParams<f64> {
        let mut limit = |of: SceneParameter, value: Option<Spanned<f64>>| {
            value.map(|value| places.take(of, value))
        };
        let loop_params = LoopParams {
            // A simulated device does not glitch; a loop that diverges is to be seen doing so.
            speed_limit: limit(Parameter::SpeedLimit.into(), self.speed_limit_m_per_s),
            force_limit: limit(Parameter::ForceLimit.into(), self.force_limit_n),
            slew_limit: limit(Parameter::SlewLimit.into(), self.slew_limit_n_per_s),
            largest_gap: limit(Parameter::LargestGap.into(), self.largest_gap_s),
            ..LoopParams::new(period)
        };
        let guard = self.guard.map_or(Guard::Off, |guard| {
            let mut bound = |of: Parameter, value: Option<Spanned<f64>>| {
                value.map(|value| places.take(of, value))
            };
            guard.mode.get_ref().guard(GuardBounds {
                speed: bound(Parameter::GuardSpeed, guard.speed_m_per_s),
                allowance: bound(Parameter::GuardAllowance, guard.allowance_j),
                acceleration: bound(Parameter::GuardAcceleration, guard.acceleration_m_per_s2),
                hand_force: bound(Parameter::GuardHandForce, guard.hand_force_n),
                least_mass: bound(Parameter::GuardMass, guard.least_mass_kg),
                learns_mass: guard.learn_mass.is_some_and(Spanned::into_inner),
                recovery: bound(Parameter::GuardRecovery, guard.recovery_w),
            })
        });
        LoopParams {
            guard,
            ..loop_params
        }
    }
}
