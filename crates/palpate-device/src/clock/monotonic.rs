//! The machine's monotonic clock.

use std::time::Duration;

use super::Clock;

/// The machine's monotonic clock, with its origin where it was made. It sleeps until an absolute
/// time, so that what a tick took is not added to the period, and it can spend the last stretch
/// awake: a processor that waits for a timer wakes up some tens of microseconds late.
#[derive(Clone, Copy, Debug)]
pub struct MonotonicClock {
    origin: Duration,
    spin: Duration,
}

impl MonotonicClock {
    /// A clock that starts now and leaves waking up to the kernel.
    #[must_use]
    pub fn new() -> Self {
        Self {
            origin: machine::now(),
            spin: Duration::ZERO,
        }
    }

    /// The same clock, awake for the last `spin` before each deadline. That keeps a processor busy
    /// for `spin` of every period.
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
        // Since the machine started: neither part is negative.
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
        // A signal ends the sleep early: the deadline is absolute, so sleep again.
        while clock_nanosleep_absolute(ClockId::Monotonic, &time)
            .is_err_and(|error| error == rustix::io::Errno::INTR)
        {}
    }
}

/// Without absolute sleep, each sleep is as long as is left.
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
