//! What a caller says of a scene and of its devices.

use palpate_scene::world::{DeviceTurning, TurningHand, WorldDevice, WorldHand};
use palpate_world::NOT_TURNED;

use crate::choice;
use crate::edge::status;
use crate::sized::{self, SizedStruct};
use crate::status::{Refusal, Status};

/// The loop of a scene, and what methods have for settings. palpate_scene_params_default() fills it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct SceneParams {
    /// Size of this struct; palpate_scene_params_default() sets it.
    pub struct_size: usize,
    /// Nominal time from sample to sample, above 0 [s]: 0.001 is 1 ms. It has no default.
    pub period: f64,
    /// Time from a sample to the moment at which its command begins to act, not below 0 [s]. Default: 0.
    pub delay: f64,
    /// Time constant of a first-order lag after it, not below 0 [s]. Default: 0.
    pub lag: f64,
    /// Delivered over commanded force, above 0. Default: 1.
    pub gain: f64,
    /// Damping of the methods that damp [N s/m]; 0, the default: not said.
    pub damping: f64,
    /// The same of turning [N m s/rad].
    pub rotational_damping: f64,
    /// Stiffness of virtual-coupling and god-object [N/m]; 0, the default: not said.
    pub coupling_stiffness: f64,
    /// Mass of the avatar of virtual-coupling [kg]; 0, the default: not said.
    pub coupling_mass: f64,
    /// The stiffness of its turning [N m/rad].
    pub coupling_rotational_stiffness: f64,
    /// The moment of inertia of its avatar [kg m^2].
    pub coupling_inertia: f64,
}

// SAFETY: `repr(C)`, a `usize` first, numbers only.
unsafe impl SizedStruct for SceneParams {
    const NAME: &'static str = "palpate_scene_params";
}

impl Default for SceneParams {
    fn default() -> Self {
        Self {
            struct_size: size_of::<Self>(),
            period: 0.0,
            delay: 0.0,
            lag: 0.0,
            gain: 1.0,
            damping: 0.0,
            rotational_damping: 0.0,
            coupling_stiffness: 0.0,
            coupling_mass: 0.0,
            coupling_rotational_stiffness: 0.0,
            coupling_inertia: 0.0,
        }
    }
}

/// Refuses the first number that is not as it is allowed.
pub(crate) fn check(numbers: &[(&'static str, f64, bool)]) -> Result<(), Refusal<'static>> {
    for &(name, given, is_above_0) in numbers {
        let is_right = given.is_finite() && (given > 0.0 || (given == 0.0 && !is_above_0));
        if !is_right {
            let allowed = if is_above_0 {
                "finite and greater than 0"
            } else {
                "finite and not below 0"
            };
            return Err(Refusal::Number {
                name,
                given,
                allowed,
            });
        }
    }
    Ok(())
}

impl SceneParams {
    /// What stands at `params`, checked.
    ///
    /// # Safety
    /// `params` is NULL or to parameters of the size that they begin with.
    pub(super) unsafe fn at(params: *const Self) -> Result<Self, Refusal<'static>> {
        // SAFETY: as the caller says.
        let params = unsafe { sized::read(params) }?;
        check(&[
            ("period", params.period, true),
            ("delay", params.delay, false),
            ("lag", params.lag, false),
            ("gain", params.gain, true),
            ("damping", params.damping, false),
            ("rotational_damping", params.rotational_damping, false),
            ("coupling_stiffness", params.coupling_stiffness, false),
            ("coupling_mass", params.coupling_mass, false),
            (
                "coupling_rotational_stiffness",
                params.coupling_rotational_stiffness,
                false,
            ),
            ("coupling_inertia", params.coupling_inertia, false),
        ])?;
        Ok(params)
    }
}

/// A device, as the renderer is told it. palpate_device_params_default() fills it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct DeviceParams {
    /// Size of this struct; palpate_device_params_default() sets it.
    pub struct_size: usize,
    /// Effective mass along each axis, above 0 [kg]; a factor of 2 is near enough. It has no default.
    pub mass: [f64; 3],
    /// Quantum of the position sensor along each axis, not below 0 [m]. Default: 0.
    pub quantum: [f64; 3],
    /// Of a device that measures six axes, its moments of inertia along the tool's axes, above 0 [kg m^2].
    pub inertia: [f64; 3],
    /// Of a device that measures six axes, the quantum of its angles, not below 0 [rad]. Default: 0.
    pub angle_quantum: f64,
    /// 1: a device of six axes. 2: one that measures six axes and gives no torque, so that its hand alone turns the tool. 0, the
    /// default: one of three.
    pub turns: u32,
    /// 0.
    pub reserved: u32,
}

// SAFETY: `repr(C)`, a `usize` first, numbers only.
unsafe impl SizedStruct for DeviceParams {
    const NAME: &'static str = "palpate_device_params";
}

impl Default for DeviceParams {
    fn default() -> Self {
        Self {
            struct_size: size_of::<Self>(),
            mass: [0.0; 3],
            quantum: [0.0; 3],
            inertia: [0.0; 3],
            angle_quantum: 0.0,
            turns: 0,
            reserved: 0,
        }
    }
}

/// What `turns` is of a device that gives no torque.
const BY_HAND: u32 = 2;

impl DeviceParams {
    /// The device, checked. Nobody simulates its hand.
    pub(super) fn device(&self) -> Result<WorldDevice, Refusal<'static>> {
        for axis in 0..3 {
            check(&[
                ("mass", self.mass[axis], true),
                ("quantum", self.quantum[axis], false),
            ])?;
        }
        let none = [0.0; 3];
        choice::unused(self.reserved)?;
        if self.turns > BY_HAND {
            return Err(Refusal::Choice {
                name: "turns",
                given: self.turns,
                allowed: "0, 1 or 2",
            });
        }
        let turning = if self.turns == 0 {
            None
        } else {
            for moment in self.inertia {
                check(&[("inertia", moment, true)])?;
            }
            check(&[("angle_quantum", self.angle_quantum, false)])?;
            Some(DeviceTurning {
                inertia: self.inertia,
                orientation: NOT_TURNED,
                angular_velocity: none,
                quantum: self.angle_quantum,
                gives_torque: self.turns != BY_HAND,
                hand: TurningHand {
                    torque: none,
                    stiffness: 0.0,
                    damping: 0.0,
                    rest: NOT_TURNED,
                    tremor: Default::default(),
                },
            })
        };
        Ok(WorldDevice {
            own_axes: None,
            mass: self.mass,
            position: none,
            velocity: none,
            quantum: self.quantum,
            hand: WorldHand {
                force: none,
                stiffness: 0.0,
                damping: 0.0,
                rest: none,
                tremor: Default::default(),
            },
            turning,
        })
    }
}

/// Fills parameters of a scene with the defaults. `struct_size` is sizeof(palpate_scene_params).
///
/// # Safety
/// `params` is NULL, or `struct_size` bytes can be written there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_scene_params_init(
    params: *mut SceneParams,
    struct_size: usize,
) -> Status {
    // SAFETY: as the caller says.
    status(|| unsafe { sized::fill(params, struct_size, SceneParams::default()) })
}

/// Fills parameters of a device with the defaults. `struct_size` is sizeof(palpate_device_params).
///
/// # Safety
/// `params` is NULL, or `struct_size` bytes can be written there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_device_params_init(
    params: *mut DeviceParams,
    struct_size: usize,
) -> Status {
    // SAFETY: as the caller says.
    status(|| unsafe { sized::fill(params, struct_size, DeviceParams::default()) })
}
