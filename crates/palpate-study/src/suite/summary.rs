//! Distribution of results over the plants.

use super::{Evaluated, Score, scores};
use crate::spread::quantile;

/// Results of a column over all plants under one condition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    /// Index of the column.
    pub column: usize,
    /// Index of the condition in the set.
    pub condition: usize,
    /// Mean-force error E `[%]`: median, 75 %, 90 %, largest.
    pub error: [f64; 4],
    /// FRE `[%]`: median and 90 %.
    pub force_error: [f64; 2],
    /// FRE over the bound of the column's hold: median and 90 %.
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
    let force_errors = sorted(&|score| score.force_error);
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
        force_error: [quantile(&force_errors, 0.5)?, quantile(&force_errors, 0.9)?],
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
