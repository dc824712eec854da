//! Parameters of a world in addition to its scene.

use core::ffi::c_char;
use core::ptr;

use palpate_rt::safety::SafetyParams;
use palpate_scene::world::WorldScene;

use crate::edge::status;
use crate::sized::{self, SizedStruct};
use crate::status::{Refusal, Status};
use crate::text;

/// Overrides of the rendering parameters of a scene. palpate_world_params_default() fills it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct WorldParams {
    /// Size of this struct; palpate_world_params_default() sets it.
    pub struct_size: usize,
    /// Name of the method, see palpate_world_method_name(). NULL, the default: that of the scene.
    pub method: *const c_char,
    /// Largest norm of the force on each device [N]. INFINITY: no limit, and no torque limit unless one is given. 0,
    /// the default: the limit of the scene, or 20 N, or that of the weakest motor if less.
    pub force_limit: f64,
    /// Largest norm of the torque on each device [N m]. INFINITY: no limit. 0, the default: the limit of the scene,
    /// or 1 N m.
    pub torque_limit: f64,
    /// Ramp time of the force if a start or a recovery is in contact, not below 0 [s]. Default: 0.2.
    pub soft_start: f64,
}

// SAFETY: `repr(C)`, a `usize` first, numbers and raw pointers only.
unsafe impl SizedStruct for WorldParams {
    const NAME: &'static str = "palpate_world_params";
}

impl Default for WorldParams {
    fn default() -> Self {
        Self {
            struct_size: size_of::<Self>(),
            method: ptr::null(),
            force_limit: 0.0,
            torque_limit: 0.0,
            soft_start: SafetyParams::default().soft_start,
        }
    }
}

/// Fills world parameters with the defaults. `struct_size` is sizeof(palpate_world_params).
///
/// # Safety
/// `params` is NULL, or `struct_size` bytes can be written there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_world_params_init(
    params: *mut WorldParams,
    struct_size: usize,
) -> Status {
    // SAFETY: guaranteed by the caller.
    status(|| unsafe { sized::fill(params, struct_size, WorldParams::default()) })
}

/// Checked parameters of a world.
pub(crate) struct Asked {
    pub method: Option<String>,
    /// Infinite: no limit; 0: the limit of the scene.
    force_limit: f64,
    torque_limit: f64,
    soft_start: f64,
}

impl Asked {
    /// Reads and checks the parameters at `params`; NULL means the defaults.
    ///
    /// # Safety
    /// `params` is NULL or points to parameters whose first field is their size.
    pub unsafe fn at<'a>(params: *const WorldParams) -> Result<Self, Refusal<'a>> {
        let params = if params.is_null() {
            WorldParams::default()
        } else {
            // SAFETY: guaranteed by the caller.
            unsafe { sized::read(params) }?
        };
        let method = if params.method.is_null() {
            None
        } else {
            // SAFETY: guaranteed by the caller.
            Some(unsafe { text::read(params.method, "method") }?.to_owned())
        };
        let asked = Self {
            method,
            force_limit: params.force_limit,
            torque_limit: params.torque_limit,
            soft_start: params.soft_start,
        };
        let or_the_scene = "above 0, INFINITY for no limit, or 0 for the scene's";
        let checks = [
            (
                "force_limit",
                asked.force_limit,
                asked.force_limit >= 0.0,
                or_the_scene,
            ),
            (
                "torque_limit",
                asked.torque_limit,
                asked.torque_limit >= 0.0,
                or_the_scene,
            ),
            (
                "soft_start",
                asked.soft_start,
                asked.soft_start >= 0.0 && asked.soft_start.is_finite(),
                "finite and not below 0 [s]",
            ),
        ];
        match checks.into_iter().find(|(_, _, is_right, _)| !is_right) {
            Some((name, given, _, allowed)) => Err(Refusal::Number {
                name,
                given,
                allowed,
            }),
            None => Ok(asked),
        }
    }

    /// Whether the parameters override a limit of the scene.
    pub fn has_limits(&self) -> bool {
        self.force_limit != 0.0 || self.torque_limit != 0.0
    }

    /// Returns the limits of each device and sets them in `scene`, too: the renderer knows about limits that it
    /// applies itself, so no sent force has to be reported back. `palpate pipe` uses the same limits.
    pub fn limits(&self, scene: &mut WorldScene) -> SafetyParams {
        let default = SafetyParams::default();
        let asked = |number: f64| (number != 0.0).then_some(number);
        scene.settle_limits(
            [asked(self.force_limit), asked(self.torque_limit)],
            [default.largest_force, default.largest_torque],
        );
        // No speed limit: the caller's loop knows its device, and the renderer reports implausible samples as faults.
        SafetyParams::bounding(
            scene.render.force_limit,
            scene.render.torque_limit,
            self.soft_start,
        )
    }
}
