//! Units of times, given by a column or a user, and plausibility of the sample spacing.

use std::fmt;

/// Unit of a column of times.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TimeUnit {
    /// Seconds.
    #[default]
    Second,
    /// Milliseconds.
    Millisecond,
    /// Microseconds.
    Microsecond,
    /// Nanoseconds.
    Nanosecond,
}

impl TimeUnit {
    /// All units, the longest first.
    pub const ALL: [Self; 4] = [
        Self::Second,
        Self::Millisecond,
        Self::Microsecond,
        Self::Nanosecond,
    ];

    /// Returns its symbol, in ASCII: `s`, `ms`, `us` or `ns`.
    #[must_use]
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Second => "s",
            Self::Millisecond => "ms",
            Self::Microsecond => "us",
            Self::Nanosecond => "ns",
        }
    }

    /// Returns the unit with a symbol, if there is one.
    #[must_use]
    pub fn of_symbol(symbol: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|unit| unit.symbol() == symbol)
    }

    /// Converts a time in this unit to seconds; seconds are unchanged to the last bit.
    #[must_use]
    pub fn seconds(self, time: f64) -> f64 {
        time / self.per_second()
    }

    fn per_second(self) -> f64 {
        match self {
            Self::Second => 1.0,
            Self::Millisecond => 1e3,
            Self::Microsecond => 1e6,
            Self::Nanosecond => 1e9,
        }
    }
}

impl fmt::Display for TimeUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.symbol())
    }
}

/// Longest plausible sample spacing of a recorded hand `[s]`: 4 samples per second show no contact.
const LONGEST_STEP: f64 = 0.25;
/// Shortest plausible sample spacing `[s]`: 100 kHz, above the rate of recorders of motion and texture.
const SHORTEST_STEP: f64 = 1e-5;

/// An implausible sample spacing for a recorder of a hand's motion.
///
/// ```
/// use palpate_record::unit::{Spacing, TimeUnit};
///
/// let times: Vec<f64> = (0..1000).map(f64::from).collect(); // milliseconds, taken for seconds
/// let spacing = Spacing::implausible(&times).unwrap();
/// assert_eq!(spacing.likely_unit(), Some(TimeUnit::Millisecond));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spacing {
    /// Median time from sample to sample `[s]`.
    pub median: f64,
}

impl Spacing {
    /// Returns the spacing of samples at `times` `[s]`, if it is longer than 0.25 s or shorter than 10 us; `None` if
    /// it is plausible, or for fewer than 3 samples.
    #[must_use]
    pub fn implausible(times: &[f64]) -> Option<Self> {
        if times.len() < 3 {
            return None;
        }
        let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let middle = steps.len() / 2;
        let (_, median, _) = steps.select_nth_unstable_by(middle, f64::total_cmp);
        let median = *median;
        let is_usual = (SHORTEST_STEP..=LONGEST_STEP).contains(&median);
        // The caller rejects times that are not finite or do not increase.
        (median > 0.0 && !is_usual).then_some(Self { median })
    }

    /// Returns the unit in which the spacing would be plausible, if the times were taken for seconds; `None` if there
    /// is no such unit.
    #[must_use]
    pub fn likely_unit(&self) -> Option<TimeUnit> {
        let usual =
            |unit: &TimeUnit| (SHORTEST_STEP..=LONGEST_STEP).contains(&unit.seconds(self.median));
        TimeUnit::ALL.into_iter().find(usual)
    }
}

impl fmt::Display for Spacing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the samples are {} s apart", Rounded(self.median))?;
        match self.likely_unit() {
            Some(unit) => write!(f, "; is the unit of the times {unit}?"),
            None => write!(
                f,
                "; usual: at most {LONGEST_STEP} s and at least {SHORTEST_STEP} s"
            ),
        }
    }
}

/// A number with three digits.
struct Rounded(f64);

impl fmt::Display for Rounded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rounded: f64 = format!("{:.2e}", self.0).parse().unwrap_or(self.0);
        write!(f, "{rounded}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn milliseconds_and_microseconds_taken_for_seconds_are_found() {
        let at = |step: f64| -> Vec<f64> { (0..100).map(|i| f64::from(i) * step).collect() };
        for step in [1e-4, 1e-3, 0.02, 0.2] {
            assert_eq!(Spacing::implausible(&at(step)), None, "{step} s");
        }
        for (step, unit) in [
            (1.0, TimeUnit::Millisecond),
            (10.0, TimeUnit::Millisecond),
            (1000.0, TimeUnit::Microsecond),
            (1e6, TimeUnit::Nanosecond),
        ] {
            let spacing = Spacing::implausible(&at(step)).unwrap();
            assert_eq!(spacing.likely_unit(), Some(unit), "{step}");
        }
        // Seconds taken for milliseconds.
        let short = Spacing::implausible(&at(1e-6)).unwrap();
        assert_eq!(short.likely_unit(), None);
        // A single pause does not count.
        let mut paused = at(0.001);
        paused.extend([5.0, 5.001]);
        assert_eq!(Spacing::implausible(&paused), None);
    }
}
