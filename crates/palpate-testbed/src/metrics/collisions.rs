//! Errors of single collisions.

use std::ops::Range;

use crate::grid::Grid;
use crate::profile::{Collision, ForceProfile, Snapshot};

/// Largest ratio of the held force between two separate collisions to the smaller of their peak forces. A renderer that
/// corrects past commands keeps holding a small force after the contact has ended.
const VALLEY: f64 = 0.05;

/// Largest impulse of such a remainder, relative to that of each of its neighbours.
const REMAINDER: f64 = 0.01;

/// An ideal collision and the rendered collision of the same number.
#[derive(Debug, Clone, PartialEq)]
pub struct CollisionEvaluation {
    /// The ideal collision; several that no held force can show apart are one.
    pub ideal: Collision,
    /// The rendered collision, `None` if there were fewer.
    pub rendered: Option<RenderedCollision>,
}

/// A rendered collision: a run of intervals in which a force is held.
///
/// Two collisions are separate if the force between them falls to 0, or to a twentieth of the smaller of their peak
/// forces. The second begins at the interval with the smallest force. A force with less than a hundredth of the impulse
/// of each neighbour is not a collision; it belongs to the one before it. The same rule is applied to the interval
/// means of the ideal force, so ideal and rendered collisions are counted alike: two ideal collisions with a gap too
/// short for the loop's rate count as one. A run is cut at the end of the window.
#[derive(Debug, Clone, PartialEq)]
pub struct RenderedCollision {
    /// The intervals of the run.
    pub intervals: Range<usize>,
    /// Impulse on the object `[N s]`.
    pub impulse: f64,
    /// Largest force that pushes the object away `[N]`.
    pub peak_force: f64,
    /// (rendered − ideal)/ideal of the impulse; `None` if that is not a finite number.
    pub impulse_error: Option<f64>,
    /// (rendered − ideal)/ideal of the peak force; `None` if that is not a finite number.
    pub peak_force_error: Option<f64>,
}

/// The collisions of the force `held` over each interval of `grid` `[N]`, as ranges of intervals.
pub(crate) fn separated(held: &[f64], grid: &Grid) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = Vec::new();
    let mut interval = 0;
    while interval < held.len() {
        let start = interval;
        while interval < held.len() && held[interval] != 0.0 {
            interval += 1;
        }
        if interval > start {
            cut_at_valleys(held, start..interval, &mut runs);
        }
        interval += 1;
    }
    join_remainders(held, grid, runs)
}

/// Cuts a run without an interval of no force where the force is small between two peaks.
fn cut_at_valleys(held: &[f64], run: Range<usize>, runs: &mut Vec<Range<usize>>) {
    let mut start = run.start;
    // The peak since `start`, and the smallest force since that peak, with its interval.
    let mut peak = 0.0_f64;
    let mut valley = (f64::INFINITY, run.start);
    for interval in run.clone() {
        let force = held[interval].abs();
        if force > VALLEY.recip() * valley.0 && peak > VALLEY.recip() * valley.0 {
            runs.push(start..valley.1);
            start = valley.1;
            (peak, valley) = (force, (f64::INFINITY, interval));
        } else if force > peak {
            (peak, valley) = (force, (f64::INFINITY, interval));
        } else if force < valley.0 {
            valley = (force, interval);
        }
    }
    runs.push(start..run.end);
}

/// Joins what is too small to be a collision to the one before it; before the first, to the next.
fn join_remainders(held: &[f64], grid: &Grid, runs: Vec<Range<usize>>) -> Vec<Range<usize>> {
    let impulse = |run: &Range<usize>| impulse(held, run.clone(), grid).abs();
    let impulses: Vec<f64> = runs.iter().map(impulse).collect();
    let mut joined: Vec<Range<usize>> = Vec::with_capacity(runs.len());
    let mut first = None;
    for (number, run) in runs.into_iter().enumerate() {
        let neighbours = [number.checked_sub(1), Some(number + 1)];
        let mut neighbours = neighbours.iter().flatten().filter_map(|&n| impulses.get(n));
        let is_remainder = impulses.len() > 1
            && neighbours.all(|neighbour| impulses[number] < REMAINDER * neighbour);
        match (is_remainder, joined.last_mut()) {
            (true, Some(before)) => before.end = run.end,
            (true, None) => first = Some(run.start),
            (false, _) => joined.push(first.take().unwrap_or(run.start)..run.end),
        }
    }
    joined
}

