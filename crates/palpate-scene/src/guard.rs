//! Modes of a guard, and its defaults.

use palpate_core::{Guard, GuardParams, HandBound, HandLimit};
use serde::Deserialize;

/// Action of a guard on a force beyond its bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum GuardMode {
    /// There is no guard.
    Off,
    /// Reports it.
    Report,
    /// Limits the force to the bound.
    Limit,
}

impl GuardMode {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Off, Self::Report, Self::Limit];

    /// Its name in files, flags and arguments.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Report => "report",
            Self::Limit => "limit",
        }
    }

    /// Returns the mode with that name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|mode| mode.name() == name)
    }

    /// Returns the guard of one contact with these bounds.
    #[must_use]
    pub fn guard(self, bounds: GuardBounds) -> Guard<f64> {
        let hand = hand_limit(bounds.acceleration, bounds.hand_force).map(|limit| HandBound {
            limit,
            least_mass: bounds.least_mass.unwrap_or(OF_DEVICE),
            learns_mass: bounds.learns_mass,
        });
        let usual = if hand.is_some() {
            HAND_GUARD_ALLOWANCE
        } else {
            GUARD_ALLOWANCE
        };
        let params = GuardParams {
            largest_speed: bounds.speed.unwrap_or(GUARD_SPEED),
            allowance: bounds.allowance.unwrap_or(usual),
            quantum: 0.0,
            recovery: bounds.recovery.unwrap_or(GUARD_RECOVERY),
            hand,
        };
        match self {
            Self::Off => Guard::Off,
            Self::Report => Guard::Report(params),
            Self::Limit => Guard::Limit(params),
        }
    }
}

/// Bounds of the guard of one contact; `None`: the default.
#[derive(Clone, Copy, Debug, Default)]
pub struct GuardBounds {
    /// Largest device speed `[m/s]`.
    pub speed: Option<f64>,
    /// Energy allowance `[J]`.
    pub allowance: Option<f64>,
    /// Largest acceleration of the device by everything except the rendered force `[m/s^2]`. `None`: no bound.
    pub acceleration: Option<f64>,
    /// Largest force on the device by everything except the rendered force `[N]`, instead of the acceleration.
    pub hand_force: Option<f64>,
    /// Least mass of the device `[kg]`. `None`: half of its model mass.
    pub least_mass: Option<f64>,
    /// Whether the motion may raise the least mass, with a bound of the hand.
    pub learns_mass: bool,
    /// Power of the recovery `[W]`.
    pub recovery: Option<f64>,
}

impl GuardBounds {
    /// Returns the conflict of the bounds of the hand, if any.
    #[must_use]
    pub fn conflict(&self) -> Option<GuardConflict> {
        match (self.acceleration, self.hand_force) {
            (Some(_), Some(_)) => Some(GuardConflict::TwoLimits),
            (None, None) if self.least_mass.is_some() || self.learns_mass => {
                Some(GuardConflict::MassAlone)
            }
            _ => None,
        }
    }
}

/// Conflict of the bounds of a hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GuardConflict {
    /// An acceleration and a force of the hand.
    TwoLimits,
    /// A least mass, or one that is learned, without an acceleration or a force of the hand.
    MassAlone,
}

/// Returns the limit of the hand, of which at most one is given.
#[must_use]
pub fn hand_limit(acceleration: Option<f64>, force: Option<f64>) -> Option<HandLimit<f64>> {
    let by_force = force.map(HandLimit::Force);
    acceleration.map(HandLimit::Acceleration).or(by_force)
}

/// Returns the guard with the quantum `[m]` of a device, and half of its model mass `[kg]` as least mass if no other
/// one was given.
#[must_use]
pub fn guard_of_device(guard: Guard<f64>, device_mass: Option<f64>, quantum: f64) -> Guard<f64> {
    let complete = |params: GuardParams<f64>| GuardParams {
        hand: params.hand.map(|hand| HandBound {
            least_mass: match device_mass {
                _ if hand.least_mass != OF_DEVICE => hand.least_mass,
                Some(mass) => 0.5 * mass,
                // The renderer rejects it.
                None => 0.0,
            },
            ..hand
        }),
        quantum,
        ..params
    };
    match guard {
        Guard::Off => Guard::Off,
        Guard::Report(params) => Guard::Report(complete(params)),
        Guard::Limit(params) => Guard::Limit(complete(params)),
    }
}

/// Placeholder for a least mass or inertia that the devices determine.
pub(crate) const OF_DEVICE: f64 = f64::NEG_INFINITY;

/// Default device speed of a guard `[m/s]`: a brisk hand.
pub const GUARD_SPEED: f64 = 1.0;
/// Allowance of a guard where none is stated `[J]`.
pub const GUARD_ALLOWANCE: f64 = 1e-3;
/// Allowance of a guard with a bound on the acceleration where none is stated `[J]`.
pub const HAND_GUARD_ALLOWANCE: f64 = 0.02;
/// Default power by which a guard forgives energy that may have been given out unnoticed `[W]`.
pub const GUARD_RECOVERY: f64 = 0.02;
