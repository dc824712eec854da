//! Energy tank: the force uses the energy of a tank that the device's damping fills.

use super::method::{Method, MethodParams, Plan, Situation};
use super::named::{FromSettings, MethodInfo, MethodName};
use super::popc::{DAMPING_CAP, INITIAL_ENERGY, cap_of};
use super::setting::{Basis, Setting, SettingKey, SettingValues, Settings, SettingsError};
use crate::Scalar;
use crate::contact::{Contact, LoopParams};
use crate::motion::ObjectMotion;
use crate::parameter::{ParameterError, ParameterValue, Range, Unit};

/// The energy tank by name.
pub(super) const ENERGY_TANK: MethodInfo = MethodInfo {
    name: "energy-tank",
    summary: "spring force from an energy tank, filled by a damper",
    colour: 12,
    settings: &[TANK_DAMPING, DAMPING_CAP, INITIAL_ENERGY, DESIRED_ENERGY],
};

const TANK_DAMPING: Setting = Setting {
    key: SettingKey::DAMPING,
    values: SettingValues::Number {
        unit: Unit::NewtonSecondPerMetre,
        range: Range::NotNegative,
    },
    help: "damping B of an empty tank; it falls to 0 at the desired level",
    default: "K T",
};

const DESIRED_ENERGY: Setting = Setting {
    key: SettingKey::DESIRED_ENERGY,
    values: SettingValues::Number {
        unit: Unit::Joule,
        range: Range::Positive,
    },
    help: "desired level of the tank",
    default: "0.1",
};

impl SettingKey {
    /// Desired level of an energy tank `[J]`.
    pub const DESIRED_ENERGY: Self = Self::new("desired_energy_j");
}

/// Default of the desired level `[J]`.
const DEFAULT_DESIRED_ENERGY: f64 = 0.1;

impl<S: Scalar> FromSettings<S> for EnergyTankParams<S> {
    fn from_settings(
        method: MethodName,
        given: &Settings,
        basis: &Basis,
    ) -> Result<Self, SettingsError> {
        TANK_DAMPING.checked_word(method, given)?;
        let damping = given.number(SettingKey::DAMPING);
        let initial = given.number(SettingKey::INITIAL_ENERGY);
        let desired = given.number(SettingKey::DESIRED_ENERGY);
        Ok(Self {
            damping: S::from_f64(damping.unwrap_or(basis.impedance())),
            damping_cap: cap_of(given, basis),
            initial_energy: S::from_f64(initial.unwrap_or(basis.stored_energy)),
            desired_energy: S::from_f64(desired.unwrap_or(DEFAULT_DESIRED_ENERGY)),
        })
    }
}

/// Parameters of the energy tank.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct EnergyTankParams<S> {
    /// Damping B of an empty tank `[N s/m]`, not below 0.
    pub damping: S,
    /// Largest damping, reached if the tank is overdrawn `[N s/m]`, greater than 0.
    pub damping_cap: S,
    /// Level H_0 at the start `[J]`, not below 0.
    pub initial_energy: S,
    /// Desired level H_d `[J]`, greater than 0.
    pub desired_energy: S,
}

/// Energy tank, after the two-layer approach of Franken, Stramigioli, Misra, Secchi and Macchelli (IEEE Trans. Robotics
/// 27(4), 2011) and the tank of Ferraguti, Secchi and Fantuzzi (ICRA 2013). The equations are as derived here:
///
/// ```text
/// H_i = H_0 + sum f (xi_{i+1} - xi_i) - (V_i - V_0)
/// f_K = K p                      if 0 < K p |v| T <= H,  H/(|v| T) above,  0 if H <= 0
/// f   = f_K + min(B_max, B max(0, 1 - H/H_d)) v          while p > 0
/// ```
///
/// The level H rises by the work of the held force and falls by the energy that the object and its spring gain; it is
/// H_0 minus the accumulated leak. With v the device's velocity, the damper fills the tank up to the level H_d. The
/// method has four numbers, and none suits two scenes.
#[derive(Clone, Copy, Debug)]
pub struct EnergyTank<S> {
    params: EnergyTankParams<S>,
}

impl<S: Scalar> MethodParams<S> for EnergyTankParams<S> {
    type Method = EnergyTank<S>;

    fn check(self, _: &Contact<S>, _: &LoopParams<S>) -> Result<Self::Method, ParameterError> {
        TANK_DAMPING.check(self.damping)?;
        DAMPING_CAP.check(self.damping_cap)?;
        INITIAL_ENERGY.check(self.initial_energy)?;
        DESIRED_ENERGY.check(self.desired_energy)?;
        Ok(EnergyTank { params: self })
    }

    fn name(&self) -> &'static str {
        ENERGY_TANK.name
    }

    fn describe(&self, take: &mut dyn FnMut(&'static str, ParameterValue<S>)) {
        let number = ParameterValue::Number;
        take(TANK_DAMPING.key.as_str(), number(self.damping));
        take(DAMPING_CAP.key.as_str(), number(self.damping_cap));
        take(INITIAL_ENERGY.key.as_str(), number(self.initial_energy));
        take(DESIRED_ENERGY.key.as_str(), number(self.desired_energy));
    }
}

impl<S: Scalar> Method<S> for EnergyTank<S> {
    type Memory = ();

    #[inline]
    fn plan(&self, motion: &ObjectMotion<S>, now: &Situation<'_, S>, (): &mut ()) -> Plan<S> {
        now.unswitched(motion, || {
            let params = &self.params;
            let level = params.initial_energy - now.held_leak;
            let velocity = now.start.device_velocity;
            let way = velocity.abs() * motion.period();
            let spring = now.spring_force(motion);
            let allowed = if level <= S::ZERO {
                S::ZERO
            } else if spring * way > level {
                level / way
            } else {
                spring
            };
            let missing = (S::ONE - level / params.desired_energy).max(S::ZERO);
            let damping = (params.damping * missing).min(params.damping_cap);
            allowed + damping * velocity
        })
    }
}
