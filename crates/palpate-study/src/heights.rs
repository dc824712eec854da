//! Dependence of a method's error on the start height: the same scene from 21 heights.

pub mod report;

use rayon::prelude::*;

use palpate_testbed::metrics::Fidelity;

use crate::sim::closed_loop::{Bench, LoopError};
use crate::suite::Column;
use crate::tune::{HEIGHTS, Spread, at_height, spread};
use palpate_scene::Scene;

/// Results of a column on a scene over the start heights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OverHeights {
    /// Mean-force error E `[%]`.
    pub error: Spread,
    /// Force rendering error FRE `[%]`.
    pub force_rendering_error: Spread,
    /// Errors at the scene's own height.
    pub own: Fidelity,
    /// Heights at which the loop diverged.
    pub diverged: usize,
    /// The damping with the lowest median error `[N s/m]`, for a column with several dampings.
    pub damping: Option<f64>,
}

/// Reason why a column cannot be evaluated on a scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HeightsError {
    /// The ideal has no contact, so there is no error.
    #[error("the ideal has no contact in the window, so there is no error")]
    NoContact,
    /// The scene cannot be run.
    #[error(transparent)]
    Scene(LoopError),
    /// A column cannot be run.
    #[error("column {column}: {error}")]
    Column {
        /// Name of the column.
        column: String,
        /// Cause of the error.
        error: LoopError,
    },
}

/// Evaluates `columns` on `scene` from every start height. A column uses the scene's value of every unset setting.
/// Calls `done` after each height. The heights run on the threads of rayon; the results do not depend on the number
/// of threads.
///
/// # Errors
/// The scene cannot be run or has no contact, or settings do not fit a column's method.
pub fn over_heights(
    scene: &Scene,
    columns: &[Column],
    done: impl Fn() + Sync,
) -> Result<Vec<OverHeights>, HeightsError> {
    // One damping is chosen per scene, not per height.
    let chosen: Vec<Vec<Option<f64>>> = columns
        .iter()
        .map(|column| {
            let of_scene = column.candidates(scene).into_iter();
            of_scene.map(|(damping, _)| damping).collect()
        })
        .collect();
    let heights: Vec<Vec<Vec<(Fidelity, bool)>>> = (0..HEIGHTS)
        .into_par_iter()
        .map(|height| {
            let evaluated = at_one(&at_height(scene, height), columns);
            done();
            evaluated
        })
        // A caller cancels the rest by a panic in `done`.
        .panic_fuse()
        .collect::<Result<_, _>>()?;
    Ok((0..columns.len())
        .map(|column| {
            let candidates = chosen[column].iter().enumerate();
            candidates
                .map(|(candidate, damping)| {
                    let of = |one: &[Vec<(Fidelity, bool)>]| one[column][candidate];
                    OverHeights {
                        error: spread(heights.iter().map(|one| of(one).0.mean_force_error)),
                        force_rendering_error: spread(
                            heights.iter().map(|one| of(one).0.force_rendering_error),
                        ),
                        own: of(&heights[HEIGHTS / 2]).0,
                        diverged: heights.iter().filter(|one| of(one).1).count(),
                        damping: *damping,
                    }
                })
                .min_by(|a, b| a.error.median.total_cmp(&b.error.median))
                .expect("one candidate at least")
        })
        .collect())
}

/// Returns the errors of every column's candidates, and whether they diverged.
fn at_one(scene: &Scene, columns: &[Column]) -> Result<Vec<Vec<(Fidelity, bool)>>, HeightsError> {
    let bench = Bench::new(scene).map_err(HeightsError::Scene)?;
    let evaluated = |column: &Column, varied: &Scene| {
        let run =
            bench
                .run_varied(varied, column.method)
                .map_err(|error| HeightsError::Column {
                    column: column.name.clone(),
                    error,
                })?;
        let fidelity = run.force.fidelity.ok_or(HeightsError::NoContact)?;
        Ok((fidelity, run.diverged == Some(true)))
    };
    columns
        .iter()
        .map(|column| {
            let candidates = column.candidates(scene);
            let runs = candidates
                .iter()
                .map(|(_, varied)| evaluated(column, varied));
            runs.collect()
        })
        .collect()
}
