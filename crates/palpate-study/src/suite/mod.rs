//! Evaluation of methods on random plants.
//!
//! A chosen scene shows the quality of a method on that scene only. [`RandomPlant`] draws devices, hands, objects and
//! sensors over the whole range of desktop devices. [`run`] evaluates columns of methods on them, under the
//! [`Condition`]s of a [`Set`], and [`summary`] returns the distribution of the errors. `docs/results/suite.md`
//! describes the distributions of the plants.

mod chance;
mod column;
mod desk;
mod draw;
mod paired;
pub mod report;
mod score;
mod set;
mod steps;
mod summary;
pub mod table;

pub(crate) use chance::Chance;
pub use column::{Column, ColumnError, Dampings};
pub use draw::{DrawError, RandomPlant};
pub use paired::{Median, Paired};
pub use score::{Score, plants, scores};
pub use set::{Condition, Set, Telling};
pub use steps::Step;
pub use summary::{Summary, summary};

use std::ops::Range;

use palpate_testbed::metrics::{Fidelity, ForceEvaluation};
use rayon::prelude::*;

use crate::sim::closed_loop::{Bench, LoopError};

/// Delays of every plant of the paper's set `[samples]`, also in the renderer's model. The last one is also run
/// without a delay in the model.
pub const DELAYS: [usize; 2] = [0, 1];

/// Maximum number of plants.
pub const MAX_PLANTS: u32 = 1_000_000;

/// Number of collisions of the ideal in the evaluation of a plant.
pub const COLLISIONS: usize = 3;

/// A plant with the results of every column.
#[derive(Clone, Debug)]
pub struct Evaluated {
    /// The plant.
    pub plant: RandomPlant,
    /// Window `[periods]`.
    pub periods: usize,
    /// Largest error of an interval's impulse of the ideal, relative to the largest impulse.
    pub ideal_error: f64,
    /// Largest force of the ideal under the first condition `[N]`.
    pub ideal_peak: f64,
    /// Every column in order, for each condition of the set.
    pub trials: Vec<Trial>,
}

/// Result of one column on one plant under one condition.
#[derive(Clone, Debug)]
pub struct Trial {
    /// Index of the column.
    pub column: usize,
    /// Index of the condition in the set.
    pub condition: usize,
    /// The best damping here `[N s/m]`, for a column with several dampings.
    pub damping: Option<f64>,
    /// Number of samples.
    pub samples: usize,
    /// Number of samples with a force changed by a limit or a guard.
    pub limited: usize,
    /// Largest force of the ideal under this condition `[N]`.
    pub ideal_peak: f64,
    /// Errors over the window.
    pub fidelity: Fidelity,
    /// Evaluation of the force, collision by collision.
    pub force: ForceEvaluation,
    /// Whether the loop diverged.
    pub diverged: bool,
}

/// Reason why a suite cannot be run.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SuiteError {
    /// A plant cannot be drawn.
    #[error(transparent)]
    Draw(#[from] DrawError),
    /// A plant cannot be run.
    #[error("plant {plant}: {error}")]
    Plant {
        /// Number of the plant.
        plant: usize,
        /// Cause of the error.
        error: LoopError,
    },
    /// A column cannot be run.
    #[error("column {column} on plant {plant}: {error}")]
    Column {
        /// Name of the column.
        column: String,
        /// Number of the plant.
        plant: usize,
        /// Cause of the error.
        error: LoopError,
    },
}

/// Evaluates `columns` on the first `plants` plants of `seed` of a `set`, like [`run_part`].
///
/// # Errors
/// Settings do not fit a column's method.
pub fn run(
    set: Set,
    seed: u64,
    plants: usize,
    columns: &[Column],
    done: impl Fn() + Sync,
) -> Result<Vec<Evaluated>, SuiteError> {
    run_part(set, seed, 0..plants, columns, done)
}

/// Evaluates `columns` on these `plants` of `seed` of a `set`. Calls `done` after each plant. The plants run on the
/// threads of rayon; the results do not depend on the number of threads, bit by bit.
///
/// # Errors
/// Settings do not fit a column's method.
pub fn run_part(
    set: Set,
    seed: u64,
    plants: Range<usize>,
    columns: &[Column],
    done: impl Fn() + Sync,
) -> Result<Vec<Evaluated>, SuiteError> {
    let conditions = set.conditions();
    plants
        .into_par_iter()
        .map(|index| {
            let evaluated = evaluate(set.draw(seed, index)?, &conditions, columns);
            done();
            evaluated
        })
        // A caller cancels the rest by a panic in `done`.
        .panic_fuse()
        .collect()
}

/// Returns the largest force of a bench's ideal `[N]`.
fn peak(bench: &Bench<'_>) -> f64 {
    let collisions = bench.reference().profile.collisions().iter();
    collisions.map(|one| one.peak_force).fold(0.0, f64::max)
}

fn evaluate(
    plant: RandomPlant,
    conditions: &[Condition],
    columns: &[Column],
) -> Result<Evaluated, SuiteError> {
    let index = plant.index;
    let of_plant = |error| SuiteError::Plant {
        plant: index,
        error,
    };
    let first = conditions[0].of(&plant);
    let shared = Bench::new(&first).map_err(of_plant)?;
    let mut trials = Vec::with_capacity(conditions.len() * columns.len());
    for (place, condition) in conditions.iter().enumerate() {
        let scene = condition.of(&plant);
        let own = (!shared.evaluates(&scene)).then(|| Bench::new(&scene));
        let own = own.transpose().map_err(of_plant)?;
        let bench = own.as_ref().unwrap_or(&shared);
        for (number, column) in columns.iter().enumerate() {
            let mut best: Option<Trial> = None;
            for (damping, scene) in column.candidates(&scene) {
                let run = bench.run_varied(&scene, column.method).map_err(|error| {
                    SuiteError::Column {
                        column: column.name.clone(),
                        plant: index,
                        error,
                    }
                })?;
                let fidelity = run.force.fidelity.expect("collisions have a force");
                let error = |trial: &Trial| trial.fidelity.mean_force_error;
                if best
                    .as_ref()
                    .is_some_and(|best| error(best) <= fidelity.mean_force_error)
                {
                    continue;
                }
                best = Some(Trial {
                    column: number,
                    condition: place,
                    ideal_peak: peak(bench),
                    damping,
                    fidelity,
                    diverged: run.diverged == Some(true),
                    samples: run.ticks.len(),
                    limited: run.limited(),
                    force: run.force,
                });
            }
            trials.extend(best);
        }
    }
    let reference = shared.reference();
    Ok(Evaluated {
        periods: reference.profile.intervals(),
        ideal_error: reference.error,
        ideal_peak: peak(&shared),
        trials,
        plant,
    })
}
