//! A clock that is moved by hand.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use super::Clock;

/// A clock on which time passes only where it is told to: [`advance`](Self::advance) moves it, and
/// whoever sleeps on it finds the deadline come at once. A loop on it runs as fast as the machine
/// can, and every run of it is the same.
#[derive(Clone, Debug, Default)]
pub struct SteppedClock {
    nanoseconds: Arc<AtomicU64>,
    oversleep: Arc<AtomicU64>,
}

impl SteppedClock {
    /// A clock at its origin.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Lets `duration` pass.
    pub fn advance(&self, duration: Duration) {
        self.nanoseconds
            .fetch_add(nanoseconds(duration), Ordering::SeqCst);
    }

    /// The next to sleep wakes up this much after its deadline.
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

/// 584 years are enough.
fn nanoseconds(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_passes_by_hand_only_and_clones_share_it() {
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
