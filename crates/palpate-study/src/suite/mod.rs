//! How good methods are on plants drawn at random.
//!
//! A scene that somebody chose says how good a method is on that scene. [`RandomPlant`] draws
//! devices, hands, objects and sensors over the whole range that desktop devices have, [`run`]
//! judges columns of methods on them, under the [`Condition`]s of a [`Set`], and [`summary`] says how the
//! errors are spread. What is drawn, and how, stands in `docs/suite.md`.

mod chance;
mod column;
mod desk;
mod draw;
pub mod report;
mod score;
mod set;
mod spread;
mod steps;
pub mod table;

pub use column::{Column, ColumnError, Dampings};
pub use draw::{DrawError, RandomPlant};
pub use score::{Score, plants, scores};
pub use set::{Condition, Set, Telling};
pub use spread::{Spread, Summary, quantile, summary};
pub use steps::Step;

use std::ops::Range;

use palpate_testbed::metrics::{Fidelity, ForceJudgement};
use rayon::prelude::*;

use palpate_sim::closed_loop::{Bench, LoopError};

/// Delays of every plant of the paper's set `[samples]`, in the renderer's model too. The last one
/// is also run without it in the model.
pub const DELAYS: [usize; 2] = [0, 1];

/// Most plants that may be asked for.
pub const MOST_PLANTS: u32 = 1_000_000;

/// Collisions of the ideal over which a plant is judged.
pub const COLLISIONS: usize = 3;

/// A plant and what every column did on it.
#[derive(Clone, Debug)]
pub struct Judged {
    /// The plant.
    pub plant: RandomPlant,
    /// Window `[periods]`.
    pub periods: usize,
    /// Error of any interval's impulse of the ideal, relative to the largest.
    pub ideal_error: f64,
    /// Largest force of the ideal under the first condition `[N]`.
    pub ideal_peak: f64,
    /// For each condition of the set every column, in their order.
    pub trials: Vec<Trial>,
}

/// What one column did on one plant under one condition.
#[derive(Clone, Debug)]
pub struct Trial {
    /// Which of the columns.
    pub column: usize,
    /// Which of the conditions of the set.
    pub condition: usize,
    /// The damping that was best here `[N s/m]`, of a column that chooses.
    pub damping: Option<f64>,
    /// Samples that were taken.
    pub samples: usize,
    /// Samples whose force a limit or a guard changed.
    pub limited: usize,
    /// Largest force of the ideal under this condition `[N]`.
    pub ideal_peak: f64,
    /// Errors over the window.
    pub fidelity: Fidelity,
    /// The verdict on the force, collision by collision.
    pub force: ForceJudgement,
    /// Whether the loop ran away.
    pub diverged: bool,
}

/// Why a suite cannot be run.
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
        /// What is wrong.
        error: LoopError,
    },
    /// A column cannot be run.
    #[error("column {column} on plant {plant}: {error}")]
    Column {
        /// Name of the column.
        column: String,
        /// Number of the plant.
        plant: usize,
        /// What is wrong.
        error: LoopError,
    },
}

/// Judges `columns` on the first `plants` plants of `seed` of a `set`, as [`run_part`] does.
///
/// # Errors
/// Settings that do not make a column's method.
pub fn run(
    set: Set,
    seed: u64,
    plants: usize,
    columns: &[Column],
    done: impl Fn() + Sync,
) -> Result<Vec<Judged>, SuiteError> {
    run_part(set, seed, 0..plants, columns, done)
}

/// Judges `columns` on these `plants` of `seed` of a `set`; `done` hears of each plant that is
/// finished. Plants are judged on as many threads as rayon has; what comes out does not depend on
/// how many those are, bit by bit.
///
/// # Errors
/// Settings that do not make a column's method.
pub fn run_part(
    set: Set,
    seed: u64,
    plants: Range<usize>,
    columns: &[Column],
    done: impl Fn() + Sync,
) -> Result<Vec<Judged>, SuiteError> {
    let conditions = set.conditions();
    plants
        .into_par_iter()
        .map(|index| {
            let judged = judge(set.draw(seed, index)?, &conditions, columns);
            done();
            judged
        })
        // Who wants no more of it lets `done` panic.
        .panic_fuse()
        .collect()
}

/// Largest force of a bench's ideal `[N]`.
fn peak(bench: &Bench<'_>) -> f64 {
    let collisions = bench.reference().profile.collisions().iter();
    collisions.map(|one| one.peak_force).fold(0.0, f64::max)
}

fn judge(
    plant: RandomPlant,
    conditions: &[Condition],
    columns: &[Column],
) -> Result<Judged, SuiteError> {
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
        let own = (!shared.judges(&scene)).then(|| Bench::new(&scene));
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
    Ok(Judged {
        periods: reference.profile.intervals(),
        ideal_error: reference.error,
        ideal_peak: peak(&shared),
        trials,
        plant,
    })
}
