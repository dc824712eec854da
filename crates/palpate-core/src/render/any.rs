//! One type for all methods, for programs that select one by name.

use core::fmt;

use super::basic::{Basic, BasicParams};
use super::list::for_all_methods;
use super::method::{Ended, Method, MethodParams, Plan, Situation};
use crate::Scalar;
use crate::contact::{Contact, LoopParams};
use crate::motion::{Displacement, ObjectMotion};
use crate::parameter::{ParameterError, ParameterValue};
use crate::render::predict::PredictionMemory;

/// Memory of a method within that of any method: a field, or nothing.
macro_rules! part {
    ($memory:ident) => {
        ()
    };
    ($memory:ident $field:ident) => {
        $memory.$field
    };
}

macro_rules! any {
    ($(
        $Variant:ident($Params:ty, $Method:ty)
        $(shares $shared:ident)?
        $(remembers $own:ident: $Memory:ty)?,
        named $($Name:ident = $file:ident::$INFO:ident),+;
    )*) => {
// Public items of a method's file are public in the crate.
$($(
    #[allow(unused_imports)]
    pub use super::$file::*;
)+)*

/// Parameters of any method. As a serde value, the method's name in kebab case is the key.
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
#[non_exhaustive]
pub enum AnyParams<S> {
    /// See [`Basic`].
    Basic,
    $(
        #[doc = concat!("See [`", stringify!($Variant), "`].")]
        $Variant($Params),
    )*
}

/// Any method, with checked parameters.
#[derive(Clone, Copy, Debug)]
#[allow(missing_docs)] // each variant is the type of the same name
#[non_exhaustive]
pub enum AnyMethod<S> {
    Basic(Basic),
    $($Variant($Method),)*
}

/// Memory of any method.
#[derive(Clone, Copy, Debug, Default)]
pub struct AnyMemory<S> {
    $($($own: $Memory,)?)*
}

impl<S: Scalar> MethodParams<S> for AnyParams<S> {
    type Method = AnyMethod<S>;

    fn check(self, c: &Contact<S>, l: &LoopParams<S>) -> Result<AnyMethod<S>, ParameterError> {
        Ok(match self {
            Self::Basic => AnyMethod::Basic(BasicParams.check(c, l)?),
            $(Self::$Variant(params) => AnyMethod::$Variant(params.check(c, l)?),)*
        })
    }

    fn name(&self) -> &'static str {
        match self {
            Self::Basic => MethodParams::<S>::name(&BasicParams),
            $(Self::$Variant(params) => MethodParams::<S>::name(params),)*
        }
    }

    fn describe(&self, take: &mut dyn FnMut(&'static str, ParameterValue<S>)) {
        match self {
            Self::Basic => BasicParams.describe(take),
            $(Self::$Variant(params) => params.describe(take),)*
        }
    }

    fn derived(self, method: &AnyMethod<S>) -> Self {
        match (self, method) {
            $((Self::$Variant(params), AnyMethod::$Variant(method)) => {
                Self::$Variant(MethodParams::<S>::derived(params, method))
            })*
            (params, _) => params,
        }
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
            $(Self::$Variant(method) => {
                method.plan(motion, now, &mut part!(memory $($own)? $($shared)?))
            })*
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
            Self::Basic(method) => method.conclude(motion, ended, &mut ()),
            $(Self::$Variant(method) => {
                method.conclude(motion, ended, &mut part!(memory $($own)? $($shared)?))
            })*
        }
    }

    #[inline]
    fn begin_anew(&self, memory: &mut AnyMemory<S>, device_known: bool, object_known: bool) {
        match self {
            Self::Basic(_) => {}
            $(Self::$Variant(method) => {
                let memory = &mut part!(memory $($own)? $($shared)?);
                Method::<S>::begin_anew(method, memory, device_known, object_known);
            })*
        }
    }

    #[inline]
    fn proxy_shift(&self, memory: &AnyMemory<S>) -> S {
        match self {
            Self::Basic(_) => S::ZERO,
            $(Self::$Variant(method) => {
                method.proxy_shift(&part!(memory $($own)? $($shared)?))
            })*
        }
    }

    #[inline]
    fn lateness(&self, memory: &AnyMemory<S>) -> S {
        match self {
            Self::Basic(_) => S::ZERO,
            $(Self::$Variant(method) => method.lateness(&part!(memory $($own)? $($shared)?)),)*
        }
    }

    #[inline]
    fn is_limited(&self, memory: &AnyMemory<S>) -> bool {
        match self {
            Self::Basic(_) => false,
            $(Self::$Variant(method) => {
                Method::<S>::is_limited(method, &part!(memory $($own)? $($shared)?))
            })*
        }
    }

    #[inline]
    fn plans_lines(&self) -> bool {
        match self {
            Self::Basic(_) => false,
            $(Self::$Variant(method) => Method::<S>::plans_lines(method),)*
        }
    }

    #[inline]
    fn slope(&self, memory: &AnyMemory<S>) -> S {
        match self {
            Self::Basic(_) => S::ZERO,
            $(Self::$Variant(method) => method.slope(&part!(memory $($own)? $($shared)?)),)*
        }
    }

    #[inline]
    fn device_acceleration(&self, memory: &AnyMemory<S>) -> S {
        match self {
            Self::Basic(_) => S::ZERO,
            $(Self::$Variant(method) => {
                method.device_acceleration(&part!(memory $($own)? $($shared)?))
            })*
        }
    }

    #[inline]
    fn yields_to_limit(&self) -> bool {
        match self {
            Self::Basic(_) => false,
            $(Self::$Variant(method) => Method::<S>::yields_to_limit(method),)*
        }
    }

    #[inline]
    fn contact_damping(&self) -> S {
        match self {
            Self::Basic(_) => S::ZERO,
            $(Self::$Variant(method) => method.contact_damping(),)*
        }
    }
}
    };
}
for_all_methods!(any);

impl<S: Scalar> AnyMemory<S> {
    /// Returns the memory of [`Coupled`]; it is empty if the state was never coupled.
    pub fn coupled(&self) -> &CoupledMemory<S> {
        &self.coupled
    }
}

/// Writes the method and its parameters: `virtual-damper (damping_n_s_per_m 2.5)`.
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
