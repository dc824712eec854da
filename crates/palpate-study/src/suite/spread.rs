//! Distribution of results over the plants.

use serde::Serialize;

use super::{Evaluated, Score, scores};
use crate::text::short;

/// Results of a column over all plants under one condition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    /// Index of the column.
    pub column: usize,
    /// Index of the condition in the set.
    pub condition: usize,
    /// Mean-force error E `[%]`: median, 75 %, 90 %, largest.
    pub error: [f64; 4],
    /// FRE over the zero-order-hold bound: median and 90 %.
    pub error_over_bound: [f64; 2],
    /// Number of plants on which the loop diverged.
    pub diverged: usize,
    /// Number of plants on which a limit or a guard changed a force.
    pub held_back: usize,
    /// Share of all samples with a force changed by a limit or a guard.
    pub limited: f64,
    /// Largest held force over the largest of the ideal: median and largest.
    pub peak_ratio: [f64; 2],
}

/// Returns the summary of `column` under the `condition` of this index in the set; `None` without a plant. In the
/// paper's set the index equals the delay.
#[must_use]
pub fn summary(evaluated: &[Evaluated], column: usize, condition: usize) -> Option<Summary> {
    summary_of(&scores(evaluated), column, condition)
}

/// Returns the [`summary`] of scores.
pub(super) fn summary_of(scores: &[Score], column: usize, condition: usize) -> Option<Summary> {
    let trials = || {
        let of_column =
            move |score: &&Score| score.column == column && score.condition == condition;
        scores.iter().filter(of_column)
    };
    let sorted = |value: &dyn Fn(&Score) -> f64| {
        let mut values: Vec<f64> = trials().map(value).collect();
        values.sort_by(f64::total_cmp);
        values
    };
    let errors = sorted(&|score| score.error);
    let ratios = sorted(&|score| score.error_over_bound);
    let peaks = sorted(&|score| score.peak_ratio);
    Some(Summary {
        column,
        condition,
        error: [
            quantile(&errors, 0.5)?,
            quantile(&errors, 0.75)?,
            quantile(&errors, 0.9)?,
            quantile(&errors, 1.0)?,
        ],
        error_over_bound: [quantile(&ratios, 0.5)?, quantile(&ratios, 0.9)?],
        diverged: trials().filter(|score| score.diverged).count(),
        held_back: trials().filter(|score| score.limited > 0).count(),
        limited: {
            let sum = |of: fn(&Score) -> usize| trials().map(of).sum::<usize>();
            sum(|score| score.limited) as f64 / sum(|score| score.samples) as f64
        },
        peak_ratio: [quantile(&peaks, 0.5)?, quantile(&peaks, 1.0)?],
    })
}

/// Spread of a value over the seeds of random numbers. An infinite value is `null` in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Spread {
    /// Median over the seeds.
    pub median: f64,
    /// Smallest value of a seed.
    pub least: f64,
    /// Largest value of a seed.
    pub largest: f64,
}

impl Spread {
    /// Returns the spread of one value per seed; `None` without a seed.
    #[must_use]
    pub fn new(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut sorted: Vec<f64> = values.into_iter().collect();
        sorted.sort_by(f64::total_cmp);
        Some(Self {
            median: quantile(&sorted, 0.5)?,
            least: *sorted.first()?,
            largest: *sorted.last()?,
        })
    }

    /// Returns the spread of each value times a positive factor.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        Self {
            median: factor * self.median,
            least: factor * self.least,
            largest: factor * self.largest,
        }
    }

    /// Returns the median with the range: `68.2 (45.1-70.3)`.
    #[must_use]
    pub fn in_short(&self, decimals: usize) -> String {
        let [median, least, largest] =
            [self.median, self.least, self.largest].map(|value| short(value, decimals));
        format!("{median} ({least}-{largest})")
    }
}

/// Returns the value below which a `share` of the `sorted` values lies, interpolated linearly; `None` for an empty
/// slice.
#[must_use]
pub fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    let place = share.clamp(0.0, 1.0) * sorted.len().checked_sub(1)? as f64;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "an index"
    )]
    let (below, above) = (place.floor() as usize, place.ceil() as usize);
    let (low, high) = (sorted[below], sorted[above]);
    // Equal neighbours, also infinite ones, need no interpolation.
    if low == high {
        Some(low)
    } else {
        Some(low + (high - low) * (place - place.floor()))
    }
}

#[cfg(test)]
mod tests {
    use super::quantile;

    #[test]
    fn quantiles_lie_on_straight_lines_between_neighbours() {
        let values = [1.0, 2.0, 4.0, 8.0, 16.0];
        assert_eq!(quantile(&values, 0.0), Some(1.0));
        assert_eq!(quantile(&values, 0.5), Some(4.0));
        assert_eq!(quantile(&values, 0.75), Some(8.0));
        assert!((quantile(&values, 0.9).unwrap() - 12.8).abs() < 1e-12);
        assert_eq!(quantile(&values, 1.0), Some(16.0));
        assert_eq!(quantile(&[3.0], 0.5), Some(3.0));
        assert_eq!(quantile(&[], 0.5), None);
        assert_eq!(
            quantile(&[1.0, f64::INFINITY, f64::INFINITY], 0.75),
            Some(f64::INFINITY)
        );
    }
}
