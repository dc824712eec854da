//! Bound on the energy output of a world's forces, as read from a file.

use palpate_core::{HandLimit, Range};
use palpate_world::{
    LARGEST, Tool, Vector, WorldField, WorldGuard, WorldGuardParams, WorldHandBound,
    WorldHandLimit, WorldPart,
};
use toml::Spanned;

use super::file::Reading;
use super::{WorldDevice, WorldScene};
use crate::guard::{GUARD_RECOVERY, GUARD_SPEED, GuardMode, OF_DEVICE};
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
        recovery: GUARD_RECOVERY,
        ..WorldGuardParams::by_speed(GUARD_SPEED, GUARD_TURNING, WORLD_GUARD_ALLOWANCE)
    }
}

/// Returns the bound of a hand whose other values are those of the devices ([`WorldScene::guard_of_devices`]).
#[must_use]
pub fn hand_guard(limit: HandLimit<f64>) -> WorldHandBound {
    WorldHandBound {
        limit: match limit {
            HandLimit::Acceleration(linear) => WorldHandLimit::Acceleration {
                linear,
                angular: OF_DEVICE,
            },
            HandLimit::Force(force) => WorldHandLimit::Force {
                force,
                torque: OF_DEVICE,
            },
        },
        least_mass: [OF_DEVICE; 3],
        least_inertia: OF_DEVICE,
    }
}

impl WorldScene {
    /// Returns the guard with the quanta of the devices, and half of the least model mass and inertia if no other ones
    /// were given.
    #[must_use]
    pub fn guard_of_devices(&self) -> WorldGuard {
        let largest = |quanta: &mut dyn Iterator<Item = f64>| quanta.fold(0.0, f64::max);
        let quantum = largest(&mut self.devices.iter().flat_map(|device| device.quantum));
        let quantum = self.render.sensor_quantum.unwrap_or(quantum);
        let turnings = || {
            self.devices
                .iter()
                .filter_map(|device| device.turning.as_ref())
        };
        // The quanta are along the axes of the devices, the bound is along those of the world.
        let is_along = self.devices.iter().all(|device| device.own_axes.is_none());
        let across = if is_along { 1.0 } else { 3f64.sqrt() };
        let complete = |params: WorldGuardParams| WorldGuardParams {
            quantum: across * quantum,
            angle_quantum: largest(&mut turnings().map(|turning| turning.quantum)),
            hand: params.hand.map(|hand| self.hand_of_devices(hand)),
            ..params
        };
        match self.render.guard {
            WorldGuard::Off => WorldGuard::Off,
            WorldGuard::Report(params) => WorldGuard::Report(complete(params)),
            WorldGuard::Limit(params) => WorldGuard::Limit(complete(params)),
        }
    }

    /// Returns half of the model mass of each device along each axis as its least mass `[kg]`; an empty list without a
    /// bound by acceleration, and if a least mass is given or unknown.
    #[must_use]
    pub fn guard_masses(&self) -> Vec<Vector> {
        let hand = self.render.guard.params().and_then(|params| params.hand);
        let tools = &self.world.tools;
        let is_unknown = tools.iter().any(|tool| tool.mass_table.is_some());
        if is_unknown || !hand.is_some_and(|hand| hand.least_mass == [OF_DEVICE; 3]) {
            return Vec::new();
        }
        let own = tools.iter().zip(&self.render.device_mass);
        own.map(|(tool, model)| along_world(tool, model).map(half_of))
            .collect()
    }

    fn hand_of_devices(&self, hand: WorldHandBound) -> WorldHandBound {
        let mut mass = [f64::INFINITY; 3];
        for (tool, model) in self.world.tools.iter().zip(&self.render.device_mass) {
            for (mass, model) in mass.iter_mut().zip(along_world(tool, model)) {
                *mass = mass.min(model);
            }
            if tool.mass_table.is_some() {
                // Its least mass has to be given.
                mass = [0.0; 3];
            }
        }
        let inertia = self.render.device_inertia.iter().flatten().flatten();
        let inertia = inertia.copied().fold(f64::INFINITY, f64::min);
        let turns = self.devices.iter().any(|device| device.turning.is_some());
        // The renderer rejects 0: no device determines it.
        let of_turning = if turns { 0.0 } else { 1.0 };
        let or = |given: f64, otherwise: f64| if given == OF_DEVICE { otherwise } else { given };
        WorldHandBound {
            limit: match hand.limit {
                WorldHandLimit::Acceleration { linear, angular } => WorldHandLimit::Acceleration {
                    linear,
                    angular: or(angular, of_turning),
                },
                WorldHandLimit::Force { force, torque } => WorldHandLimit::Force {
                    force,
                    torque: or(torque, of_turning),
                },
            },
            least_mass: [0, 1, 2].map(|axis| or(hand.least_mass[axis], half_of(mass[axis]))),
            least_inertia: or(hand.least_inertia, half_of(inertia)),
        }
    }
}

fn half_of(least: f64) -> f64 {
    (0.5 * least).min(LARGEST)
}

/// Returns the least model mass of a tool along each world axis `[kg]`.
fn along_world(tool: &Tool, model: &Vector) -> Vector {
    if tool.own_axes.is_none() {
        return *model;
    }
    [model.iter().copied().fold(f64::INFINITY, f64::min); 3]
}

