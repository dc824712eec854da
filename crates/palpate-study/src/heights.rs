//! Dependence of a method's error on the start height: the same scene from 21 heights.

pub mod report;

use palpate_testbed::metrics::Fidelity;

use crate::studied::{Outcome, Studied, StudyError};
use crate::sweep::at_each;
use crate::tune::{HEIGHTS, Spread, spread};

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

/// Evaluates `columns` on `scene` from every start height. A column uses the scene's value of every unset setting.
/// Calls `done` after each height. The heights run on the threads of rayon; the results do not depend on the number
/// of threads.
///
/// # Errors
/// The scene cannot be run or has no contact or start height, or settings do not fit a column's method.
pub fn over_heights<S: Studied>(
    scene: &S,
    columns: &[S::Column],
    done: impl Fn() + Sync,
) -> Result<Vec<OverHeights>, StudyError> {
    // One damping is chosen per scene, not per height.
    let chosen = scene.choices(columns);
    let heights: Vec<Vec<Vec<(Fidelity, bool)>>> =
        at_each(&scene.start_heights()?, done, |scene| {
            let errors = |outcome: &Outcome| -> Result<_, StudyError> {
                Ok((outcome.fidelity()?, outcome.diverged))
            };
            let of_column = |outcomes: &Vec<Outcome>| outcomes.iter().map(errors).collect();
            scene.evaluate(columns)?.iter().map(of_column).collect()
        })?;
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
