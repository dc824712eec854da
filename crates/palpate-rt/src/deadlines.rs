//! Deadlines of the loop and treatment of missed ones.

use std::time::Duration;

/// Absolute deadlines, one period apart. A tick that ends after the next deadline has missed it. Missed deadlines are
/// counted and skipped, so the phase of the loop is constant and ticks never follow in a burst. The renderer receives
/// the actual elapsed time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Deadlines {
    period: Duration,
    next: Duration,
}

impl Deadlines {
    /// Creates deadlines from `first` on.
    pub fn new(period: Duration, first: Duration) -> Self {
        Self {
            period,
            next: first,
        }
    }

    /// Returns the next deadline.
    pub fn next(&self) -> Duration {
        self.next
    }

    /// Ends the tick of the last deadline, which began at `began`, at `now`. Returns the number of missed deadlines.
    /// The next deadline is after both times.
    pub fn ended(&mut self, began: Duration, now: Duration) -> u64 {
        self.next += self.period;
        let mut skipped = 0;
        if now > self.next {
            skipped = (now - self.next)
                .as_nanos()
                .div_ceil(self.period.as_nanos());
        }
        if began >= self.next {
            // A second tick at the same instant would find no new sample.
            let passed = (began - self.next).as_nanos() / self.period.as_nanos() + 1;
            skipped = skipped.max(passed);
        }
        let skip = u32::try_from(skipped).unwrap_or(u32::MAX);
        self.next += self.period * skip;
        skip.into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missed_deadlines_are_skipped_and_the_phase_stays() {
        let ms = Duration::from_millis;
        let mut deadlines = Deadlines::new(ms(10), ms(5));
        assert_eq!(deadlines.next(), ms(5));
        assert_eq!(deadlines.ended(ms(5), ms(14)), 0);
        assert_eq!(deadlines.next(), ms(15));
        // Ends exactly at the next deadline.
        assert_eq!(deadlines.ended(ms(15), ms(25)), 0);
        assert_eq!(deadlines.next(), ms(25));
        assert_eq!(deadlines.ended(ms(25), ms(36)), 1);
        assert_eq!(deadlines.next(), ms(45));
        assert_eq!(deadlines.ended(ms(46), ms(85)), 3);
        assert_eq!(deadlines.next(), ms(85));
        // Woke exactly at a later deadline.
        assert_eq!(deadlines.ended(ms(105), ms(105)), 2);
        assert_eq!(deadlines.next(), ms(115));
    }
}
