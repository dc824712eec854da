//! Output of a world tick, in addition to the wrenches.

use palpate_rt::Held;
use palpate_rt::safety::Bounded;
use palpate_world::Limited;

use super::TickOutput;
use crate::output::{Fault, Limit};
use crate::sized::SizedStruct;

/// Value of `fault_device` if the fault does not belong to one device.
pub const PALPATE_NO_DEVICE: u32 = u32::MAX;

/// Output of a world tick, in addition to the wrenches. palpate_world_output_empty() returns an empty one to be filled.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct WorldOutput {
    /// Size of this struct; palpate_world_output_empty() sets it.
    pub struct_size: usize,
    /// Reason for rejecting the sample. All wrenches are then 0.
    pub fault: Fault,
    /// Index of the device with the faulty sample; PALPATE_NO_DEVICE if the fault does not belong to one device.
    pub fault_device: u32,
    /// Active limits: bits of palpate_limit.
    pub limited: u32,
    /// Number of sub-steps, including replaced ones.
    pub sub_steps: u32,
    /// Number of sub-steps that were replaced by finer ones, at the start or end of a contact or of slip.
    pub refined: u32,
    /// Number of such sub-steps that were not refined, because the limit was reached.
    pub unrefined: u32,
    /// 1: the fastest contact needs more sub-steps than a tick allows. Reduce the stiffness or the period.
    pub too_fast: u32,
    /// Number of mesh triangles and mesh contacts that exceeded the capacity of a sub-step.
    pub left_out: u32,
}

// SAFETY: `repr(C)`, a `usize` first, numbers only. It is written, never read from C.
unsafe impl SizedStruct for WorldOutput {
    const NAME: &'static str = "palpate_world_output";
}

impl TickOutput for WorldOutput {
    fn refused(fault: Fault) -> Self {
        Self {
            struct_size: size_of::<Self>(),
            fault,
            fault_device: PALPATE_NO_DEVICE,
            limited: 0,
            sub_steps: 0,
            refined: 0,
            unrefined: 0,
            too_fast: 0,
            left_out: 0,
        }
    }

    fn fault(&self) -> Fault {
        self.fault
    }
}

/// Returns the active limits, as bits of palpate_limit.
pub(crate) fn limits(limited: Limited, bounded: Bounded) -> u32 {
    let bit = |set: bool, limit: Limit| if set { limit as u32 } else { 0 };
    bit(limited.force || bounded.force, Limit::Force)
        | bit(limited.torque, Limit::Torque)
        | bit(limited.offset, Limit::Offset)
        | bit(limited.guard, Limit::Guard)
        | bit(limited.beyond_guard, Limit::BeyondGuard)
        | bit(bounded.slew, Limit::Slew)
        | bit(bounded.soft_start, Limit::SoftStart)
        | bit(bounded.stopped, Limit::Stopped)
}

impl From<&Held<'_>> for WorldOutput {
    fn from(held: &Held<'_>) -> Self {
        let device = held.fault.and_then(|fault| fault.tool);
        Self {
            fault: Fault::new(held.fault.map(|fault| fault.fault)),
            fault_device: device
                .and_then(|device| u32::try_from(device).ok())
                .unwrap_or(PALPATE_NO_DEVICE),
            limited: limits(held.limited, held.bounded),
            sub_steps: held.effort.sub_steps,
            refined: held.effort.refined,
            unrefined: held.effort.unrefined,
            too_fast: u32::from(held.effort.too_fast),
            left_out: held.effort.left_out,
            ..Self::refused(Fault::None)
        }
    }
}
