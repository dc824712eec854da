//! Bound on the energy output of a world's forces, as read from a file.

use palpate_core::Range;
use palpate_world::{WorldField, WorldGuard, WorldGuardParams, WorldPart};
use toml::Spanned;

use super::file::Reading;
use crate::guard::{GUARD_SPEED, GuardMode};
use crate::render_key::RawGuard;

/// Default angular speed of a guard `[rad/s]`: a brisk wrist.
pub const GUARD_TURNING: f64 = 10.0;
/// Allowance of a world's guard where none is stated `[J]`.
pub const WORLD_GUARD_ALLOWANCE: f64 = 0.05;

impl GuardMode {
    /// The guard of a world by this mode.
    #[must_use]
    pub fn of_world(self, params: WorldGuardParams) -> WorldGuard {
        match self {
            Self::Off => WorldGuard::Off,
            Self::Report => WorldGuard::Report(params),
            Self::Limit => WorldGuard::Limit(params),
        }
    }
}

/// Returns the default guard parameters.
#[must_use]
pub fn usual_guard() -> WorldGuardParams {
    WorldGuardParams {
        largest_speed: GUARD_SPEED,
        largest_turning: GUARD_TURNING,
        allowance: WORLD_GUARD_ALLOWANCE,
        late: 0,
    }
}

impl Reading {
    pub(super) fn guard(&mut self, raw: RawGuard) -> WorldGuard {
        let of_one_contact = [
            ("acceleration_m_per_s2", &raw.acceleration_m_per_s2),
            ("least_mass_kg", &raw.least_mass_kg),
            ("recovery_w", &raw.recovery_w),
        ];
        for (key, value) in of_one_contact {
            if let Some(value) = value {
                let message = format!("render.guard.{key} needs a scene of one contact");
                self.fault(value.span(), message);
            }
        }
        let usual = usual_guard();
        let mut or = |key: &str, field, value: Option<Spanned<f64>>, otherwise, least| {
            value.map_or(otherwise, |value| {
                let checked = self.number(key, value.clone(), least);
                self.places.take(WorldPart::Loop, field, value);
                checked
            })
        };
        let params = WorldGuardParams {
            largest_speed: or(
                "speed_m_per_s",
                WorldField::GuardLargestSpeed,
                raw.speed_m_per_s,
                usual.largest_speed,
                Range::Positive,
            ),
            largest_turning: or(
                "turning_rad_per_s",
                WorldField::GuardLargestTurning,
                raw.turning_rad_per_s,
                usual.largest_turning,
                Range::Positive,
            ),
            allowance: or(
                "allowance_j",
                WorldField::GuardAllowance,
                raw.allowance_j,
                usual.allowance,
                Range::NotNegative,
            ),
            late: raw.late_samples.map_or(usual.late, |late| {
                self.places
                    .take(WorldPart::Loop, WorldField::GuardLate, late)
            }),
        };
        raw.mode.of_world(params)
    }
}