impl Reading {
    /// Rejects keys of the hand that exclude or miss each other.
    fn refuse_hand(&mut self, raw: &RawGuard, turns: bool) {
        let (acceleration, force) = (&raw.acceleration_m_per_s2, &raw.hand_force_n);
        let angular = &raw.turning_acceleration_rad_per_s2;
        let torque = &raw.hand_torque_n_m;
        let turned = "turning_acceleration_rad_per_s2, because a device turns";
        let either = "acceleration_m_per_s2 or hand_force_n";
        let is_still = !turns;
        let rules = [
            (
                "acceleration_m_per_s2",
                acceleration,
                is_still || angular.is_some(),
                "needs",
                turned,
            ),
            (
                "hand_force_n",
                force,
                is_still || torque.is_some(),
                "needs",
                "hand_torque_n_m, because a device turns",
            ),
            (
                "hand_force_n",
                force,
                acceleration.is_none(),
                "excludes",
                "acceleration_m_per_s2; remove one",
            ),
            (
                "turning_acceleration_rad_per_s2",
                angular,
                acceleration.is_some(),
                "needs",
                "acceleration_m_per_s2",
            ),
            (
                "hand_torque_n_m",
                torque,
                force.is_some(),
                "needs",
                "hand_force_n",
            ),
            (
                "least_mass_kg",
                &raw.least_mass_kg,
                acceleration.is_some() || force.is_some(),
                "needs",
                either,
            ),
            (
                "least_inertia_kg_m2",
                &raw.least_inertia_kg_m2,
                acceleration.is_some() || force.is_some(),
                "needs",
                either,
            ),
        ];
        if let Some(learned) = &raw.learn_mass {
            let message = "render.guard.learn_mass is for one contact along one axis; remove it";
            self.fault(learned.span(), message);
        }
        for (key, value, is_right, verb, other) in rules {
            if let Some(value) = value
                && !is_right
            {
                self.fault(value.span(), format!("render.guard.{key} {verb} {other}"));
            }
        }
    }

    pub(super) fn guard(&mut self, raw: RawGuard, devices: &[WorldDevice]) -> WorldGuard {
        let usual = usual_guard();
        let turns = devices.iter().any(|device| device.turning.is_some());
        self.refuse_hand(&raw, turns);
        let mut read = |key: &str, field, value: Option<Spanned<f64>>, range| {
            value.map(|value| {
                let checked = self.number(key, value.clone(), range);
                self.places.take(WorldPart::Loop, field, value);
                checked
            })
        };
        let positive = Range::Positive;
        let speed = read(
            "speed_m_per_s",
            WorldField::GuardLargestSpeed,
            raw.speed_m_per_s,
            positive,
        );
        let turning = read(
            "turning_rad_per_s",
            WorldField::GuardLargestTurning,
            raw.turning_rad_per_s,
            positive,
        );
        let allowance = read(
            "allowance_j",
            WorldField::GuardAllowance,
            raw.allowance_j,
            Range::NotNegative,
        );
        let recovery = read(
            "recovery_w",
            WorldField::GuardRecovery,
            raw.recovery_w,
            Range::NotNegative,
        );
        let acceleration = read(
            "acceleration_m_per_s2",
            WorldField::GuardAcceleration,
            raw.acceleration_m_per_s2,
            positive,
        );
        let force = read(
            "hand_force_n",
            WorldField::GuardHandForce,
            raw.hand_force_n,
            positive,
        );
        let torque = read(
            "hand_torque_n_m",
            WorldField::GuardHandTorque,
            raw.hand_torque_n_m,
            positive,
        );
        let angular = read(
            "turning_acceleration_rad_per_s2",
            WorldField::GuardTurning,
            raw.turning_acceleration_rad_per_s2,
            positive,
        );
        let mass = read(
            "least_mass_kg",
            WorldField::GuardMass,
            raw.least_mass_kg,
            positive,
        );
        let inertia = read(
            "least_inertia_kg_m2",
            WorldField::GuardInertia,
            raw.least_inertia_kg_m2,
            positive,
        );
        let limit = match (acceleration, force) {
            (Some(linear), _) => Some(WorldHandLimit::Acceleration {
                linear,
                angular: angular.unwrap_or(OF_DEVICE),
            }),
            (None, Some(force)) => Some(WorldHandLimit::Force {
                force,
                torque: torque.unwrap_or(OF_DEVICE),
            }),
            (None, None) => None,
        };
        let hand = limit.map(|limit| WorldHandBound {
            limit,
            least_mass: [mass.unwrap_or(OF_DEVICE); 3],
            least_inertia: inertia.unwrap_or(OF_DEVICE),
        });
        let params = WorldGuardParams {
            largest_speed: speed.unwrap_or(usual.largest_speed),
            largest_turning: turning.unwrap_or(usual.largest_turning),
            allowance: allowance.unwrap_or(usual.allowance),
            recovery: recovery.unwrap_or(usual.recovery),
            hand,
            late: raw.late_samples.map_or(usual.late, |late| {
                self.places
                    .take(WorldPart::Loop, WorldField::GuardLate, late)
            }),
            ..usual
        };
        raw.mode.get_ref().of_world(params)
    }
}
