//! The cut of a force from outside the loop, for simulated devices.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use super::ZeroWriter;
use crate::clock::Clock;

/// No cut.
const NEVER: u64 = u64::MAX;

/// When a [`ZeroWriter`] has commanded no force, in nanoseconds of the loop's clock; clones share it.
///
/// A simulated device reads it where it moves, since a supervisor's thread cannot reach into its state.
#[derive(Clone, Debug)]
pub struct Cut(Arc<AtomicU64>);

impl Cut {
    /// No force was cut.
    #[must_use]
    pub fn none() -> Self {
        Self(Arc::new(AtomicU64::new(NEVER)))
    }

    /// When the force was cut, clamped to the time from `from` to `now` that the device is to be moved
    /// through; `None` if the force was not cut.
    #[must_use]
    pub fn between(&self, from: Duration, now: Duration) -> Option<Duration> {
        let cut = self.0.load(Ordering::Acquire);
        (cut != NEVER).then(|| Duration::from_nanos(cut).clamp(from, now))
    }

    /// Forgets the cut: a force is commanded anew.
    pub fn is_over(&self) {
        self.0.store(NEVER, Ordering::Release);
    }

    /// What cuts the force, for another thread.
    #[must_use]
    pub fn writer<C: Clock>(&self, clock: &C) -> Box<dyn ZeroWriter> {
        Box::new(Writer {
            clock: clock.clone(),
            cut: self.clone(),
        })
    }
}

struct Writer<C> {
    clock: C,
    cut: Cut,
}

impl<C: Clock> ZeroWriter for Writer<C> {
    fn write_zero(&mut self) {
        let now = u64::try_from(self.clock.now().as_nanos()).unwrap_or(NEVER - 1);
        let cut = &self.cut.0;
        // The first of several cuts counts.
        let _ = cut.compare_exchange(NEVER, now, Ordering::AcqRel, Ordering::Acquire);
    }
}
