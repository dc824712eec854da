//! Supervisor: disables the motors while the loop's thread is blocked.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use palpate_device::ZeroWriter;
use palpate_device::clock::Clock;

/// Longest sleep of a supervisor, after which it notices that it is to end.
const LONGEST_SLEEP: Duration = Duration::from_millis(50);

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

    /// Checks until `ended`, each time when the limit after the last beat is over.
    pub fn watch<C: Clock>(mut self, clock: &C, ended: &AtomicBool) {
        while !ended.load(Ordering::Acquire) {
            let now = clock.now();
            self.look(now);
            clock.sleep_until(self.next_look(now));
        }
    }

    /// Returns the time of the check after the one at `now`: the first one at which the force has to be cut if the loop
    /// does not tick again. A loop that is late is checked, and its force cut, four times within a limit.
    fn next_look(&self, now: Duration) -> Duration {
        let longest = now.saturating_add(self.limit.min(LONGEST_SLEEP));
        if !self.heartbeat.live.load(Ordering::Acquire) {
            return longest;
        }
        let beat = Duration::from_nanos(self.heartbeat.beat.load(Ordering::Acquire));
        let due = beat
            .saturating_add(self.limit)
            .saturating_add(Duration::from_nanos(1));
        if due > now {
            due.min(longest)
        } else {
            now.saturating_add((self.limit / 4).min(LONGEST_SLEEP))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A clock on which a loop ticks every `period` before `stalls_at`.
    #[derive(Clone)]
    struct Ticking {
        /// `[ns]`
        now: Arc<AtomicU64>,
        heartbeat: Arc<Heartbeat>,
        period: Duration,
        stalls_at: Duration,
        ends_at: Duration,
        sleeps: Arc<AtomicU64>,
        ended: Arc<AtomicBool>,
    }

    impl Clock for Ticking {
        const RUNS: bool = true;

        fn now(&self) -> Duration {
            Duration::from_nanos(self.now.load(Ordering::Relaxed))
        }

        fn sleep_until(&self, deadline: Duration) {
            let now = u64::try_from(deadline.as_nanos()).unwrap();
            self.now.store(now, Ordering::Relaxed);
            self.sleeps.fetch_add(1, Ordering::Relaxed);
            let ticked_until = deadline.min(self.stalls_at).as_nanos();
            let ticks = u32::try_from(ticked_until / self.period.as_nanos()).unwrap();
            self.heartbeat.beat(ticks * self.period);
            self.ended
                .store(deadline >= self.ends_at, Ordering::Release);
        }
    }

    #[derive(Clone, Default)]
    struct Counted(Arc<AtomicU64>);

    impl ZeroWriter for Counted {
        fn write_zero(&mut self) {
            self.0.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// 4 kHz and 3.25 ms: a healthy loop of a second costs about 310 wake-ups, not 8000. A loop that stalls is cut when
    /// the limit is over, and again four times within each further limit.
    #[test]
    fn a_supervisor_sleeps_until_the_limit_is_over() {
        let (period, limit) = (Duration::from_micros(250), Duration::from_micros(3250));
        for (stalls_at, ends_at, zeros) in [(1.0, 1.0, 0..=0), (1.0, 1.0065, 4..=6)] {
            let (heartbeat, zero) = (Arc::new(Heartbeat::default()), Counted::default());
            let clock = Ticking {
                now: Arc::default(),
                heartbeat: Arc::clone(&heartbeat),
                period,
                stalls_at: Duration::from_secs_f64(stalls_at),
                ends_at: Duration::from_secs_f64(ends_at),
                sleeps: Arc::default(),
                ended: Arc::default(),
            };
            let supervisor = Supervisor::new(Arc::clone(&heartbeat), Box::new(zero.clone()), limit);
            supervisor.watch(&clock, &clock.ended);
            let sleeps = clock.sleeps.load(Ordering::Relaxed);
            assert!((300..350).contains(&sleeps), "{sleeps} wake-ups");
            let zeros_written = zero.0.load(Ordering::Relaxed);
            assert!(zeros.contains(&zeros_written), "{zeros_written} commands");
            if *zeros.start() > 0 {
                assert_eq!(heartbeat.cuts(), 1);
                let after = heartbeat.cut_at() - clock.stalls_at;
                assert!((limit..limit + Duration::from_nanos(2)).contains(&after));
            }
        }
    }
}
