//! The numbers that a report on a suite is made from.

use super::Judged;

/// What one column did on one plant under one condition, as far as a report says it. Scores of several parts
/// of a suite make the report of the whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Score {
    /// Number of the plant.
    pub plant: usize,
    /// How often the plant was drawn again.
    pub redrawn: u32,
    /// Error of any interval's impulse of the plant's ideal, relative to the largest.
    pub ideal_error: f64,
    /// Which of the conditions of the set.
    pub condition: usize,
    /// Which of the columns.
    pub column: usize,
    /// Mean-force error E `[%]`.
    pub error: f64,
    /// FRE over the hold floor; infinite where the floor is 0, which is no floor to be over.
    pub error_over_floor: f64,
    /// Largest held force over the largest of the ideal.
    pub peak_ratio: f64,
    /// Whether the loop ran away.
    pub diverged: bool,
    /// Samples that were taken.
    pub samples: usize,
    /// Samples whose force a limit or a guard changed.
    pub limited: usize,
}

impl Judged {
    /// A score for each trial, in their order.
    pub fn scores(&self) -> impl Iterator<Item = Score> {
        self.trials.iter().map(|trial| Score {
            plant: self.plant.index,
            redrawn: self.plant.redrawn,
            ideal_error: self.ideal_error,
            condition: trial.condition,
            column: trial.column,
            error: trial.fidelity.mean_force_error,
            error_over_floor: trial.fidelity.error_over_floor.unwrap_or(f64::INFINITY),
            peak_ratio: trial.force.peak_force / trial.ideal_peak,
            diverged: trial.diverged,
            samples: trial.samples,
            limited: trial.limited,
        })
    }
}

/// The scores of all of these plants.
#[must_use]
pub fn scores(judged: &[Judged]) -> Vec<Score> {
    judged.iter().flat_map(Judged::scores).collect()
}

/// How many plants the scores are of, where those of a plant stand together.
#[must_use]
pub fn plants(scores: &[Score]) -> usize {
    scores.chunk_by(|a, b| a.plant == b.plant).count()
}
