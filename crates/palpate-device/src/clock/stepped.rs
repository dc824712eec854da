//! A manually stepped clock.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use super::Clock;

/// A manually stepped clock: only [`advance`](Self::advance) and `sleep_until` move it. `sleep_until` sets the time
/// to the deadline and returns immediately, so a loop runs as fast as the machine allows and is reproducible.
#[derive(Clone, Debug, Default)]
pub struct SteppedClock {
    nanoseconds: Arc<AtomicU64>,
    oversleep: Arc<AtomicU64>,
}

impl SteppedClock {
    /// Creates a clock at its origin.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Advances the time by `duration`.
    pub fn advance(&self, duration: Duration) {
        self.nanoseconds
            .fetch_add(nanoseconds(duration), Ordering::SeqCst);
    }

    /// Makes the next sleep end this long after its deadline.
    pub fn oversleep_once(&self, lateness: Duration) {
        self.oversleep
            .store(nanoseconds(lateness), Ordering::SeqCst);
    }
}

impl Clock for SteppedClock {
    const RUNS: bool = false;

    fn now(&self) -> Duration {
        Duration::from_nanos(self.nanoseconds.load(Ordering::SeqCst))
    }

    fn sleep_until(&self, deadline: Duration) {
        let late = self.oversleep.swap(0, Ordering::SeqCst);
        let wake = nanoseconds(deadline).saturating_add(late);
        self.nanoseconds.fetch_max(wake, Ordering::SeqCst);
    }
}

/// Converts to nanoseconds; saturates after 584 years.
fn nanoseconds(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stepped_clock_advances_only_on_request_and_clones_share_its_time() {
        let clock = SteppedClock::new();
        let other = clock.clone();
        clock.advance(Duration::from_millis(3));
        assert_eq!(other.now(), Duration::from_millis(3));
        other.sleep_until(Duration::from_millis(5));
        assert_eq!(clock.now(), Duration::from_millis(5));
        clock.sleep_until(Duration::from_millis(4));
        assert_eq!(clock.now(), Duration::from_millis(5));
        clock.oversleep_once(Duration::from_millis(2));
        clock.sleep_until(Duration::from_millis(6));
        assert_eq!(clock.now(), Duration::from_millis(8));
        clock.sleep_until(Duration::from_millis(9));
        assert_eq!(clock.now(), Duration::from_millis(9));
    }
}
