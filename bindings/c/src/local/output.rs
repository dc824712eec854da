//! Output of a local-model tick, in addition to the force.

use palpate_rt::HeldLocal;
use palpate_world::engine::local::ModelRefusal as Why;

use crate::output::Fault;
use crate::sized::SizedStruct;
use crate::world::{TickOutput, limits};

/// Reason for rejecting a model. The loop keeps the previous model.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModelRefusal {
    /// The model was accepted, or none was published.
    None = 0,
    /// The model is for a future tick.
    NotYet = 1,
    /// The model is for an earlier tick than the previous model.
    OutOfOrder = 2,
    /// The model is older than stale_after.
    TooOld = 3,
    /// The model is from another simulator.
    OtherHost = 4,
}

impl ModelRefusal {
    pub(super) fn new(why: Option<Why>) -> Self {
        match why {
            None => Self::None,
            Some(Why::NotYet) => Self::NotYet,
            Some(Why::OutOfOrder) => Self::OutOfOrder,
            Some(Why::TooOld) => Self::TooOld,
            Some(Why::OtherRoom) => Self::OtherHost,
        }
    }
}

/// Output of a local-model tick, in addition to the force. palpate_local_output_empty() returns an empty one to be
/// filled.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LocalOutput {
    /// Size of this struct; palpate_local_output_empty() sets it.
    pub struct_size: usize,
    /// Age of the newest model [s]; INFINITY if there is none.
    pub age: f64,
    /// Reason for rejecting the sample. The force is then 0.
    pub fault: Fault,
    /// Limits that changed the force: bits of palpate_limit.
    pub limited: u32,
    /// 1: the contacts fade or have faded, because there is no model or it is too old.
    pub is_stale: u32,
    /// Reason for rejecting the model that arrived since the last tick.
    pub refusal: ModelRefusal,
    /// Number of sub-steps, including replaced ones.
    pub sub_steps: u32,
    /// Number of sub-steps that were replaced by finer ones, at the start or end of a contact or of slip.
    pub refined: u32,
    /// Number of such sub-steps that were not refined, because the limit was reached.
    pub unrefined: u32,
    /// 1: the fastest contact needs more sub-steps than a tick allows. Reduce the stiffness or the period.
    pub too_fast: u32,
}

// SAFETY: `repr(C)`, a `usize` first, numbers only. It is written, never read from C.
unsafe impl SizedStruct for LocalOutput {
    const NAME: &'static str = "palpate_local_output";
}

impl TickOutput for LocalOutput {
    fn refused(fault: Fault) -> Self {
        Self {
            struct_size: size_of::<Self>(),
            age: f64::INFINITY,
            fault,
            limited: 0,
            is_stale: 0,
            refusal: ModelRefusal::None,
            sub_steps: 0,
            refined: 0,
            unrefined: 0,
            too_fast: 0,
        }
    }

    fn fault(&self) -> Fault {
        self.fault
    }
}

impl From<&HeldLocal<'_>> for LocalOutput {
    fn from(held: &HeldLocal<'_>) -> Self {
        Self {
            age: held.age.unwrap_or(f64::INFINITY),
            fault: Fault::new(held.fault.map(|fault| fault.fault)),
            limited: limits(held.limited, held.bounded),
            is_stale: u32::from(held.is_stale),
            refusal: ModelRefusal::new(held.refusal),
            sub_steps: held.effort.sub_steps,
            refined: held.effort.refined,
            unrefined: held.effort.unrefined,
            too_fast: u32::from(held.effort.too_fast),
            ..Self::refused(Fault::None)
        }
    }
}
