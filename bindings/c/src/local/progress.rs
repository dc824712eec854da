//! What the loop gives back to a slow host.

use palpate_world::engine::local::LocalProgress;

use super::ModelRefusal;
use crate::sized::SizedStruct;

/// How far the loop has come: what a host needs for its next step. palpate_progress_empty() makes one to be filled.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// Size of this struct; palpate_progress_empty() sets it.
    pub struct_size: usize,
    /// Periods that have passed: those that the loop has rendered, and those that it has missed. A model that has all impulses of this progress in it is of this tick.
    pub tick: u64,
    /// Time from sample to sample of the loop [s].
    pub period: f64,
    /// Where the avatar of the tool is at the end of the last period [m]: where the host looks for what the tool may touch.
    pub position: [f64; 3],
    /// Its velocity [m/s].
    pub velocity: [f64; 3],
    /// Tick of the newest model, where `has_model` is not 0.
    pub model_tick: u64,
    /// 1: a model has been taken.
    pub has_model: u32,
    /// 1: the contacts fade, or have faded, because there is no model or it is too old.
    pub is_stale: u32,
    /// Why the last model that came was not taken.
    pub refusal: ModelRefusal,
    /// 0.
    pub reserved: u32,
}

// SAFETY: `repr(C)`, a `usize` first, numbers only. It is written, never read from C.
unsafe impl SizedStruct for Progress {
    const NAME: &'static str = "palpate_progress";
}

impl From<&LocalProgress> for Progress {
    fn from(progress: &LocalProgress) -> Self {
        let first = |vectors: &[[f64; 3]]| vectors.first().copied().unwrap_or_default();
        Self {
            struct_size: size_of::<Self>(),
            tick: progress.tick,
            period: progress.period,
            position: first(&progress.positions),
            velocity: first(&progress.velocities),
            model_tick: progress.model_tick.unwrap_or(0),
            has_model: u32::from(progress.model_tick.is_some()),
            is_stale: u32::from(progress.is_stale),
            refusal: ModelRefusal::of(progress.refusal),
            reserved: 0,
        }
    }
}

/// What the tool has given to a body of the host. It stands in arrays, so it has no struct_size and stays as it is.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct BodyProgress {
    /// Impulse of the tool on the body since the start [N s].
    pub impulse: [f64; 3],
    /// Its moment about the body's reference point [N m s].
    pub moment: [f64; 3],
    /// Where the loop's copy of the body is [m].
    pub copy: [f64; 3],
}
