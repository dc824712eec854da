//! All methods behind one type, for programs that choose one by name.

use core::fmt;

use super::basic::{Basic, BasicParams};
use super::coupled::{Coupled, CoupledMemory, CoupledParams};
use super::hfcr::{Hfcr, HfcrParams};
use super::method::{Ended, Method, MethodParams, Plan, Situation};
use super::popc::{Popc, PopcParams};
use super::popc_ref::{PopcRef, PopcRefParams};
use super::seh::{Seh, SehMemory, SehParams};
use super::virtual_damper::{VirtualDamper, VirtualDamperParams};
use crate::Scalar;
use crate::contact::{Contact, LoopParams};
use crate::motion::{Displacement, ObjectMotion};
use crate::parameter::{ParameterError, ParameterValue};
use crate::predict::PredictionMemory;

/// Parameters of any method. As a serde value, they stand under the method's name in kebab case.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "S: Scalar + serde::Serialize",
        deserialize = "S: Scalar + serde::Deserialize<'de>"
    ))
)]
pub enum AnyParams<S> {
    /// See [`Basic`].
    Basic,
    /// See [`VirtualDamper`].
    VirtualDamper(VirtualDamperParams<S>),
    /// See [`Seh`].
    Seh(SehParams),
    /// See [`Popc`].
    Popc(PopcParams<S>),
    /// See [`PopcRef`].
    PopcRef(PopcRefParams<S>),
    /// See [`Hfcr`].
    Hfcr(HfcrParams<S>),
    /// See [`Coupled`].
    Coupled(CoupledParams<S>),
}

/// Any method, with checked parameters.
#[derive(Clone, Copy, Debug)]
#[allow(missing_docs)] // each variant is the type of the same name
pub enum AnyMethod<S> {
    Basic(Basic),
    VirtualDamper(VirtualDamper<S>),
    Seh(Seh),
    Popc(Popc<S>),
    PopcRef(PopcRef<S>),
    Hfcr(Hfcr<S>),
    Coupled(Coupled<S>),
}

/// Memory of any method.
#[derive(Clone, Copy, Debug, Default)]
pub struct AnyMemory<S> {
    seh: SehMemory<S>,
    device: PredictionMemory<S>,
    coupled: CoupledMemory<S>,
}

impl<S: Scalar> AnyMemory<S> {
    /// What [`Coupled`] remembers; that of a state that has not been coupled is empty.
    pub fn coupled(&self) -> &CoupledMemory<S> {
        &self.coupled
    }
}

impl<S: Scalar> MethodParams<S> for AnyParams<S> {
    type Method = AnyMethod<S>;

    fn check(self, c: &Contact<S>, l: &LoopParams<S>) -> Result<AnyMethod<S>, ParameterError> {
        Ok(match self {
            Self::Basic => AnyMethod::Basic(BasicParams.check(c, l)?),
            Self::VirtualDamper(params) => AnyMethod::VirtualDamper(params.check(c, l)?),
            Self::Seh(params) => AnyMethod::Seh(params.check(c, l)?),
            Self::Popc(params) => AnyMethod::Popc(params.check(c, l)?),
            Self::PopcRef(params) => AnyMethod::PopcRef(params.check(c, l)?),
            Self::Hfcr(params) => AnyMethod::Hfcr(params.check(c, l)?),
            Self::Coupled(params) => AnyMethod::Coupled(params.check(c, l)?),
        })
    }

    fn name(&self) -> &'static str {
        match self {
            Self::Basic => MethodParams::<S>::name(&BasicParams),
            Self::VirtualDamper(params) => params.name(),
            Self::Seh(params) => MethodParams::<S>::name(params),
            Self::Popc(params) => params.name(),
            Self::PopcRef(params) => params.name(),
            Self::Hfcr(params) => params.name(),
            Self::Coupled(params) => params.name(),
        }
    }

    fn describe(&self, take: &mut dyn FnMut(&'static str, ParameterValue<S>)) {
        match self {
            Self::Basic => BasicParams.describe(take),
            Self::VirtualDamper(params) => params.describe(take),
            Self::Seh(params) => params.describe(take),
            Self::Popc(params) => params.describe(take),
            Self::PopcRef(params) => params.describe(take),
            Self::Hfcr(params) => params.describe(take),
            Self::Coupled(params) => params.describe(take),
        }
    }
}

/// The method and its parameters, in words: `virtual-damper (damping_n_s_per_m 2.5)`.
impl<S: Scalar + fmt::Display> fmt::Display for AnyParams<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())?;
        let (mut result, mut is_first) = (Ok(()), true);
        self.describe(&mut |key, value| {
            let before = if is_first { " (" } else { ", " };
            result = result.and_then(|()| write!(f, "{before}{key} {value}"));
            is_first = false;
        });
        result?;
        if is_first { Ok(()) } else { f.write_str(")") }
    }
}

impl<S: Scalar> Method<S> for AnyMethod<S> {
    type Memory = AnyMemory<S>;

    #[inline]
    fn plan(
        &self,
        motion: &ObjectMotion<S>,
        now: &Situation<'_, S>,
        memory: &mut AnyMemory<S>,
    ) -> Plan<S> {
        match self {
            Self::Basic(method) => method.plan(motion, now, &mut ()),
            Self::VirtualDamper(method) => method.plan(motion, now, &mut memory.device),
            Self::Seh(method) => method.plan(motion, now, &mut memory.seh),
            Self::Popc(method) => method.plan(motion, now, &mut ()),
            Self::PopcRef(method) => method.plan(motion, now, &mut ()),
            Self::Hfcr(method) => method.plan(motion, now, &mut memory.device),
            Self::Coupled(method) => method.plan(motion, now, &mut memory.coupled),
        }
    }

    #[inline]
    fn conclude(
        &self,
        motion: &ObjectMotion<S>,
        ended: &Ended<S>,
        memory: &mut AnyMemory<S>,
    ) -> Displacement<S> {
        match self {
            Self::Coupled(method) => method.conclude(motion, ended, &mut memory.coupled),
            Self::Hfcr(method) => method.conclude(motion, ended, &mut memory.device),
            Self::VirtualDamper(method) => method.conclude(motion, ended, &mut memory.device),
            _ => ended.as_planned(motion),
        }
    }

    #[inline]
    fn begin_anew(&self, memory: &mut AnyMemory<S>, device_known: bool, object_known: bool) {
        match self {
            Self::Coupled(method) => {
                method.begin_anew(&mut memory.coupled, device_known, object_known)
            }
            Self::Seh(method) => method.begin_anew(&mut memory.seh, device_known, object_known),
            Self::Hfcr(method) => method.begin_anew(&mut memory.device, device_known, object_known),
            Self::VirtualDamper(method) => {
                method.begin_anew(&mut memory.device, device_known, object_known)
            }
            _ => {}
        }
    }

    #[inline]
    fn placement_shift(&self, memory: &AnyMemory<S>) -> S {
        match self {
            Self::Coupled(method) => method.placement_shift(&memory.coupled),
            _ => S::ZERO,
        }
    }

    #[inline]
    fn contact_damping(&self) -> S {
        match self {
            Self::VirtualDamper(method) => method.contact_damping(),
            _ => S::ZERO,
        }
    }
}
