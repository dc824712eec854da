//! What a caller says of a world beside its scene.

use core::ffi::c_char;
use core::ptr;

use palpate_rt::safety::SafetyParams;
use palpate_scene::world::WorldRender;

use crate::edge::status;
use crate::sized::{self, SizedStruct};
use crate::status::{Refusal, Status};
use crate::text;

/// How a world is rendered, where that is not as its scene says. palpate_world_params_default() fills it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct WorldParams {
    /// Size of this struct; palpate_world_params_default() sets it.
    pub struct_size: usize,
    /// Name of the method: basic, virtual-damper, virtual-coupling, god-object or coupled. NULL, the default: the scene's.
    pub method: *const c_char,
    /// Largest force on each device, by its norm [N]. INFINITY: no limit, and none of the torque unless one is given. 0,
    /// the default: the scene's, or 20 N where it has none.
    pub force_limit: f64,
    /// Largest torque on each device, by its norm [N m]. INFINITY: no limit. 0, the default: the scene's, or 1 N m where
    /// it has none.
    pub torque_limit: f64,
    /// Time over which a force comes in where a start or a recovery finds contact, not below 0 [s]. Default: 0.2.
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

/// Fills parameters of a world with the defaults. `struct_size` is sizeof(palpate_world_params).
///
/// # Safety
/// `params` is NULL, or `struct_size` bytes can be written there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_world_params_init(
    params: *mut WorldParams,
    struct_size: usize,
) -> Status {
    // SAFETY: as the caller says.
    status(|| unsafe { sized::fill(params, struct_size, WorldParams::default()) })
}

/// What was asked for, read and checked.
pub(crate) struct Asked {
    pub method: Option<String>,
    /// Infinite: none; 0: what the scene says.
    force_limit: f64,
    torque_limit: f64,
    soft_start: f64,
}

impl Asked {
    /// What stands at `params`; the defaults where that is NULL.
    ///
    /// # Safety
    /// `params` is NULL or to parameters of the size that they begin with.
    pub unsafe fn at<'a>(params: *const WorldParams) -> Result<Self, Refusal<'a>> {
        let params = if params.is_null() {
            WorldParams::default()
        } else {
            // SAFETY: as the caller says.
            unsafe { sized::read(params) }?
        };
        let method = if params.method.is_null() {
            None
        } else {
            // SAFETY: as the caller says.
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

    /// Whether it has a limit of its own.
    pub fn has_limits(&self) -> bool {
        self.force_limit != 0.0 || self.torque_limit != 0.0
    }

    /// The limits of each device, which are put into `render` too: what the renderer limits by itself needs no sending
    /// back. As `palpate pipe` has them.
    pub fn limits(&self, render: &mut WorldRender) -> SafetyParams {
        let default = SafetyParams::default();
        let asked = |number: f64| (number != 0.0).then_some(number);
        render.settle_limits(
            [asked(self.force_limit), asked(self.torque_limit)],
            [default.largest_force, default.largest_torque],
        );
        // The caller's loop knows its device; what a renderer does not believe is a fault.
        SafetyParams::bounding(render.force_limit, render.torque_limit, self.soft_start)
    }
}
