//! When the loop is to tick, and what becomes of deadlines that it missed.

use std::time::Duration;

/// Absolute deadlines, a period apart. A tick that ends after the next deadline has missed it: it is
/// counted and skipped, so that the phase of the loop stays and no two ticks come in a hurry. The
/// renderer is told the time that really passed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Deadlines {
    period: Duration,
    next: Duration,
}

impl Deadlines {
    /// Deadlines from `first` on.
    pub fn new(period: Duration, first: Duration) -> Self {
        Self {
            period,
            next: first,
        }
    }

    /// The next deadline.
    pub fn next(&self) -> Duration {
        self.next
    }

    /// The tick of the last deadline, which began at `began`, has ended at `now`: how many it
    /// missed. The next one is after both.
    pub fn ended(&mut self, began: Duration, now: Duration) -> u64 {
        self.next += self.period;
        let mut skipped = 0;
        if now > self.next {
            skipped = (now - self.next)
                .as_nanos()
                .div_ceil(self.period.as_nanos());
        }
        if began >= self.next {
            // A tick at the same instant would find nothing new.
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
        // Just in time for the next one.
        assert_eq!(deadlines.ended(ms(15), ms(25)), 0);
        assert_eq!(deadlines.next(), ms(25));
        assert_eq!(deadlines.ended(ms(25), ms(36)), 1);
        assert_eq!(deadlines.next(), ms(45));
        assert_eq!(deadlines.ended(ms(46), ms(85)), 3);
        assert_eq!(deadlines.next(), ms(85));
        // It woke at a later deadline, to the nanosecond.
        assert_eq!(deadlines.ended(ms(105), ms(105)), 2);
        assert_eq!(deadlines.next(), ms(115));
    }
}
