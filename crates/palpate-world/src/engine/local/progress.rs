//! Result of the loop for the host.

use super::state::ModelRefusal;
use crate::Vector;
use crate::engine::body::BodyWrench;

/// Progress of the loop, needed by a host for its next step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LocalProgress {
    /// Number of elapsed periods, both rendered and missed. A model that includes all impulses of this progress has
    /// this tick.
    pub tick: u64,
    /// Time between samples `[s]`.
    pub period: f64,
    /// Position of each tool's proxy at the end of the last period, where the host searches for contacts `[m]`.
    pub positions: Vec<Vector>,
    /// Velocity of each proxy `[m/s]`.
    pub velocities: Vec<Vector>,
    /// Impulse of the tools on each body since the start `[N s]`, and its moment about the body's reference point `[N
    /// m s]`.
    pub impulses: Vec<BodyImpulse>,
    /// Position of each body's copy `[m]`.
    pub copies: Vec<Vector>,
    /// Tick of the newest model, if any.
    pub model_tick: Option<u64>,
    /// Whether the contacts are fading or have faded because the model is missing or stale.
    pub is_stale: bool,
    /// Reason why the last model that arrived was rejected, if it was.
    pub refusal: Option<ModelRefusal>,
}

/// Impulse of the tools on a body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyImpulse {
    /// Impulse `[N s]`.
    pub linear: Vector,
    /// Moment of the impulse about the body's reference point `[N m s]`.
    pub angular: Vector,
}

impl LocalProgress {
    /// Copies the values of `other`. It does not allocate if both are from the same renderer.
    pub fn copy_from(&mut self, other: &Self) {
        let Self {
            tick,
            period,
            positions,
            velocities,
            impulses,
            copies,
            model_tick,
            is_stale,
            refusal,
        } = other;
        (self.tick, self.period) = (*tick, *period);
        self.positions.clone_from(positions);
        self.velocities.clone_from(velocities);
        self.impulses.clone_from(impulses);
        self.copies.clone_from(copies);
        (self.model_tick, self.is_stale, self.refusal) = (*model_tick, *is_stale, *refusal);
    }

    /// Returns the time from an earlier progress to this one `[s]`, over which the host steps.
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "a number of ticks")]
    pub fn time_since(&self, earlier: &Self) -> f64 {
        self.tick.saturating_sub(earlier.tick) as f64 * self.period
    }

    /// Returns the tools' mean wrench on a body between an earlier progress and this one, which the host holds over
    /// its step. The wrench is zero if no time has passed or the body does not exist.
    #[must_use]
    pub fn wrench_since(&self, earlier: &Self, body: usize) -> BodyWrench {
        let time = self.time_since(earlier);
        let (Some(now), Some(then)) = (self.impulses.get(body), earlier.impulses.get(body)) else {
            return BodyWrench::default();
        };
        if time <= 0.0 {
            return BodyWrench::default();
        }
        let mean = |now: &Vector, then: &Vector| {
            std::array::from_fn(|axis| (now[axis] - then[axis]) / time)
        };
        BodyWrench {
            force: mean(&now.linear, &then.linear),
            torque: mean(&now.angular, &then.angular),
        }
    }
}
