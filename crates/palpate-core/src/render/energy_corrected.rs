//! Energy-corrected object: sampled passive interconnection of device and object.

use super::extrapolated::Extrapolated;
use super::method::{Ended, Method, MethodParams, Plan, Situation};
use super::named::{FromSettings, MethodInfo, MethodName};
use super::setting::{Basis, Settings, SettingsError};
use crate::Scalar;
use crate::contact::{Contact, LoopParams};
use crate::motion::{Displacement, ObjectMotion};
use crate::parameter::ParameterError;

/// The energy-corrected object by name.
pub(super) const ENERGY_CORRECTED: MethodInfo = MethodInfo {
    name: "energy-corrected",
    summary: "object whose speed takes the energy error of the port",
    colour: 8,
    settings: &[],
};

impl<S: Scalar> FromSettings<S> for EnergyCorrectedParams {
    fn from_settings(_: MethodName, _: &Settings, _: &Basis) -> Result<Self, SettingsError> {
        Ok(Self {})
    }
}

/// The energy-corrected object has no parameters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct EnergyCorrectedParams {}

/// Object whose kinetic energy closes the energy balance of the port at every sample, after the sampled passive
/// interconnection of Stramigioli, Secchi, van der Schaft and Fantuzzi (IEEE Trans. Robotics 21(4), 2005) and
/// Borghesan, Macchelli and Melchiorri (IEEE Trans. Haptics, 2010). The equations are as derived here:
///
/// ```text
/// V      = M eta'^2/2 + K p^2 h(p)/2 - f_V eta
/// k      = V_{i-1} + f_{i-1} (xi_i - xi_{i-1}) + D - (K p^2 h(p)/2 - f_V eta)
/// k >= 0:  eta' <- sign(eta') sqrt(2 k/M),  D <- 0
/// k <  0:  eta' <- 0,                       D <- k
/// ```
///
/// D <= 0 is the energy that the object owes because it has no kinetic energy left. The held force is the mean of the
/// spring force over the period, with the device at the velocity of its last step and the object under the spring and
/// f_V. The method has no setting and needs no mass of the device. A wall has no kinetic energy: there the force is
/// that of HFCR without leak dissipation.
#[derive(Clone, Copy, Debug)]
pub struct EnergyCorrected;

/// Energy that the object owes to the port.
#[derive(Clone, Copy, Debug, Default)]
pub struct EnergyCorrectedMemory<S> {
    /// D, not above 0 `[J]`.
    debt: S,
}

impl<S: Scalar> EnergyCorrectedMemory<S> {
    /// Returns the energy that the object owes to the port, D; not above 0 `[J]`.
    pub fn debt(&self) -> S {
        self.debt
    }
}

impl<S: Scalar> MethodParams<S> for EnergyCorrectedParams {
    type Method = EnergyCorrected;

    fn check(self, _: &Contact<S>, _: &LoopParams<S>) -> Result<EnergyCorrected, ParameterError> {
        Ok(EnergyCorrected)
    }

    fn name(&self) -> &'static str {
        ENERGY_CORRECTED.name
    }
}

impl<S: Scalar> Method<S> for EnergyCorrected {
    type Memory = EnergyCorrectedMemory<S>;

    #[inline]
    fn plan(
        &self,
        motion: &ObjectMotion<S>,
        now: &Situation<'_, S>,
        _: &mut EnergyCorrectedMemory<S>,
    ) -> Plan<S> {
        let planned = Extrapolated::over(motion, &now.start, motion.period());
        Plan {
            force: planned.impulse / motion.period(),
            rule: planned.rule,
            moved: planned.moved,
        }
    }

    #[inline]
    fn conclude(
        &self,
        motion: &ObjectMotion<S>,
        ended: &Ended<S>,
        memory: &mut EnergyCorrectedMemory<S>,
    ) -> Displacement<S> {
        let start = &ended.start;
        let moved = if ended.nominal {
            ended.planned
        } else {
            Extrapolated::over(motion, start, ended.elapsed).moved
        };
        if motion.is_wall() {
            return moved;
        }
        let penetration = start.penetration + ended.device_moved - moved.by;
        let supplied = ended.held.mean * ended.device_moved + start.virtual_force * moved.by;
        let stored = motion.stored_energy(start.penetration, start.object_velocity);
        let elastic = motion.stored_energy(penetration, S::ZERO);
        let kinetic = stored + supplied + memory.debt - elastic;
        memory.debt = kinetic.min(S::ZERO);
        let speed = (S::TWO * kinetic.max(S::ZERO) * motion.mobility()).sqrt();
        let velocity = if moved.velocity < S::ZERO {
            -speed
        } else {
            speed
        };
        Displacement {
            by: moved.by,
            velocity,
        }
    }
}
