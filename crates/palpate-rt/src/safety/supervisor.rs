//! Supervisor: disables the motors while the loop's thread is blocked.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use palpate_device::ZeroWriter;
use palpate_device::clock::Clock;

/// Non-blocking communication between loop and supervisor.
#[derive(Debug, Default)]
pub struct Heartbeat {
    /// Time of the loop's last tick, in nanoseconds of its clock.
    beat: AtomicU64,
    /// Whether a force may be on.
    live: AtomicBool,
    /// Number of zero commands by the supervisor.
    cuts: AtomicU64,
    /// Time of the last one, in nanoseconds of the loop's clock.
    cut_at: AtomicU64,
}

impl Heartbeat {
    /// Reports a tick at `now`; the loop may hold a force.
    pub fn beat(&self, now: Duration) {
        let now = u64::try_from(now.as_nanos()).unwrap_or(u64::MAX);
        self.beat.store(now, Ordering::Release);
        self.live.store(true, Ordering::Release);
    }

    /// Reports that the loop has ended without a force.
    pub fn end(&self) {
        self.live.store(false, Ordering::Release);
    }

    /// Returns how often a supervisor has commanded zero force.
    pub fn cuts(&self) -> u64 {
        self.cuts.load(Ordering::Acquire)
    }

    /// Returns the time at which a supervisor last started to command zero force.
    pub(crate) fn cut_at(&self) -> Duration {
        Duration::from_nanos(self.cut_at.load(Ordering::Acquire))
    }
}

/// Supervises a loop from another thread. If the loop has not ticked for too long, it commands zero force through its
/// own zero writer. It never blocks.
pub struct Supervisor {
    heartbeat: Arc<Heartbeat>,
    zero: Box<dyn ZeroWriter>,
    limit: Duration,
    /// The last beat for which it has cut the force.
    cut: Option<u64>,
}

impl Supervisor {
    /// Creates a supervisor that cuts the force if the last beat is older than `limit`.
    #[must_use]
    pub fn new(heartbeat: Arc<Heartbeat>, zero: Box<dyn ZeroWriter>, limit: Duration) -> Self {
        Self {
            heartbeat,
            zero,
            limit,
            cut: None,
        }
    }

    /// Checks once, and commands zero force while the loop is late. Returns whether a cut has just begun.
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
            // Report before acting, so a loop that returns detects the cut.
            let now = u64::try_from(now.as_nanos()).unwrap_or(u64::MAX);
            self.heartbeat.cut_at.store(now, Ordering::Release);
            self.heartbeat.cuts.fetch_add(1, Ordering::AcqRel);
            self.cut = Some(beat);
        }
        // Repeat while the loop is late: it may have commanded a force in the middle of a tick and then stalled
        // again.
        self.zero.write_zero();
        is_first
    }

    /// Checks every `interval` until `ended`.
    pub fn watch<C: Clock>(mut self, clock: &C, interval: Duration, ended: &AtomicBool) {
        let mut next = clock.now();
        while !ended.load(Ordering::Acquire) {
            self.look(clock.now());
            next = (next + interval).max(clock.now());
            clock.sleep_until(next);
        }
    }
}
