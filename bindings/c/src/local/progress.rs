//! Progress of the loop, as reported to a low-rate simulator.

use palpate_world::engine::local::LocalProgress;

use super::ModelRefusal;
use crate::sized::SizedStruct;

/// Progress of the loop: inputs for the simulator's next step. palpate_progress_empty() returns an empty one to be
/// filled.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// Size of this struct; palpate_progress_empty() sets it.
    pub struct_size: usize,
    /// Number of elapsed periods, rendered and missed. A model that includes all impulses of this progress has this
    /// tick.
    pub tick: u64,
    /// Sampling period of the loop [s].
    pub period: f64,
    /// Proxy position of the tool at the end of the last period [m]; the simulator detects contacts near it.
    pub position: [f64; 3],
    /// Proxy velocity [m/s].
    pub velocity: [f64; 3],
    /// Tick of the newest model, if `has_model` is 1.
    pub model_tick: u64,
    /// 1: a model has been accepted.
    pub has_model: u32,
    /// 1: the contacts fade or have faded, because there is no model or it is too old.
    pub is_stale: u32,
    /// Reason for rejecting the last model.
    pub refusal: ModelRefusal,
    /// Unused; 0.
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
            refusal: ModelRefusal::new(progress.refusal),
            reserved: 0,
        }
    }
}

/// Impulses of the tool on a body of the simulator. The struct is an array element, so it has no struct_size and its
/// layout is fixed.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct BodyProgress {
    /// Impulse of the tool on the body since the start [N s].
    pub impulse: [f64; 3],
    /// Moment of the impulse about the body's reference point [N m s].
    pub moment: [f64; 3],
    /// Position of the loop's copy of the body [m].
    pub copy: [f64; 3],
}
