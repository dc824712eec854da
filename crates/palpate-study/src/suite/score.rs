//! Input numbers of a report on a suite.

use super::Evaluated;

/// Result of one column on one plant under one condition, reduced to the reported numbers. Scores of several parts of
/// a suite can be combined into the report of the whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Score {
    /// Number of the plant.
    pub plant: usize,
    /// Number of rejected draws of the plant.
    pub redrawn: u32,
    /// Largest error of an interval's impulse of the plant's ideal, relative to the largest impulse.
    pub ideal_error: f64,
    /// Index of the condition in the set.
    pub condition: usize,
    /// Index of the column.
    pub column: usize,
    /// Mean-force error E `[%]`.
    pub error: f64,
    /// FRE `[%]`.
    pub force_error: f64,
    /// FRE over the bound of the column's hold; infinite if the bound is 0.
    pub error_over_bound: f64,
    /// Largest held force over the largest of the ideal.
    pub peak_ratio: f64,
    /// Whether the loop diverged.
    pub diverged: bool,
    /// Number of samples.
    pub samples: usize,
    /// Number of samples with a force changed by a limit or a guard.
    pub limited: usize,
}

impl Evaluated {
    /// Returns a score per trial, in order.
    pub fn scores(&self) -> impl Iterator<Item = Score> {
        self.trials.iter().map(|trial| Score {
            plant: self.plant.index,
            redrawn: self.plant.redrawn,
            ideal_error: self.ideal_error,
            condition: trial.condition,
            column: trial.column,
            error: trial.fidelity.mean_force_error,
            force_error: trial.fidelity.force_rendering_error,
            error_over_bound: trial.fidelity.error_over_bound.unwrap_or(f64::INFINITY),
            peak_ratio: trial.force.peak_force / trial.ideal_peak,
            diverged: trial.diverged,
            samples: trial.samples,
            limited: trial.limited,
        })
    }
}

/// Returns the scores of all of these plants.
#[must_use]
pub fn scores(evaluated: &[Evaluated]) -> Vec<Score> {
    evaluated.iter().flat_map(Evaluated::scores).collect()
}

/// Returns the number of plants of scores that are grouped by plant.
#[must_use]
pub fn plants(scores: &[Score]) -> usize {
    scores.chunk_by(|a, b| a.plant == b.plant).count()
}
