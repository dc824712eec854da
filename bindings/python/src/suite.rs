//! `suite`: methods on random plants, as a whole or in parts.

use palpate_study::suite::report::SuiteReport;
use palpate_study::suite::{self, Column, MAX_PLANTS, Score, Set};
use pyo3::prelude::*;

use crate::figures::drawn;
use crate::interrupt::interruptible;
use crate::methods::chosen;
use crate::names::refused;
use crate::studies::{Shown, threads};

/// A score: plant, condition, column, and number of redraws of the plant; error of its reference solution, E and FRE
/// `[%]`, FRE over the hold bound, peak over that of the reference; whether the loop diverged; samples, and limited
/// samples.
type Row = (
    (usize, usize, usize, u32),
    (f64, f64, f64, f64, f64),
    (bool, usize, usize),
);

/// Plants to draw and methods to evaluate.
struct Evaluating {
    set: Set,
    seed: u64,
    columns: Vec<Column>,
    /// Whether the methods were given explicitly.
    is_named: bool,
}

impl Evaluating {
    fn new(set: &str, seed: u64, method: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let set = Set::ALL
            .into_iter()
            .find(|known| known.name() == set)
            .ok_or_else(|| {
                let sets = Set::ALL.map(Set::name).join("\" or \"");
                refused(format!("set is \"{set}\", but must be \"{sets}\""))
            })?;
        let columns = match method {
            None => set.columns(),
            Some(method) => chosen(method)?.into_iter().map(Column::new).collect(),
        };
        Ok(Self {
            set,
            seed,
            columns,
            is_named: method.is_some(),
        })
    }

    /// Returns the report on all plants, grouped by seed, and its figure.
    fn report(&self, of_seeds: &[Vec<Score>]) -> PyResult<Shown> {
        let (set, seed, columns) = (self.set, self.seed, &self.columns);
        let report = SuiteReport::of_seeds(set, seed, columns, of_seeds);
        let is_drawn = |number: &usize| {
            self.is_named || palpate_plot::SHOWN.contains(&columns[*number].method)
        };
        let shown: Vec<usize> = (0..columns.len()).filter(is_drawn).collect();
        let figure = palpate_plot::suite(
            set,
            &(seed..seed + of_seeds.len() as u64),
            columns,
            &shown,
            &of_seeds.concat(),
        );
        let figure = drawn(&figure).map_err(refused)?;
        Ok((palpate_study::json(&report), report.to_string(), figure))
    }
}

/// Rejects 0 plants, and more than the program draws.
fn check_plants(plants: usize) -> PyResult<()> {
    if (1..=MAX_PLANTS as usize).contains(&plants) {
        Ok(())
    } else {
        Err(refused(format!(
            "plants is {plants}, but must be 1 to {MAX_PLANTS}"
        )))
    }
}

/// Evaluates methods on random plants.
#[pyfunction]
pub fn run_suite(
    py: Python<'_>,
    set: &str,
    seed: u64,
    plants: usize,
    method: Option<&Bound<'_, PyAny>>,
    seeds: u64,
) -> PyResult<Shown> {
    check_plants(plants)?;
    if !(1..=1000).contains(&seeds) || seed.checked_add(seeds).is_none() {
        return Err(refused(format!(
            "seeds is {seeds}, but must be 1 to 1000, and seed + seeds below 2^64"
        )));
    }
    let judging = Evaluating::new(set, seed, method)?;
    let threads = threads()?;
    let (judging, evaluated) = interruptible(py, move |stop| {
        let look = || stop.leave_if_raised();
        let of_seed = |seed| {
            let evaluated = suite::run(judging.set, seed, plants, &judging.columns, look)?;
            Ok::<_, suite::SuiteError>(suite::scores(&evaluated))
        };
        let scores: Result<Vec<_>, _> =
            threads.install(|| (seed..seed + seeds).map(of_seed).collect());
        (judging, scores)
    })?;
    judging.report(&evaluated.map_err(refused)?)
}

/// Evaluates methods on the plants `first..end` in this thread only and returns one row per score.
#[pyfunction]
pub fn suite_part(
    py: Python<'_>,
    set: &str,
    seed: u64,
    first: usize,
    end: usize,
    method: Option<&Bound<'_, PyAny>>,
) -> PyResult<Vec<Row>> {
    let judging = Evaluating::new(set, seed, method)?;
    let thread = one_thread()?;
    let evaluated = interruptible(py, move |stop| {
        let look = || stop.leave_if_raised();
        thread.install(|| suite::run_part(judging.set, seed, first..end, &judging.columns, look))
    })?;
    let evaluated = evaluated.map_err(refused)?;
    let rows = evaluated
        .iter()
        .flat_map(suite::Evaluated::scores)
        .map(|score| {
            let Score {
                plant,
                redrawn,
                ideal_error,
                condition,
                column,
                error,
                force_error,
                error_over_bound,
                peak_ratio,
                diverged,
                samples,
                limited,
            } = score;
            (
                (plant, condition, column, redrawn),
                (
                    ideal_error,
                    error,
                    force_error,
                    error_over_bound,
                    peak_ratio,
                ),
                (diverged, samples, limited),
            )
        });
    Ok(rows.collect())
}

/// Returns the names of conditions and columns, to which the indices in the rows of a part refer.
#[pyfunction]
pub fn suite_names(
    set: &str,
    plants: usize,
    method: Option<&Bound<'_, PyAny>>,
) -> PyResult<(Vec<String>, Vec<String>)> {
    check_plants(plants)?;
    let judging = Evaluating::new(set, 0, method)?;
    let conditions = judging.set.conditions();
    Ok((
        conditions.iter().map(ToString::to_string).collect(),
        judging
            .columns
            .into_iter()
            .map(|column| column.name)
            .collect(),
    ))
}

/// Returns the report on a whole suite from the rows of all parts, in the order of the plants.
#[pyfunction]
pub fn suite_of_parts(
    set: &str,
    seed: u64,
    method: Option<&Bound<'_, PyAny>>,
    rows: Vec<Row>,
) -> PyResult<Shown> {
    let scores: Vec<Score> = rows
        .into_iter()
        .map(|(places, numbers, counts)| {
            let (plant, condition, column, redrawn) = places;
            let (ideal_error, error, force_error, error_over_bound, peak_ratio) = numbers;
            let (diverged, samples, limited) = counts;
            Score {
                plant,
                redrawn,
                ideal_error,
                condition,
                column,
                error,
                force_error,
                error_over_bound,
                peak_ratio,
                diverged,
                samples,
                limited,
            }
        })
        .collect();
    Evaluating::new(set, seed, method)?.report(&[scores])
}

/// Creates a pool of one thread: a caller of parts uses other processes for the other processors.
fn one_thread() -> PyResult<rayon::ThreadPool> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .map_err(refused)
}
