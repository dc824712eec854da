//! Passivity guard: a bound on the energy that a held force can give out before the next sample.
//!
//! A force is fixed before the user moves. Over one interval it can give out as much as `|f| v T` at a device speed v,
//! however it was computed. A guarantee, in contrast to an estimate, must therefore limit the force itself:
//!
//! ```text
//! |f_i| T <= (balance_i + allowance)/v_max - impulse to come
//! balance_i = what was stored at the start + work of f_V + outside work + port work
//! impulse to come = sum over the commands before of |f| (time left to act) + lag |force now|
//! ```
//!
//! The balance is the energy that may still be given out. Earlier commands have claims on it: those in a delay, and the
//! force that still decays in an actuator with a lag. While the device stays below v_max and samples arrive within the
//! nominal period, the energy given out at the end of an interval with a held force never exceeds the stored energy,
//! the energy supplied by f_V and changes from outside, and the allowance.
//!
//! With a lag or a fraction of a period of delay the force changes between two samples. The port work is then that of
//! the mean force, which is exact for a device that does not reverse its motion in between. The guard uses the delay,
//! lag and gain of [`Actuation`](crate::Actuation), without their deviations.

use crate::Scalar;
use crate::parameter::{Parameter, ParameterError};

/// Mode of the bound on the energy given out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "S: Scalar + serde::Serialize",
        deserialize = "S: Scalar + serde::Deserialize<'de>"
    ))
)]
pub enum Guard<S> {
    /// No bound.
    #[default]
    Off,
    /// Forces beyond the bound are held and reported in [`Limited::guard`](crate::Limited::guard).
    Report(GuardParams<S>),
    /// No force exceeds the bound.
    Limit(GuardParams<S>),
}

/// Parameters of the guard.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "S: Scalar + serde::Serialize",
        deserialize = "S: Scalar + serde::Deserialize<'de>"
    ))
)]
pub struct GuardParams<S> {
    /// Largest device speed for which the bound holds, v_max `[m/s]`, greater than 0.
    pub largest_speed: S,
    /// Energy that may be given out beyond the balance, epsilon `[J]`, not below 0. With 0, a contact without stored
    /// energy could not begin to push.
    pub allowance: S,
}

impl<S: Scalar> Guard<S> {
    /// Returns the parameters outside their range.
    pub(crate) fn faults(&self) -> [Option<ParameterError>; 2] {
        match self {
            Self::Off => [None; 2],
            Self::Report(params) | Self::Limit(params) => [
                Parameter::GuardSpeed.positive(params.largest_speed).err(),
                Parameter::GuardAllowance
                    .not_negative(params.allowance)
                    .err(),
            ],
        }
    }

    /// Returns the largest force `[N]` over one `period` `[s]` from a `balance` `[J]`, with `claims`, the impulse that
    /// earlier commands may still give `[N s]`; and whether the bound is enforced.
    #[inline]
    pub(crate) fn bound(&self, balance: S, claims: S, period: S) -> Option<(S, bool)> {
        let (params, kept) = match self {
            Self::Off => return None,
            Self::Report(params) => (params, false),
            Self::Limit(params) => (params, true),
        };
        let free = (balance + params.allowance) / params.largest_speed - claims;
        Some(((free / period).max(S::ZERO), kept))
    }
}
