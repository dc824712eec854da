//! Parameters of a local model.

use palpate_core::Actuation;
use palpate_rt::safety::SafetyParams;
use palpate_world::engine::local::{LocalParams as Room, LocalRenderer};
use palpate_world::{CoupledParams, Shape, Tool, WorldLoop};

use crate::edge::status;
use crate::scene::check;
use crate::sized::{self, SizedStruct};
use crate::status::{Refusal, Status};

/// The loop, its device, and capacities for the published model. palpate_local_params_default() fills it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LocalParams {
    /// Size of this struct; palpate_local_params_default() sets it.
    pub struct_size: usize,
    /// Nominal sampling period of the loop, above 0 [s]: 0.001 is 1 ms. It has no default.
    pub period: f64,
    /// Effective mass of the device along each world axis, above 0 [kg]; an error of a factor of 2 is acceptable.
    /// INFINITY: the device lacks this axis. It has no default.
    pub device_mass: [f64; 3],
    /// Radius of the spherical tool, not below 0 [m]. Default: 0, a point.
    pub tool_radius: f64,
    /// Age of the newest model beyond which its contacts fade [s]: 1 to 1000 periods of the loop. Default: 0.2.
    pub stale_after: f64,
    /// Time over which these contacts fade out, or back in, above 0 [s]. Default: 0.1.
    pub fade: f64,
    /// Time over which changes of an active contact are blended in, above 0 [s]. Default: 0.01.
    pub settle: f64,
    /// Time over which the loop's copy of a body returns to the simulator's body, above 0 [s]. Default: 1.
    pub return_time: f64,
    /// Quantum of the position sensor, not below 0 [m]. Default: 0.
    pub quantum: f64,
    /// Delay from a sample to the start of its command, not below 0 [s]. Default: 0.
    pub delay: f64,
    /// Time constant of the first-order lag after the delay, not below 0 [s]. Default: 0.
    pub lag: f64,
    /// Ratio of delivered to commanded force, above 0. Default: 1.
    pub gain: f64,
    /// Largest force on the device, by its norm, above 0 [N]. INFINITY: no limit. Default: 20.
    pub force_limit: f64,
    /// Ramp time of the force if a start or a recovery is in contact, not below 0 [s]. Default: 0.2.
    pub soft_start: f64,
    /// Number of the simulator's bodies, at most 16. 0, the default: contacts only with fixed surfaces.
    pub bodies: u32,
    /// Largest number of contacts of a model, 1 to 64. Default: 8.
    pub contacts: u32,
}

// SAFETY: `repr(C)`, a `usize` first, numbers only.
unsafe impl SizedStruct for LocalParams {
    const NAME: &'static str = "palpate_local_params";
}

impl Default for LocalParams {
    fn default() -> Self {
        let room = Room::new(0, 1);
        let limits = SafetyParams::default();
        Self {
            struct_size: size_of::<Self>(),
            period: 0.0,
            device_mass: [0.0; 3],
            tool_radius: 0.0,
            stale_after: room.stale_after,
            fade: room.fade,
            settle: room.settle,
            return_time: room.return_time,
            quantum: 0.0,
            delay: 0.0,
            lag: 0.0,
            gain: 1.0,
            force_limit: limits.largest_force,
            soft_start: limits.soft_start,
            bodies: 0,
            contacts: 8,
        }
    }
}

/// Fills local-model parameters with the defaults. `struct_size` is sizeof(palpate_local_params).
///
/// # Safety
/// `params` is NULL, or `struct_size` bytes can be written there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_local_params_init(
    params: *mut LocalParams,
    struct_size: usize,
) -> Status {
    // SAFETY: guaranteed by the caller.
    status(|| unsafe { sized::fill(params, struct_size, LocalParams::default()) })
}

impl LocalParams {
    /// Returns the renderer after checking all parameters.
    pub(super) fn renderer(&self) -> Result<LocalRenderer, Refusal<'static>> {
        let above_0 = |name, given: f64, allowed| {
            if given > 0.0 {
                Ok(())
            } else {
                Err(Refusal::Number {
                    name,
                    given,
                    allowed,
                })
            }
        };
        let (period, limit) = (self.period, self.force_limit);
        check(&[("period", period, true)])?;
        above_0("force_limit", limit, "above 0, or INFINITY for no limit")?;
        for mass in self.device_mass {
            above_0(
                "device_mass",
                mass,
                "greater than 0, or INFINITY for an axis that the device lacks",
            )?;
        }
        if self.device_mass == [f64::INFINITY; 3] {
            return Err(Refusal::Numbers(
                "device_mass is INFINITY along each axis, but the device must have one".into(),
            ));
        }
        let shape = Shape::Sphere {
            radius: self.tool_radius,
        };
        let mut tool = Tool::new("tool", shape);
        tool.axes = self.device_mass.map(f64::is_finite);
        let room = Room {
            stale_after: self.stale_after,
            fade: self.fade,
            settle: self.settle,
            return_time: self.return_time,
            ..Room::new(self.bodies as usize, self.contacts as usize)
        };
        let loop_params = WorldLoop::new(period).with_actuation(Actuation {
            delay: self.delay,
            lag: self.lag,
            gain: self.gain,
            ..Actuation::default()
        });
        let loop_params = if limit.is_finite() {
            loop_params.with_force_limits(vec![limit])
        } else {
            loop_params
        };
        let coupled = CoupledParams::new(vec![self.device_mass]).with_encoder_quantum(self.quantum);
        LocalRenderer::new(&[tool], room, loop_params, coupled)
            .map_err(|faults| Refusal::Numbers(faults.to_string()))
    }

    /// Returns the limits of the device force.
    pub(super) fn limits(&self) -> Result<SafetyParams, Refusal<'static>> {
        check(&[("soft_start", self.soft_start, false)])?;
        let force = self.force_limit.is_finite().then_some(self.force_limit);
        Ok(SafetyParams::bounding(force, None, self.soft_start))
    }
}