/// Returns the ideal collisions of `profile` that end within its window. Collisions that `means`, the interval means
/// cut into collisions, cannot resolve are merged into one.
pub(super) fn ideal_collisions(profile: &ForceProfile) -> Vec<Collision> {
    let grid = profile.grid();
    let means: Vec<f64> = profile.mean_forces().collect();
    let cuts: Vec<f64> = separated(&means, grid)
        .iter()
        .skip(1)
        .map(|run| grid.edge(run.start))
        .collect();
    // A run begins in the interval in which its first collision does, or in the one before: what is
    // cut through by an edge has most of itself after it.
    let number_of = |collision: &Collision| {
        let end = collision.end.unwrap_or(grid.end());
        let middle = 0.5 * (collision.start + end);
        cuts.partition_point(|&cut| cut <= middle)
    };
    let mut joined: Vec<(usize, Collision)> = Vec::new();
    for collision in profile.collisions() {
        let number = number_of(collision);
        match joined.last_mut() {
            Some((last, before)) if *last == number => {
                before.end = collision.end;
                before.release_speed = collision.release_speed;
                before.impulse += collision.impulse;
                before.peak_force = before.peak_force.max(collision.peak_force);
            }
            _ => joined.push((number, *collision)),
        }
    }
    joined
        .into_iter()
        .map(|(_, collision)| collision)
        .filter(|collision| collision.end.is_some())
        .collect()
}

/// The first sample after the force of `runs[number]` at which device and object have parted, if that
/// is before the next of the runs or the window's end; and the last sample it can be found at. The runs
/// count intervals of `grid`; samples need not lie on its edges.
pub(super) fn parted(
    record: &[Snapshot],
    held: &[f64],
    grid: &Grid,
    runs: &[Range<usize>],
    number: usize,
) -> (Option<usize>, usize) {
    let until = runs
        .get(number + 1)
        .map_or(grid.intervals(), |next| next.start);
    let (from, until) = (
        grid.edge(end_of_push(held, &runs[number])),
        grid.edge(until),
    );
    let first = record.partition_point(|snapshot| snapshot.time < from);
    let last = record
        .partition_point(|snapshot| snapshot.time <= until)
        .saturating_sub(1);
    let found = (first..=last).find(|&sample| record[sample].penetration() <= 0.0);
    (found, last)
}

/// The end of `run` without what a renderer still corrects after contact, a hundredth of the run's peak
/// force at most.
fn end_of_push(held: &[f64], run: &Range<usize>) -> usize {
    let least = least_push(held, run);
    run.clone()
        .rfind(|&interval| held[interval].abs() >= least)
        .map_or(run.end, |last| last + 1)
}

/// The force that counts as a push in `run`; what is smaller is a remainder `[N]`.
pub(super) fn least_push(held: &[f64], run: &Range<usize>) -> f64 {
    let forces = run.clone().map(|interval| held[interval].abs());
    REMAINDER * forces.fold(0.0, f64::max)
}

/// Pairs the ideal collisions that end within the window with `runs`, in order.
pub(super) fn evaluated(
    held: &[f64],
    runs: &[Range<usize>],
    profile: &ForceProfile,
) -> Vec<CollisionEvaluation> {
    ideal_collisions(profile)
        .into_iter()
        .enumerate()
        .map(|(number, ideal)| CollisionEvaluation {
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
    let impulse = impulse(held, intervals.clone(), grid);
    let peak_force = forces.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    RenderedCollision {
        intervals,
        impulse,
        peak_force,
        impulse_error: relative_error(impulse, ideal.impulse),
        peak_force_error: relative_error(peak_force, ideal.peak_force),
    }
}

/// Impulse of the force `held` over `intervals` `[N s]`.
fn impulse(held: &[f64], intervals: Range<usize>, grid: &Grid) -> f64 {
    let period = grid.period();
    let in_periods = intervals.map(|interval| held[interval] * (grid.duration(interval) / period));
    period * in_periods.sum::<f64>()
}

pub(crate) fn relative_error(rendered: f64, ideal: f64) -> Option<f64> {
    let error = (rendered - ideal) / ideal;
    error.is_finite().then_some(error)
}
