//! Coverage of the samples of a loop by a recorded motion.

use serde::Serialize;

use crate::text::{counted, digits, percent};

/// Largest distance of a loop instant from a recorded instant for equality, as a share of a recorded step.
const SAME_INSTANT: f64 = 1e-6;
/// Number of usual steps from which a gap causes a warning.
const REMARKABLE: f64 = 5.0;

/// A recorded motion, and the part of it that the loop interpolated.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct RecordedMotion {
    /// Number of used recorded samples.
    pub samples: usize,
    /// Number of recorded samples left out because they have no value.
    pub samples_left_out: usize,
    /// Median time between samples `[s]`.
    pub usual_step_s: f64,
    /// Longest time between samples `[s]`, over which the motion is interpolated linearly.
    pub longest_gap_s: f64,
    /// Start of the longest gap, from the first sample `[s]`.
    pub longest_gap_from_s: f64,
    /// Share of the loop's samples that are interpolated linearly between recorded ones `[%]`.
    pub interpolated_percent: f64,
}

impl RecordedMotion {
    /// Evaluates samples at the increasing `times` `[s]` for a loop of `period` `[s]`; `left_out` further samples
    /// have no value.
    #[must_use]
    pub fn new(times: &[f64], period: f64, left_out: usize) -> Self {
        let start = times.first().copied().unwrap_or(0.0);
        let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let longest = steps.iter().copied().fold(0.0, f64::max);
        // The first of equal steps, independent of rounding of their times.
        let is_longest = |step: &f64| *step >= longest * (1.0 - SAME_INSTANT);
        let longest = steps.iter().position(is_longest);
        let longest_gap_s = longest.map_or(0.0, |at| steps[at]);
        let longest_gap_from_s = longest.map_or(0.0, |at| times[at] - start);
        let middle = steps.len() / 2;
        let usual_step_s = if steps.is_empty() {
            0.0
        } else {
            *steps.select_nth_unstable_by(middle, f64::total_cmp).1
        };
        Self {
            samples: times.len(),
            samples_left_out: left_out,
            usual_step_s,
            longest_gap_s,
            longest_gap_from_s,
            interpolated_percent: interpolated(times, period),
        }
    }

    /// Returns the coverage in words.
    #[must_use]
    pub fn in_words(&self) -> String {
        let left_out = if self.samples_left_out > 0 {
            format!(", {} left out", self.samples_left_out)
        } else {
            String::new()
        };
        format!(
            "recorded: {}{left_out}; the longest gap is {} s, from {} s on; {} % of the loop's samples are interpolated",
            counted(self.samples, "sample"),
            digits(self.longest_gap_s),
            digits(self.longest_gap_from_s),
            percent(self.interpolated_percent),
        )
    }

    /// Returns a note on a gap that is much longer than usual.
    #[must_use]
    pub fn warning(&self) -> Option<String> {
        (self.longest_gap_s > REMARKABLE * self.usual_step_s).then(|| {
            format!(
                "no sample was recorded for {} s from {} s on, {} times the usual step; a straight line bridges the gap",
                digits(self.longest_gap_s),
                digits(self.longest_gap_from_s),
                (self.longest_gap_s / self.usual_step_s).round()
            )
        })
    }
}

/// Returns the share of the loop's instants between recorded ones `[%]`.
fn interpolated(times: &[f64], period: f64) -> f64 {
    let (Some(&start), Some(&end)) = (times.first(), times.last()) else {
        return 0.0;
    };
    let (mut piece, mut instants, mut between) = (0, 0_u32, 0_u32);
    loop {
        let now = start + f64::from(instants) * period;
        if now > end + SAME_INSTANT * period || now.is_nan() || instants == u32::MAX {
            break;
        }
        while piece + 2 < times.len() && times[piece + 1] <= now {
            piece += 1;
        }
        let (left, right) = (times[piece], times[times.len().min(piece + 2) - 1]);
        let slack = SAME_INSTANT * (right - left);
        between += u32::from((now - left).abs() > slack && (now - right).abs() > slack);
        instants += 1;
    }
    100.0 * f64::from(between) / f64::from(instants.max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_and_interpolated_samples_are_counted() {
        let every = |step: f64, count: i32| -> Vec<f64> {
            (0..count).map(|i| 7.0 + step * f64::from(i)).collect()
        };
        let whole = RecordedMotion::new(&every(0.001, 1001), 0.001, 0);
        assert_eq!((whole.interpolated_percent, whole.warning()), (0.0, None));
        assert_eq!(
            RecordedMotion::new(&every(0.001, 1001), 0.002, 0).interpolated_percent,
            0.0
        );
        let slow = RecordedMotion::new(&every(0.01, 101), 0.001, 0);
        assert!((slow.interpolated_percent - 100.0 * 900.0 / 1001.0).abs() < 1e-9);
        let mut missing = every(0.001, 1001);
        missing.drain(400..500);
        let gap = RecordedMotion::new(&missing, 0.001, 3);
        assert!((gap.longest_gap_s - 0.101).abs() < 1e-9);
        assert!((gap.longest_gap_from_s - 0.399).abs() < 1e-9);
        assert!((gap.interpolated_percent - 100.0 * 100.0 / 1001.0).abs() < 1e-9);
        assert_eq!(
            gap.warning().unwrap(),
            "no sample was recorded for 0.101 s from 0.399 s on, 101 times the usual step; a straight line bridges the gap"
        );
        assert_eq!(
            gap.in_words(),
            "recorded: 901 samples, 3 left out; the longest gap is 0.101 s, from 0.399 s on; 10.0 % of the loop's samples \
             are interpolated"
        );
    }
}
