//! Modes of a guard, and its defaults.

use palpate_core::{Guard, GuardParams};
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

    /// The guard against device speeds up to `largest_speed` `[m/s]`, with an `allowance` `[J]`.
    #[must_use]
    pub fn guard(self, largest_speed: f64, allowance: f64) -> Guard<f64> {
        let params = GuardParams {
            largest_speed,
            allowance,
        };
        match self {
            Self::Off => Guard::Off,
            Self::Report => Guard::Report(params),
            Self::Limit => Guard::Limit(params),
        }
    }
}

/// Default device speed of a guard `[m/s]`: a brisk hand.
pub const GUARD_SPEED: f64 = 1.0;
/// Allowance of a guard where none is stated `[J]`.
pub const GUARD_ALLOWANCE: f64 = 1e-3;
