//! Passivity observer and passivity controller.

use super::method::{Method, MethodParams, Plan, Situation};
use super::named::{FromSettings, MethodInfo, MethodName};
use super::setting::{Basis, Setting, SettingKey, SettingValues, Settings, SettingsError};
use crate::Scalar;
use crate::contact::{Contact, LoopParams};
use crate::motion::ObjectMotion;
use crate::parameter::{ParameterError, ParameterValue, Range, Unit};

/// The passivity controller by name.
pub(super) const POPC: MethodInfo = MethodInfo {
    name: "popc",
    summary: "passivity observer and controller",
    colour: 7,
    settings: &[DAMPING_CAP, SPEED_THRESHOLD, INITIAL_ENERGY],
};

pub(super) const DAMPING_CAP: Setting = Setting {
    key: SettingKey::DAMPING_CAP,
    values: SettingValues::Number {
        unit: Unit::NewtonSecondPerMetre,
        range: Range::Positive,
    },
    help: "largest damping alpha_max that is injected",
    default: "3 K T",
};

pub(super) const SPEED_THRESHOLD: Setting = Setting {
    key: SettingKey::SPEED_THRESHOLD,
    values: SettingValues::Number {
        unit: Unit::MetrePerSecond,
        range: Range::NotNegative,
    },
    help: "device speed v_eps up to which nothing is injected",
    default: "1e-4",
};

pub(super) const INITIAL_ENERGY: Setting = Setting {
    key: SettingKey::INITIAL_ENERGY,
    values: SettingValues::Number {
        unit: Unit::Joule,
        range: Range::NotNegative,
    },
    help: "energy E_0 that may be given out",
    default: "energy stored in the object at the start",
};

impl SettingKey {
    /// Largest damping that a passivity controller injects `[N s/m]`.
    pub const DAMPING_CAP: Self = Self::new("damping_cap_n_s_per_m");
    /// Device speed up to which a passivity controller does not act `[m/s]`.
    pub const SPEED_THRESHOLD: Self = Self::new("speed_threshold_m_per_s");
    /// Initial energy that the passivity controller may give out `[J]`.
    pub const INITIAL_ENERGY: Self = Self::new("initial_energy_j");
}

/// Returns the cap of a passivity controller `[N s/m]`, as given or 3 K T.
pub(super) fn cap_of<S: Scalar>(given: &Settings, basis: &Basis) -> S {
    let cap = given.number(SettingKey::DAMPING_CAP);
    S::from_f64(cap.unwrap_or(3.0 * basis.impedance()))
}

impl<S: Scalar> FromSettings<S> for PopcParams<S> {
    fn from_settings(
        _: MethodName,
        given: &Settings,
        basis: &Basis,
    ) -> Result<Self, SettingsError> {
        let (threshold, energy) = (SettingKey::SPEED_THRESHOLD, SettingKey::INITIAL_ENERGY);
        Ok(Self {
            damping_cap: cap_of(given, basis),
            speed_threshold: S::from_f64(
                given.number(threshold).unwrap_or(DEFAULT_SPEED_THRESHOLD),
            ),
            initial_energy: S::from_f64(given.number(energy).unwrap_or(basis.stored_energy)),
        })
    }
}

/// Default device speed above which a passivity controller acts `[m/s]`.
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
    /// Creates a controller that injects up to `damping_cap` `[N s/m]` above 0.1 mm/s, for an object that may give out
    /// no energy.
    pub fn new(damping_cap: S) -> Self {
        Self {
            damping_cap,
            speed_threshold: S::from_f64(DEFAULT_SPEED_THRESHOLD),
            initial_energy: S::ZERO,
        }
    }
}

/// Passivity observer and controller (Hannaford and Ryu): if more energy has left through the port than entered and was
/// initially stored, it injects the damping that removes the excess within one period, `alpha_i = -(E_i + E_0) / (T
/// v_i^2)`, `f_i = K p_i + alpha_i v_i` while `p_i > 0`.
#[derive(Clone, Copy, Debug)]
pub struct Popc<S> {
    params: PopcParams<S>,
}

impl<S: Scalar> MethodParams<S> for PopcParams<S> {
    type Method = Popc<S>;

    fn check(self, _: &Contact<S>, _: &LoopParams<S>) -> Result<Self::Method, ParameterError> {
        DAMPING_CAP.check(self.damping_cap)?;
        SPEED_THRESHOLD.check(self.speed_threshold)?;
        INITIAL_ENERGY.check(self.initial_energy)?;
        Ok(Popc { params: self })
    }

    fn name(&self) -> &'static str {
        POPC.name
    }

    fn describe(&self, take: &mut dyn FnMut(&'static str, ParameterValue<S>)) {
        let number = ParameterValue::Number;
        take(DAMPING_CAP.key.as_str(), number(self.damping_cap));
        take(SPEED_THRESHOLD.key.as_str(), number(self.speed_threshold));
        take(INITIAL_ENERGY.key.as_str(), number(self.initial_energy));
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

/// Returns the force `[N]` that removes `deficit` `[J]` from the device within one `period` `[s]` at constant
/// `velocity` `[m/s]`, with a damping of at most `cap` `[N s/m]`; 0 up to the speed `threshold` `[m/s]`.
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
