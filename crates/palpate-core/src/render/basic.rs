//! The basic model: the spring force of the sampled penetration, held.

use super::method::{Method, MethodParams, Plan, Situation};
use super::named::MethodInfo;
use crate::Scalar;
use crate::contact::{Contact, LoopParams};
use crate::motion::ObjectMotion;
use crate::parameter::ParameterError;

/// The basic model by name.
pub(super) const BASIC: MethodInfo = MethodInfo {
    name: "basic",
    summary: "spring force of the sampled penetration",
    colour: 1,
    settings: &[],
};

/// The basic model has no parameters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BasicParams;

/// The basic model, Eqs. (4), (6a), (6b): `f_i = K p_i` while `p_i > 0`. It assumes a device at rest over the interval,
/// and therefore leaks energy whenever the device moves.
#[derive(Clone, Copy, Debug)]
pub struct Basic;

impl<S: Scalar> MethodParams<S> for BasicParams {
    type Method = Basic;

    fn check(self, _: &Contact<S>, _: &LoopParams<S>) -> Result<Basic, ParameterError> {
        Ok(Basic)
    }

    fn name(&self) -> &'static str {
        BASIC.name
    }
}

impl<S: Scalar> Method<S> for Basic {
    type Memory = ();

    #[inline]
    fn plan(&self, motion: &ObjectMotion<S>, now: &Situation<'_, S>, (): &mut ()) -> Plan<S> {
        now.unswitched(motion, || now.spring_force(motion))
    }
}
