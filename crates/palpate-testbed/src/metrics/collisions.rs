//! Errors of single collisions.

use std::ops::Range;

use crate::grid::Grid;
use crate::profile::{Collision, ForceProfile, Snapshot};

/// An ideal collision and the rendered collision of the same number.
#[derive(Debug, Clone, PartialEq)]
pub struct CollisionJudgement {
    /// The ideal collision.
    pub ideal: Collision,
    /// The rendered collision, `None` if there were fewer.
    pub rendered: Option<RenderedCollision>,
}

/// A rendered collision: a longest run of intervals whose held force is not 0.
///
/// Two collisions without a whole idle interval between them count as one, and a run is cut at the
/// end of the window.
#[derive(Debug, Clone, PartialEq)]
pub struct RenderedCollision {
    /// The intervals of the run.
    pub intervals: Range<usize>,
    /// Impulse on the object \[N s\].
    pub impulse: f64,
    /// Largest force that pushes the object away \[N\].
    pub peak_force: f64,
    /// (rendered − ideal)/ideal of the impulse; `None` if that is not a finite number.
    pub impulse_error: Option<f64>,
    /// (rendered − ideal)/ideal of the peak force; `None` if that is not a finite number.
    pub peak_force_error: Option<f64>,
}

/// The rendered collisions of `held`, as ranges of intervals.
pub(super) fn rendered_runs(held: &[f64]) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = Vec::new();
    for (interval, force) in held.iter().enumerate() {
        if *force == 0.0 {
            continue;
        }
        match runs.last_mut() {
            Some(run) if run.end == interval => run.end += 1,
            _ => runs.push(interval..interval + 1),
        }
    }
    runs
}

/// The first sample after `runs[number]` at which device and object have parted, if that is before
/// the next of the runs or the window's end; and the last sample it can be found at. The runs count
/// intervals of `grid`; samples need not lie on its edges.
pub(super) fn parted(
    record: &[Snapshot],
    grid: &Grid,
    runs: &[Range<usize>],
    number: usize,
) -> (Option<usize>, usize) {
    let until = runs
        .get(number + 1)
        .map_or(grid.intervals(), |next| next.start);
    let (from, until) = (grid.edge(runs[number].end), grid.edge(until));
    let first = record.partition_point(|snapshot| snapshot.time < from);
    let last = record
        .partition_point(|snapshot| snapshot.time <= until)
        .saturating_sub(1);
    let found = (first..=last).find(|&sample| record[sample].penetration() <= 0.0);
    (found, last)
}

/// Pairs the ideal collisions that end within the window with `runs`, in order.
pub(super) fn judged(
    held: &[f64],
    runs: &[Range<usize>],
    profile: &ForceProfile,
) -> Vec<CollisionJudgement> {
    profile
        .collisions()
        .iter()
        .filter(|collision| collision.end.is_some())
        .enumerate()
        .map(|(number, &ideal)| CollisionJudgement {
            ideal,
            rendered: runs
                .get(number)
                .map(|run| rendered(held, run.clone(), &ideal, profile.grid())),
        })
        .collect()
}

fn rendered(
    held: &[f64],
    intervals: Range<usize>,
    ideal: &Collision,
    grid: &Grid,
) -> RenderedCollision {
    let forces = &held[intervals.clone()];
    let period = grid.period();
    let in_periods = intervals
        .clone()
        .map(|interval| held[interval] * (grid.duration(interval) / period));
    let impulse = period * in_periods.sum::<f64>();
    let peak_force = forces.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    RenderedCollision {
        intervals,
        impulse,
        peak_force,
        impulse_error: relative_error(impulse, ideal.impulse),
        peak_force_error: relative_error(peak_force, ideal.peak_force),
    }
}

pub(super) fn relative_error(rendered: f64, ideal: f64) -> Option<f64> {
    let error = (rendered - ideal) / ideal;
    error.is_finite().then_some(error)
}
