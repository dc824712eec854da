//! Rate limiter.

use std::time::Instant;

/// Token bucket: a burst size, and a rate per second.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    at_once: f64,
    per_second: f64,
    left: f64,
    counted: Instant,
}

impl Pace {
    /// Creates a full bucket.
    pub fn new(at_once: f64, per_second: f64) -> Self {
        Self {
            at_once,
            per_second,
            left: at_once,
            counted: Instant::now(),
        }
    }

    /// Whether it may happen `now`; if so it has.
    pub fn take(&mut self, now: Instant) -> bool {
        let earned = self.per_second * now.duration_since(self.counted).as_secs_f64();
        self.left = (self.left + earned).min(self.at_once);
        self.counted = now;
        let may = self.left >= 1.0;
        if may {
            self.left -= 1.0;
        }
        may
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn so_many_at_once_and_then_so_many_each_second() {
        let mut pace = Pace::new(3.0, 2.0);
        let begun = Instant::now();
        let mut count = |after: f64| {
            let now = begun + Duration::from_secs_f64(after);
            (0..10).filter(|_| pace.take(now)).count()
        };
        assert_eq!(count(0.0), 3);
        assert_eq!(count(1.01), 2);
        assert_eq!(count(100.0), 3);
    }
}
