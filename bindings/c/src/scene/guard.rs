//! Guard of a scene: the bound on the energy that the forces of its world give out.

use palpate_core::HandLimit;
use palpate_scene::GuardMode;
use palpate_scene::world::{hand_guard, usual_guard};
use palpate_world::{MAX_LATE, WorldGuardParams, WorldHandBound, WorldHandLimit};

use super::{Scene, at, check, wrong};
use crate::edge::status;
use crate::loop_params::GuardKind;
use crate::sized::{self, SizedStruct};
use crate::status::{Refusal, Status};

/// Guard of a world. palpate_guard_params_default() fills it. The values of the hand are 0 by default: the guard
/// bounds by speed only.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct GuardParams {
    /// Size of this struct; palpate_guard_params_default() sets it.
    pub struct_size: usize,
    /// Largest speed of each device for which the bound holds, above 0 [m/s]. Default: 1.
    pub speed: f64,
    /// Largest angular speed of each device that turns, above 0 [rad/s]. Default: 10.
    pub turning_speed: f64,
    /// Energy that the guard allows beyond the energy balance, not below 0 [J]. Default: 0.05.
    pub allowance: f64,
    /// Power by which the guard forgives energy that may have been given out unnoticed, not below 0 [W]. Default: 0.02.
    pub recovery: f64,
    /// Largest acceleration of a device by everything except the rendered force [m/s^2]. It excludes hand_force.
    pub acceleration: f64,
    /// Largest angular acceleration of a device that turns [rad/s^2], with acceleration.
    pub turning_acceleration: f64,
    /// Largest force on a device by everything except the rendered force [N].
    pub hand_force: f64,
    /// Largest torque on a device that turns by everything except the rendered torque [N m], with hand_force.
    pub hand_torque: f64,
    /// Least mass of each device along each axis [kg]. 0: half of its model mass.
    pub least_mass: f64,
    /// Least moment of inertia of each device that turns [kg m^2]. 0: half of the least model inertia.
    pub least_inertia: f64,
    /// Delay of the forces beyond that of the scene, in samples, at most 8; 0 with a bound of the hand. Default: 0.
    pub late_samples: u32,
    /// A palpate_guard. Default: PALPATE_GUARD_LIMIT.
    pub mode: u32,
}

// SAFETY: `repr(C)`, a `usize` first, numbers only.
unsafe impl SizedStruct for GuardParams {
    const NAME: &'static str = "palpate_guard_params";
}

impl Default for GuardParams {
    fn default() -> Self {
        let usual = usual_guard();
        Self {
            struct_size: size_of::<Self>(),
            speed: usual.largest_speed,
            turning_speed: usual.largest_turning,
            allowance: usual.allowance,
            recovery: usual.recovery,
            acceleration: 0.0,
            turning_acceleration: 0.0,
            hand_force: 0.0,
            hand_torque: 0.0,
            least_mass: 0.0,
            least_inertia: 0.0,
            late_samples: 0,
            mode: GuardKind::Limit as u32,
        }
    }
}

impl GuardParams {
    /// Returns the bound of the hand, whose other values are those of the devices.
    fn hand(&self) -> Result<Option<WorldHandBound>, Refusal<'static>> {
        let only_with = |name, given: f64, other: f64, allowed| match (given != 0.0, other != 0.0) {
            (true, false) => Err(Refusal::Number {
                name,
                given,
                allowed,
            }),
            _ => Ok(()),
        };
        let (acceleration, force) = (self.acceleration, self.hand_force);
        if acceleration != 0.0 && force != 0.0 {
            return Err(Refusal::Number {
                name: "hand_force",
                given: force,
                allowed: "0 if acceleration is given",
            });
        }
        let turning = self.turning_acceleration;
        let hand = acceleration + force;
        let alone = "0 without acceleration or hand_force";
        only_with(
            "turning_acceleration",
            turning,
            acceleration,
            "0 without acceleration",
        )?;
        only_with(
            "hand_torque",
            self.hand_torque,
            force,
            "0 without hand_force",
        )?;
        only_with("least_mass", self.least_mass, hand, alone)?;
        only_with("least_inertia", self.least_inertia, hand, alone)?;
        let limit = match (acceleration != 0.0, force != 0.0) {
            (false, false) => return Ok(None),
            (true, _) => HandLimit::Acceleration(acceleration),
            (false, true) => HandLimit::Force(force),
        };
        let given = |number: f64, usual: f64| if number == 0.0 { usual } else { number };
        let usual = hand_guard(limit);
        Ok(Some(WorldHandBound {
            limit: match usual.limit {
                WorldHandLimit::Acceleration { linear, angular } => WorldHandLimit::Acceleration {
                    linear,
                    angular: given(turning, angular),
                },
                WorldHandLimit::Force { force, torque } => WorldHandLimit::Force {
                    force,
                    torque: given(self.hand_torque, torque),
                },
            },
            least_mass: usual.least_mass.map(|mass| given(self.least_mass, mass)),
            least_inertia: given(self.least_inertia, usual.least_inertia),
        }))
    }
}

/// Sets the guard of a scene, which worlds created from it have. It replaces an earlier guard.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_scene_set_guard(
    scene: *mut Scene,
    params: *const GuardParams,
) -> Status {
    status(|| {
        // SAFETY: guaranteed by the caller.
        let (scene, params) = unsafe { (at(scene)?, sized::read(params)?) };
        check(&[
            ("speed", params.speed, true),
            ("turning_speed", params.turning_speed, true),
            ("allowance", params.allowance, false),
            ("recovery", params.recovery, false),
            ("acceleration", params.acceleration, false),
            ("turning_acceleration", params.turning_acceleration, false),
            ("hand_force", params.hand_force, false),
            ("hand_torque", params.hand_torque, false),
            ("least_mass", params.least_mass, false),
            ("least_inertia", params.least_inertia, false),
        ])?;
        let late = usize::try_from(params.late_samples).unwrap_or(usize::MAX);
        if late > MAX_LATE {
            return Err(wrong(std::format!(
                "late_samples is {late}, but must be at most {MAX_LATE}"
            )));
        }
        let mode = match params.mode {
            0 => GuardMode::Off,
            1 => GuardMode::Report,
            2 => GuardMode::Limit,
            given => return Err(GuardKind::unknown("mode", given)),
        };
        let guard = mode.of_world(WorldGuardParams {
            largest_speed: params.speed,
            largest_turning: params.turning_speed,
            allowance: params.allowance,
            recovery: params.recovery,
            late,
            hand: params.hand()?,
            ..usual_guard()
        });
        scene.edit().render.guard = guard;
        Ok(())
    })
}

/// Fills guard parameters with the defaults. `struct_size` is sizeof(palpate_guard_params).
///
/// # Safety
/// `params` is NULL, or `struct_size` bytes can be written there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_guard_params_init(
    params: *mut GuardParams,
    struct_size: usize,
) -> Status {
    // SAFETY: guaranteed by the caller.
    status(|| unsafe { sized::fill(params, struct_size, GuardParams::default()) })
}
