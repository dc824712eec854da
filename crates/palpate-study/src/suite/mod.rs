//! How good methods are on plants drawn at random.
//!
//! A scene that somebody chose says how good a method is on that scene. [`RandomPlant`] draws
//! devices, hands, objects and sensors over the whole range that desktop devices have, [`run`]
//! judges columns of methods on them, without and with a delay, and [`summary`] says how the
//! errors are spread. What is drawn, and how, stands in `docs/suite.md`.

mod chance;
mod column;
mod draw;
pub mod report;
mod spread;
pub mod table;

pub use column::{Column, ColumnError, Dampings};
pub use draw::{DrawError, RandomPlant};
pub use spread::{Summary, quantile, summary};

use palpate_testbed::metrics::{Fidelity, ForceJudgement};
use rayon::prelude::*;

use palpate_scene::Scene;
use palpate_sim::closed_loop::{Bench, LoopError};

/// Delays that every plant is judged with `[samples]`.
pub const DELAYS: [usize; 2] = [0, 1];

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
    /// Largest force of the ideal `[N]`.
    pub ideal_peak: f64,
    /// For each delay of [`DELAYS`] every column, in their order.
    pub trials: Vec<Trial>,
}

/// What one column did on one plant with one delay.
#[derive(Clone, Debug)]
pub struct Trial {
    /// Which of the columns.
    pub column: usize,
    /// Delay between measuring and actuating `[samples]`.
    pub delay: usize,
    /// The damping that was best here `[N s/m]`, of a column that chooses.
    pub damping: Option<f64>,
    /// Samples that were taken.
    pub samples: usize,
    /// Samples whose force a limit or a guard changed.
    pub limited: usize,
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

/// Judges `columns` on the first `plants` plants of `seed`; `done` hears of each plant that is
/// finished. Plants are judged on as many threads as rayon has; what comes out does not depend on
/// how many those are, bit by bit.
///
/// # Errors
/// Settings that do not make a column's method.
pub fn run(
    seed: u64,
    plants: usize,
    columns: &[Column],
    done: impl Fn() + Sync,
) -> Result<Vec<Judged>, SuiteError> {
    (0..plants)
        .into_par_iter()
        .map(|index| {
            let judged = judge(RandomPlant::draw(seed, index)?, columns);
            done();
            judged
        })
        .collect()
}

fn judge(plant: RandomPlant, columns: &[Column]) -> Result<Judged, SuiteError> {
    let index = plant.index;
    let of_plant = |error| SuiteError::Plant {
        plant: index,
        error,
    };
    let bench = Bench::new(&plant.scene).map_err(of_plant)?;
    let mut trials = Vec::with_capacity(DELAYS.len() * columns.len());
    for delay in DELAYS {
        for (number, column) in columns.iter().enumerate() {
            let delayed = Scene {
                delay,
                ..plant.scene.clone()
            };
            let mut best: Option<Trial> = None;
            for (damping, scene) in column.candidates(&delayed) {
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
                    delay,
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
    let reference = bench.reference();
    let collisions = reference.profile.collisions().iter();
    Ok(Judged {
        periods: reference.profile.intervals(),
        ideal_error: reference.error,
        ideal_peak: collisions.map(|one| one.peak_force).fold(0.0, f64::max),
        trials,
        plant,
    })
}
