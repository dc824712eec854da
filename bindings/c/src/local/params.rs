//! What a caller says of a local model once.

use palpate::Actuation;
use palpate_rt::safety::SafetyParams;
use palpate_world::engine::local::{LocalParams as Room, LocalRenderer};
use palpate_world::{CoupledParams, Shape, Tool, WorldLoop};

use crate::edge::status;
use crate::scene::{check, in_words};
use crate::sized::{self, SizedStruct};
use crate::status::{Refusal, Status};

/// The loop, its device, and room for what a slow host publishes. palpate_local_params_default() fills it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LocalParams {
    /// Size of this struct; palpate_local_params_default() sets it.
    pub struct_size: usize,
    /// Nominal time from sample to sample of the loop, above 0 [s]: 0.001 is 1 ms. It has no default.
    pub period: f64,
    /// Effective mass of the device along each axis of the world, above 0 [kg]; a factor of 2 is near enough. INFINITY: the device
    /// lacks this axis. It has no default.
    pub device_mass: [f64; 3],
    /// Radius of the tool, a sphere, not below 0 [m]. Default: 0, a point.
    pub tool_radius: f64,
    /// Age of the newest model beyond which its contacts fade [s]: 1 to 1000 periods of the loop. Default: 0.2.
    pub stale_after: f64,
    /// Time in which they fade, and come back, above 0 [s]. Default: 0.1.
    pub fade: f64,
    /// Time in which a change of a contact that touches comes in, above 0 [s]. Default: 0.01.
    pub settle: f64,
    /// Time in which the loop's copy of a body goes back to the host's body, above 0 [s]. Default: 1.
    pub return_time: f64,
    /// Quantum of the position sensor, not below 0 [m]. Default: 0.
    pub quantum: f64,
    /// Time from a sample to the moment at which its command begins to act, not below 0 [s]. Default: 0.
    pub delay: f64,
    /// Time constant of a first-order lag after it, not below 0 [s]. Default: 0.
    pub lag: f64,
    /// Delivered over commanded force, above 0. Default: 1.
    pub gain: f64,
    /// Largest force on the device, by its norm, above 0 [N]. INFINITY: no limit. Default: 20.
    pub force_limit: f64,
    /// Time over which a force comes in where a start or a recovery finds contact, not below 0 [s]. Default: 0.2.
    pub soft_start: f64,
    /// Number of the host's bodies, at most 16; 0, the default: contacts with what never moves only.
    pub bodies: u32,
    /// Most contacts of a model, 1 to 64. Default: 8.
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

/// Fills parameters of a local model with the defaults. `struct_size` is sizeof(palpate_local_params).
///
/// # Safety
/// `params` is NULL, or `struct_size` bytes can be written there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_local_params_init(
    params: *mut LocalParams,
    struct_size: usize,
) -> Status {
    // SAFETY: as the caller says.
    status(|| unsafe { sized::fill(params, struct_size, LocalParams::default()) })
}

impl LocalParams {
    /// What renders, with every parameter checked.
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
        let in_loop = WorldLoop::new(period).with_actuation(Actuation {
            delay: self.delay,
            lag: self.lag,
            gain: self.gain,
            ..Actuation::default()
        });
        let in_loop = if limit.is_finite() {
            in_loop.with_force_limits(vec![limit])
        } else {
            in_loop
        };
        let coupled = CoupledParams::new(vec![self.device_mass]).with_encoder_quantum(self.quantum);
        LocalRenderer::new(&[tool], room, in_loop, coupled)
            .map_err(|faults| Refusal::Numbers(in_words(&faults)))
    }

    /// What may reach the device.
    pub(super) fn limits(&self) -> Result<SafetyParams, Refusal<'static>> {
        check(&[("soft_start", self.soft_start, false)])?;
        let force = self.force_limit.is_finite().then_some(self.force_limit);
        Ok(SafetyParams::bounding(force, None, self.soft_start))
    }
}
