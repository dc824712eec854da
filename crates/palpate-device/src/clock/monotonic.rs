//! The machine's monotonic clock.

use std::time::Duration;

use super::Clock;

/// The machine's monotonic clock; its origin is the time of construction. It sleeps until an absolute deadline, so
/// the computing time of a tick does not lengthen the period. It can busy-wait before each deadline, because a
/// processor wakes from a timer some tens of microseconds late.
#[derive(Clone, Copy, Debug)]
pub struct MonotonicClock {
    origin: Duration,
    spin: Duration,
}

impl MonotonicClock {
    /// Creates a clock that starts now and does not busy-wait.
    #[must_use]
    pub fn new() -> Self {
        Self {
            origin: machine::now(),
            spin: Duration::ZERO,
        }
    }

    /// Sets the busy-wait time before each deadline. It occupies a processor for `spin` of every period.
    #[must_use]
    pub fn with_spin(self, spin: Duration) -> Self {
        Self { spin, ..self }
    }
}

impl Default for MonotonicClock {
    fn default() -> Self {
        Self::new()
    }
}

impl Clock for MonotonicClock {
    const RUNS: bool = true;

    #[inline]
    fn now(&self) -> Duration {
        machine::now().saturating_sub(self.origin)
    }

    #[inline]
    fn sleep_until(&self, deadline: Duration) {
        let asleep_until = deadline.saturating_sub(self.spin);
        if self.now() < asleep_until {
            machine::sleep_until(self.origin + asleep_until);
        }
        while self.now() < deadline {
            std::hint::spin_loop();
        }
    }
}

#[cfg(target_os = "linux")]
mod machine {
    use std::time::Duration;

    use rustix::thread::{ClockId, clock_nanosleep_absolute};
    use rustix::time::{Timespec, clock_gettime};

    pub fn now() -> Duration {
        let time = clock_gettime(rustix::time::ClockId::Monotonic);
        // Time since boot: neither part is negative.
        Duration::new(
            u64::try_from(time.tv_sec).unwrap_or(0),
            u32::try_from(time.tv_nsec).unwrap_or(0),
        )
    }

    pub fn sleep_until(time: Duration) {
        let time = Timespec {
            tv_sec: i64::try_from(time.as_secs()).unwrap_or(i64::MAX),
            tv_nsec: time.subsec_nanos().into(),
        };
        // A signal ends the sleep early. The deadline is absolute, so sleep again.
        while clock_nanosleep_absolute(ClockId::Monotonic, &time)
            .is_err_and(|error| error == rustix::io::Errno::INTR)
        {}
    }
}

/// Repeats relative sleeps of the remaining time, because absolute sleep is not available.
#[cfg(not(target_os = "linux"))]
#[allow(
    clippy::disallowed_methods,
    clippy::disallowed_types,
    reason = "the clock itself"
)]
mod machine {
    use std::sync::OnceLock;
    use std::time::{Duration, Instant};

    static START: OnceLock<Instant> = OnceLock::new();

    pub fn now() -> Duration {
        START.get_or_init(Instant::now).elapsed()
    }

    pub fn sleep_until(time: Duration) {
        std::thread::sleep(time.saturating_sub(now()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_never_wakes_early_and_never_runs_backwards() {
        for spin in [Duration::ZERO, Duration::from_micros(200)] {
            let clock = MonotonicClock::new().with_spin(spin);
            let mut last = clock.now();
            for _ in 0..20 {
                let deadline = last + Duration::from_micros(500);
                clock.sleep_until(deadline);
                last = clock.now();
                assert!(last >= deadline);
            }
            let before = clock.now();
            clock.sleep_until(Duration::ZERO);
            assert!(clock.now() - before < Duration::from_millis(100));
        }
    }
}
