//! The virtual damper, also known as the classic virtual coupling.

use super::method::{Method, MethodParams, Plan, Situation};
use crate::Scalar;
use crate::contact::{Contact, LoopParams};
use crate::motion::ObjectMotion;
use crate::parameter::{ParameterError, not_negative};

/// Parameters of the virtual damper.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct VirtualDamperParams<S> {
    /// Damping B of the contact `[N s/m]`, not below 0.
    pub damping: S,
}

/// A spring and a damper in parallel, Eq. (3): `f_i = K p_i + B (p_i - p_{i-1}) / T` while
/// `p_i > 0`.
///
/// The object feels the damper too: in contact it follows
/// `M eta'' = f_V + K (xi_i - eta) + B (v_i - eta')` with the device position and its
/// backward-difference velocity held, in closed form. The two damping terms use different
/// velocities: the force that of the penetration, the object's motion that of the device.
#[derive(Clone, Copy, Debug)]
pub struct VirtualDamper<S> {
    damping: S,
}

impl<S: Scalar> MethodParams<S> for VirtualDamperParams<S> {
    type Method = VirtualDamper<S>;

    fn check(self, _: &Contact<S>, _: &LoopParams<S>) -> Result<Self::Method, ParameterError> {
        Ok(VirtualDamper {
            damping: not_negative("damping", "N s/m", self.damping)?,
        })
    }
}

impl<S: Scalar> Method<S> for VirtualDamper<S> {
    type Memory = ();

    #[inline]
    fn plan(&self, motion: &ObjectMotion<S>, now: &Situation<'_, S>, (): &mut ()) -> Plan<S> {
        now.unswitched(motion, || {
            let penetration_velocity =
                (now.start.penetration - now.previous_penetration) / now.elapsed;
            now.spring_force(motion) + self.damping * penetration_velocity
        })
    }

    #[inline]
    fn contact_damping(&self) -> S {
        self.damping
    }
}
