//! Detection of missing ticks from the numbers of the others.

/// A gap of missing ticks in a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gap {
    /// Number of the last tick before the gap; `None` at the start.
    pub after: Option<u64>,
    /// Number of missing ticks.
    pub count: u64,
}

/// Counter of missing ticks.
#[derive(Clone, Debug, Default)]
pub(super) struct Loss {
    last: Option<u64>,
    /// Highest tick number mentioned by any item.
    known: Option<u64>,
    gaps: Vec<Gap>,
}

impl Loss {
    /// Adds a recorded tick; returns false if its number does not increase.
    #[must_use]
    pub fn tick(&mut self, sequence: u64) -> bool {
        if self.last.is_some_and(|last| sequence <= last) {
            return false;
        }
        self.up_to(sequence);
        self.last = Some(sequence);
        true
    }

    /// Adds a tick number mentioned by an item, whether or not the tick is recorded.
    pub fn named(&mut self, sequence: u64) {
        self.known = self.known.max(Some(sequence));
    }

    /// Returns all gaps, including that between the last tick and the last mentioned one.
    pub fn gaps(mut self) -> Vec<Gap> {
        if let Some(beyond) = self.known.and_then(|known| known.checked_add(1)) {
            self.up_to(beyond);
        }
        self.gaps
    }

    /// Counts the missing ticks below `sequence`.
    fn up_to(&mut self, sequence: u64) {
        let next = self.last.map_or(0, |last| last + 1);
        let count = sequence.saturating_sub(next);
        if count > 0 {
            self.gaps.push(Gap {
                after: self.last,
                count,
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gaps(ticks: &[u64], named: &[u64]) -> Vec<(Option<u64>, u64)> {
        let mut loss = Loss::default();
        for &sequence in ticks {
            assert!(loss.tick(sequence));
        }
        for &sequence in named {
            loss.named(sequence);
        }
        let gaps = loss.gaps();
        gaps.iter().map(|gap| (gap.after, gap.count)).collect()
    }

    #[test]
    fn what_is_missing_before_between_and_after_is_counted() {
        assert_eq!(gaps(&[0, 1, 2], &[1, 2]), []);
        assert_eq!(gaps(&[], &[]), []);
        assert_eq!(gaps(&[2, 3, 7], &[]), [(None, 2), (Some(3), 3)]);
        assert_eq!(gaps(&[0, 1], &[4]), [(Some(1), 3)]);
        assert_eq!(gaps(&[], &[4]), [(None, 5)]);
        assert_eq!(gaps(&[0, u64::MAX], &[u64::MAX]), [(Some(0), u64::MAX - 1)]);
    }

    #[test]
    fn numbers_rise() {
        let mut loss = Loss::default();
        assert!(loss.tick(3) && !loss.tick(3) && !loss.tick(2) && loss.tick(4));
    }
}
