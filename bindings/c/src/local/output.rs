//! What comes out of a tick by a local model, beside the force.

use palpate_rt::HeldLocal;
use palpate_world::engine::local::ModelRefusal as Why;

use crate::output::Fault;
use crate::sized::SizedStruct;
use crate::world::{TickOutput, limits};

/// Why a model was not taken; the one before goes on.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModelRefusal {
    /// It was taken, or none has come.
    None = 0,
    /// It is of a tick that has not been.
    NotYet = 1,
    /// It is of a tick before that of the model before.
    OutOfOrder = 2,
    /// It is older than stale_after.
    TooOld = 3,
    /// It is of another host.
    OtherHost = 4,
}

impl ModelRefusal {
    pub(super) fn of(why: Option<Why>) -> Self {
        match why {
            None => Self::None,
            Some(Why::NotYet) => Self::NotYet,
            Some(Why::OutOfOrder) => Self::OutOfOrder,
            Some(Why::TooOld) => Self::TooOld,
            Some(Why::OtherRoom) => Self::OtherHost,
        }
    }
}

/// What a tick by a local model says beside the force. palpate_local_output_empty() makes one to be filled.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LocalOutput {
    /// Size of this struct; palpate_local_output_empty() sets it.
    pub struct_size: usize,
    /// Age of the newest model [s]; INFINITY where there is none.
    pub age: f64,
    /// Why the sample was refused. The force is then 0.
    pub fault: Fault,
    /// Limits that changed the force: bits of palpate_limit.
    pub limited: u32,
    /// 1: the contacts fade, or have faded, because there is no model or it is too old.
    pub is_stale: u32,
    /// Why the model that has come since the last tick was not taken.
    pub refusal: ModelRefusal,
    /// Sub-steps of the tick, with those that were replaced by finer ones.
    pub sub_steps: u32,
    /// Sub-steps that were replaced by finer ones, where contacts begin, end, or begin to slip.
    pub refined: u32,
    /// Such sub-steps that were not: there were too many of them.
    pub unrefined: u32,
    /// 1: the fastest contact asked for more sub-steps than a tick may have. A smaller stiffness or a shorter period helps.
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
            fault: Fault::of(held.fault.map(|fault| fault.fault)),
            limited: limits(held.limited, held.bounded),
            is_stale: u32::from(held.is_stale),
            refusal: ModelRefusal::of(held.refusal),
            sub_steps: held.effort.sub_steps,
            refined: held.effort.refined,
            unrefined: held.effort.unrefined,
            too_fast: u32::from(held.effort.too_fast),
            ..Self::refused(Fault::None)
        }
    }
}
