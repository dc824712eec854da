//! Force bounding: limits the force by the energy that has entered the object and the device's own damping.

use super::method::{Ended, Method, MethodParams, Plan, Situation};
use super::named::{FromSettings, MethodInfo, MethodName};
use super::setting::{Basis, Setting, SettingKey, SettingValues, Settings, SettingsError};
use crate::Scalar;
use crate::contact::{Contact, LoopParams};
use crate::motion::{Displacement, ObjectMotion};
use crate::parameter::{ParameterError, ParameterValue, Range, Unit};

/// Force bounding by name.
pub(super) const FORCE_BOUNDING: MethodInfo = MethodInfo {
    name: "force-bounding",
    summary: "spring force bounded by the energy of the port",
    colour: 10,
    settings: &[DEVICE_DAMPING],
};

const DEVICE_DAMPING: Setting = Setting {
    key: SettingKey::DEVICE_DAMPING,
    values: SettingValues::Number {
        unit: Unit::NewtonSecondPerMetre,
        range: Range::NotNegative,
    },
    help: "assumed damping b of the device, whose dissipation the force may use",
    default: "K T/2",
};

impl SettingKey {
    /// Damping of the device that force bounding assumes `[N s/m]`.
    pub const DEVICE_DAMPING: Self = Self::new("assumed_damping_n_s_per_m");
}

impl<S: Scalar> FromSettings<S> for ForceBoundingParams<S> {
    fn from_settings(
        _: MethodName,
        given: &Settings,
        basis: &Basis,
    ) -> Result<Self, SettingsError> {
        let damping = given.number(SettingKey::DEVICE_DAMPING);
        Ok(Self {
            device_damping: S::from_f64(damping.unwrap_or(0.5 * basis.impedance())),
        })
    }
}

/// Parameters of force bounding.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct ForceBoundingParams<S> {
    /// Assumed damping b of the device `[N s/m]`, not below 0.
    pub device_damping: S,
}

/// Force bounding, after Kim and Ryu (Int. J. Robotics Research, 2010). The equations are as derived here:
///
/// ```text
/// E_i = E_{i-1} + (b/T) (xi_i - xi_{i-1})^2 + f_{i-1} (xi_i - xi_{i-1}),   E = 0 while p <= 0
/// |f_i| <= 2 sqrt(b E_i/T)
/// ```
///
/// E is the energy that has entered the object in the present contact, plus the dissipation of the device's own
/// damping b. The bound is the largest force for which no motion of the device over the next period makes E negative.
/// It bounds energy and not error: the first sample of a contact has no force, and the object moves by the unbounded
/// spring, Eqs. (4) and (6a). A device that has less damping than b can extract energy.
#[derive(Clone, Copy, Debug)]
pub struct ForceBounding<S> {
    damping: S,
}

/// Energy that bounds the force.
#[derive(Clone, Copy, Debug, Default)]
pub struct ForceBoundingMemory<S> {
    /// E, not below 0 `[J]`.
    energy: S,
}

impl<S: Scalar> MethodParams<S> for ForceBoundingParams<S> {
    type Method = ForceBounding<S>;

    fn check(self, _: &Contact<S>, _: &LoopParams<S>) -> Result<Self::Method, ParameterError> {
        Ok(ForceBounding {
            damping: DEVICE_DAMPING.check(self.device_damping)?,
        })
    }

    fn name(&self) -> &'static str {
        FORCE_BOUNDING.name
    }

    fn describe(&self, take: &mut dyn FnMut(&'static str, ParameterValue<S>)) {
        let damping = ParameterValue::Number(self.device_damping);
        take(DEVICE_DAMPING.key.as_str(), damping);
    }
}

impl<S: Scalar> Method<S> for ForceBounding<S> {
    type Memory = ForceBoundingMemory<S>;

    #[inline]
    fn plan(
        &self,
        motion: &ObjectMotion<S>,
        now: &Situation<'_, S>,
        memory: &mut ForceBoundingMemory<S>,
    ) -> Plan<S> {
        if !now.in_contact() {
            memory.energy = S::ZERO;
        }
        let bound = S::TWO * (self.damping * memory.energy / motion.period()).sqrt();
        now.unswitched(motion, || now.spring_force(motion).min(bound))
    }

    #[inline]
    fn conclude(
        &self,
        motion: &ObjectMotion<S>,
        ended: &Ended<S>,
        memory: &mut ForceBoundingMemory<S>,
    ) -> Displacement<S> {
        let way = ended.device_moved;
        let dissipated = self.damping / ended.elapsed * way * way;
        // Rounding, a longer period or a delayed force can make the sum negative; no force follows.
        memory.energy = (memory.energy + dissipated + ended.held.mean * way).max(S::ZERO);
        ended.as_planned(motion)
    }
}
