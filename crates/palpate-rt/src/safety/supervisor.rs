//! Somebody to let go of the motor while the loop's own thread does not answer.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use palpate_device::ZeroWriter;
use palpate_device::clock::Clock;

/// What loop and supervisor tell each other, without ever waiting.
#[derive(Debug, Default)]
pub struct Heartbeat {
    /// When the loop ticked last, in nanoseconds of its clock.
    beat: AtomicU64,
    /// Whether a force may be on.
    live: AtomicBool,
    /// How often a supervisor has commanded no force.
    cuts: AtomicU64,
    /// When it did so last, in nanoseconds of the loop's clock.
    cut_at: AtomicU64,
}

impl Heartbeat {
    /// The loop has ticked at `now`, and may hold a force.
    pub fn beat(&self, now: Duration) {
        let now = u64::try_from(now.as_nanos()).unwrap_or(u64::MAX);
        self.beat.store(now, Ordering::Release);
        self.live.store(true, Ordering::Release);
    }

    /// The loop has ended and left no force.
    pub fn end(&self) {
        self.live.store(false, Ordering::Release);
    }

    /// How often a supervisor has commanded no force.
    pub fn cuts(&self) -> u64 {
        self.cuts.load(Ordering::Acquire)
    }

    /// When a supervisor has begun to command no force last.
    pub(crate) fn cut_at(&self) -> Duration {
        Duration::from_nanos(self.cut_at.load(Ordering::Acquire))
    }
}

/// Watches a loop from another thread, and commands no force through a writer of its own when the
/// loop has not ticked for too long. It waits for nobody.
pub struct Supervisor {
    heartbeat: Arc<Heartbeat>,
    zero: Box<dyn ZeroWriter>,
    limit: Duration,
    /// The beat that it has already cut.
    cut: Option<u64>,
}

impl Supervisor {
    /// A supervisor that cuts when the last beat is more than `limit` ago.
    #[must_use]
    pub fn new(heartbeat: Arc<Heartbeat>, zero: Box<dyn ZeroWriter>, limit: Duration) -> Self {
        Self {
            heartbeat,
            zero,
            limit,
            cut: None,
        }
    }

    /// Looks once, and commands no force while the loop is late. Whether that has just begun.
    pub fn look(&mut self, now: Duration) -> bool {
        if !self.heartbeat.live.load(Ordering::Acquire) {
            return false;
        }
        let beat = self.heartbeat.beat.load(Ordering::Acquire);
        let late = now.saturating_sub(Duration::from_nanos(beat)) > self.limit;
        if !late {
            return false;
        }
        let is_first = self.cut != Some(beat);
        if is_first {
            // Told before it is done: a loop that comes back finds that it was cut.
            let now = u64::try_from(now.as_nanos()).unwrap_or(u64::MAX);
            self.heartbeat.cut_at.store(now, Ordering::Release);
            self.heartbeat.cuts.fetch_add(1, Ordering::AcqRel);
            self.cut = Some(beat);
        }
        // Again and again while it lasts: the loop may have put a force on in the middle of a tick
        // that then stood still once more.
        self.zero.write_zero();
        is_first
    }

    /// Looks every `interval` until `ended`.
    pub fn watch<C: Clock>(mut self, clock: &C, interval: Duration, ended: &AtomicBool) {
        let mut next = clock.now();
        while !ended.load(Ordering::Acquire) {
            self.look(clock.now());
            next = (next + interval).max(clock.now());
            clock.sleep_until(next);
        }
    }
}
