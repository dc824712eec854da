//! Removal of a force from outside the loop, for simulated devices.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use super::ZeroWriter;
use crate::clock::Clock;

/// Value of a cut that has not happened.
const NEVER: u64 = u64::MAX;

/// Time at which a [`ZeroWriter`] commanded zero force, in nanoseconds of the loop's clock. Clones share it.
///
/// A simulated device reads it when it moves, because a supervisor thread cannot access the device's state.
#[derive(Clone, Debug)]
pub struct Cut(Arc<AtomicU64>);

impl Cut {
    /// Creates a state without a cut.
    #[must_use]
    pub fn none() -> Self {
        Self(Arc::new(AtomicU64::new(NEVER)))
    }

    /// Returns the time of the cut, clamped to the simulated interval from `from` to `now`; `None` if there was no
    /// cut.
    #[must_use]
    pub fn between(&self, from: Duration, now: Duration) -> Option<Duration> {
        let cut = self.0.load(Ordering::Acquire);
        (cut != NEVER).then(|| Duration::from_nanos(cut).clamp(from, now))
    }

    /// Clears the cut because a new force is commanded.
    pub fn is_over(&self) {
        self.0.store(NEVER, Ordering::Release);
    }

    /// Returns a writer that cuts the force from another thread.
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
        // Keep the first of several cuts.
        let _ = cut.compare_exchange(NEVER, now, Ordering::AcqRel, Ordering::Acquire);
    }
}
