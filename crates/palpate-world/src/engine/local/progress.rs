//! What the loop gives back to the host.

use super::state::ModelRefusal;
use crate::Vector;
use crate::engine::body::BodyWrench;

/// How far the loop has come: what a host needs for its next step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LocalProgress {
    /// Periods that have passed: those that the loop has rendered, and those that it has missed. A model that has all impulses of this progress in it is of this tick.
    pub tick: u64,
    /// Time from sample to sample `[s]`.
    pub period: f64,
    /// Where the avatar of each tool is at the end of the last period `[m]`: where the host looks for what the tool may touch.
    pub positions: Vec<Vector>,
    /// Its velocity `[m/s]`.
    pub velocities: Vec<Vector>,
    /// Impulse of the tools on each body since the start `[N s]`, and its moment about the body's reference point `[N m s]`.
    pub impulses: Vec<BodyImpulse>,
    /// Where the copy of each body is `[m]`.
    pub copies: Vec<Vector>,
    /// Tick of the newest model, if there was one.
    pub model_tick: Option<u64>,
    /// Whether the contacts fade, or have faded, because there is no model or it is too old.
    pub is_stale: bool,
    /// Why the last model that came was not taken, if it was not.
    pub refusal: Option<ModelRefusal>,
}

/// What tools gave to a body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyImpulse {
    /// Impulse `[N s]`.
    pub linear: Vector,
    /// Its moment about the body's reference point `[N m s]`.
    pub angular: Vector,
}

impl LocalProgress {
    /// Comes to be as `other`. It does not allocate where both are of one renderer.
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

    /// Time from an earlier progress to this one `[s]`: what the host steps over.
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "a number of ticks")]
    pub fn time_since(&self, earlier: &Self) -> f64 {
        self.tick.saturating_sub(earlier.tick) as f64 * self.period
    }

    /// The mean wrench of the tools on a body from an earlier progress to this one: what the host holds over its step. None
    /// where no time has passed, and for a body that there is not.
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
