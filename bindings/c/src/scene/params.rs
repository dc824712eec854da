//! Parameters of a scene and of its devices.

use palpate_scene::world::{DeviceTurning, TurningHand, WorldDevice, WorldHand};
use palpate_world::IDENTITY;

use crate::choice;
use crate::edge::status;
use crate::loop_params::HoldKind;
use crate::sized::{self, SizedStruct};
use crate::status::{Refusal, Status};

/// The loop of a scene and the settings of methods. palpate_scene_params_default() fills it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct SceneParams {
    /// Size of this struct; palpate_scene_params_default() sets it.
    pub struct_size: usize,
    /// Nominal sampling period, above 0 [s]: 0.001 is 1 ms. It has no default.
    pub period: f64,
    /// Delay from a sample to the start of its command, not below 0 [s]. Default: 0.
    pub delay: f64,
    /// Time constant of the first-order lag after the delay, not below 0 [s]. Default: 0.
    pub lag: f64,
    /// Ratio of delivered to commanded force, above 0. Default: 1.
    pub gain: f64,
    /// Damping of the methods with damping [N s/m]; 0, the default: unset.
    pub damping: f64,
    /// Rotational damping of the methods with damping [N m s/rad].
    pub rotational_damping: f64,
    /// Stiffness of virtual-coupling and god-object [N/m]; 0, the default: unset.
    pub coupling_stiffness: f64,
    /// Proxy mass of virtual-coupling [kg]; 0, the default: unset.
    pub coupling_mass: f64,
    /// Rotational stiffness of virtual-coupling [N m/rad].
    pub coupling_rotational_stiffness: f64,
    /// Proxy moment of inertia of virtual-coupling [kg m^2].
    pub coupling_inertia: f64,
    /// A palpate_hold: what the actuators hold. Default: PALPATE_HOLD_CONSTANT.
    pub hold: u32,
    /// Must be 0.
    pub reserved: u32,
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
            hold: HoldKind::Constant as u32,
            reserved: 0,
        }
    }
}

/// Rejects the first number outside its range.
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
    /// Reads and checks the parameters at `params`.
    ///
    /// # Safety
    /// `params` is NULL or points to parameters whose first field is their size.
    pub(super) unsafe fn at(params: *const Self) -> Result<Self, Refusal<'static>> {
        // SAFETY: guaranteed by the caller.
        let params = unsafe { sized::read(params) }?;
        choice::unused(params.reserved)?;
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

/// Model values of a device. palpate_device_params_default() fills it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct DeviceParams {
    /// Size of this struct; palpate_device_params_default() sets it.
    pub struct_size: usize,
    /// Effective mass along each axis, above 0 [kg]; an error of a factor of 2 is acceptable. It has no default.
    pub mass: [f64; 3],
    /// Quantum of the position sensor along each axis, not below 0 [m]. Default: 0.
    pub quantum: [f64; 3],
    /// Moments of inertia along the tool's axes, above 0 [kg m^2]; for devices that measure six axes.
    pub inertia: [f64; 3],
    /// Quantum of the angles, not below 0 [rad]; for devices that measure six axes. Default: 0.
    pub angle_quantum: f64,
    /// 0, the default: a device of three axes. 1: a device of six axes. 2: a device that measures six axes but gives no
    /// torque, so only the hand rotates the tool.
    pub turns: u32,
    /// Must be 0.
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

/// Value of `turns` for a device that measures six axes but gives no torque.
const BY_HAND: u32 = 2;

impl DeviceParams {
    /// Returns the checked device. Its hand is not simulated.
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
                orientation: IDENTITY,
                angular_velocity: none,
                quantum: self.angle_quantum,
                gives_torque: self.turns != BY_HAND,
                hand: TurningHand {
                    torque: none,
                    stiffness: 0.0,
                    damping: 0.0,
                    rest: IDENTITY,
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
            hand: WorldHand::default(),
            drivetrain: Default::default(),
            turning,
        })
    }
}

/// Fills scene parameters with the defaults. `struct_size` is sizeof(palpate_scene_params).
///
/// # Safety
/// `params` is NULL, or `struct_size` bytes can be written there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_scene_params_init(
    params: *mut SceneParams,
    struct_size: usize,
) -> Status {
    // SAFETY: guaranteed by the caller.
    status(|| unsafe { sized::fill(params, struct_size, SceneParams::default()) })
}

/// Fills device parameters with the defaults. `struct_size` is sizeof(palpate_device_params).
///
/// # Safety
/// `params` is NULL, or `struct_size` bytes can be written there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_device_params_init(
    params: *mut DeviceParams,
    struct_size: usize,
) -> Status {
    // SAFETY: guaranteed by the caller.
    status(|| unsafe { sized::fill(params, struct_size, DeviceParams::default()) })
}
