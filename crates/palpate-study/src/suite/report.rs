//! Results of a suite, as a table or as JSON.

use std::fmt;
use std::path::Path;

use comfy_table::{Cell, CellAlignment, Table};
use serde::Serialize;

use super::paired::{Median, Paired, paired};
use super::summary::summary_of;
use super::{COLLISIONS, Column, Condition, Evaluated, Score, Set, Summary, plants, scores};
use crate::spread::Spread;
use crate::text::{E, FRE, counted, legend, lines, number, percent, plain_table, short, wrapped};

/// Name and version of the JSON report.
const FORMAT: &str = "palpate suite 1";

/// Report on a suite.
#[derive(Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
pub struct SuiteReport {
    /// Name and version of this JSON.
    #[cfg_attr(any(test, feature = "schema"), schemars(extend("const" = FORMAT)))]
    pub format: &'static str,
    /// Name of the set, if it is not the paper's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub set: Option<&'static str>,
    /// Seed of the draws, the first of several.
    pub seed: u64,
    /// Number of consecutive seeds, if there are several: the quantiles are then those of all plants.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seeds: Option<usize>,
    /// Number of plants, of all seeds together.
    pub plants: usize,
    /// Number of rejected draws, in which object and device did not part often enough.
    pub redrawn: u64,
    /// Number of collisions in the evaluation of a plant.
    pub collisions: usize,
    /// Largest error of any ideal's impulse, relative to the plant's largest impulse.
    pub ideal_error: f64,
    /// One entry for each column.
    pub columns: Vec<ColumnReport>,
    /// Files that were written.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<String>,
    #[serde(skip)]
    in_words: Vec<String>,
    /// Whether each condition is an unmodelled delay.
    #[serde(skip)]
    unmodelled: Vec<bool>,
}

/// Results of a column on all plants.
#[derive(Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ColumnReport {
    /// Name of the column.
    pub name: String,
    /// Name of the method.
    pub method: &'static str,
    /// Whether the delay in the renderer's model changed its error on a plant.
    pub models_delay: bool,
    /// One entry for each delay, modelled and not, of the paper's set.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub delays: Vec<ConditionReport>,
    /// One entry for each condition, of every other set.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub conditions: Vec<ConditionReport>,
}

/// Results of a column on all plants under one condition.
#[derive(Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ConditionReport {
    /// Delay of the loop, of the paper's set `[samples]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub delay_samples: Option<usize>,
    /// Delay in the renderer's model, of the paper's set `[samples]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub model_delay_samples: Option<usize>,
    /// The condition in words, of every other set.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub condition: Option<String>,
    /// Mean-force error E `[%]`.
    pub mean_force_error_percent: Quantiles,
    /// Interval of the median of E over the plants `[%]`.
    pub median_interval_percent: Option<Median>,
    /// Comparison with the column with the least median, plant by plant; none for that column.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub more_than_least: Option<Paired>,
    /// FRE `[%]`.
    pub force_rendering_error_percent: Quantiles,
    /// FRE over the bound of the column's hold.
    pub error_over_bound: Quantiles,
    /// Peak force over that of the ideal.
    pub peak_over_ideal_peak: Quantiles,
    /// Number of plants on which the loop diverged.
    pub diverged: usize,
    /// Number of plants on which a limit or a guard changed a force.
    pub limited_plants: usize,
    /// Share of all samples with a changed force.
    pub limited_samples_percent: f64,
    /// Spread of the quantiles of each seed over the seeds, if there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub over_seeds: Option<OverSeeds>,
}

/// Spread of the quantiles of each seed's plants over the seeds.
#[derive(Clone, Copy, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct OverSeeds {
    /// Median of E `[%]`.
    pub median_percent: Spread,
    /// 90 % quantile of E `[%]`.
    pub quantile_90_percent: Spread,
    /// Largest E `[%]`.
    pub largest_percent: Spread,
    /// Median of FRE over the bound of the column's hold.
    pub error_over_bound: Spread,
    /// Number of plants on which the loop diverged.
    pub diverged: Spread,
}

impl OverSeeds {
    fn new(summaries: &[Summary]) -> Option<Self> {
        let spread = |value: &dyn Fn(&Summary) -> f64| Spread::new(summaries.iter().map(value));
        Some(Self {
            median_percent: spread(&|of| of.error[0])?,
            quantile_90_percent: spread(&|of| of.error[2])?,
            largest_percent: spread(&|of| of.error[3])?,
            error_over_bound: spread(&|of| of.error_over_bound[0])?,
            diverged: spread(&|of| of.diverged as f64)?,
        })
    }
}

/// Quantiles over the plants. An infinite one is `null` in JSON.
#[derive(Serialize, Default)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Quantiles {
    /// Median.
    pub median: f64,
    /// 75 % quantile.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub quantile_75: Option<f64>,
    /// 90 % quantile.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub quantile_90: Option<f64>,
    /// Largest value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub largest: Option<f64>,
}

impl Quantiles {
    fn of_two([median, nine_tenths]: [f64; 2]) -> Self {
        Self {
            median,
            quantile_90: Some(nine_tenths),
            ..Self::default()
        }
    }
}

impl ConditionReport {
    fn new(
        condition: Condition,
        summary: &Summary,
        of_seeds: &[Summary],
        (interval, more_than_least): (Option<Median>, Option<Paired>),
    ) -> Self {
        let [median, three_quarters, nine_tenths, largest] = summary.error;
        Self {
            delay_samples: condition.delay(),
            model_delay_samples: condition.model_delay(),
            over_seeds: (of_seeds.len() > 1)
                .then(|| OverSeeds::new(of_seeds))
                .flatten(),
            condition: condition.delay().is_none().then(|| condition.to_string()),
            mean_force_error_percent: Quantiles {
                median,
                quantile_75: Some(three_quarters),
                quantile_90: Some(nine_tenths),
                largest: Some(largest),
            },
            median_interval_percent: interval,
            more_than_least,
            force_rendering_error_percent: Quantiles::of_two(summary.force_error),
            error_over_bound: Quantiles::of_two(summary.error_over_bound),
            peak_over_ideal_peak: Quantiles {
                median: summary.peak_ratio[0],
                largest: Some(summary.peak_ratio[1]),
                ..Quantiles::default()
            },
            diverged: summary.diverged,
            limited_plants: summary.held_back,
            limited_samples_percent: 100.0 * summary.limited,
        }
    }
}

impl ColumnReport {
    /// Returns the results under the condition of this index.
    fn found(&self, place: usize) -> &ConditionReport {
        self.delays
            .get(place)
            .unwrap_or_else(|| &self.conditions[place])
    }
}

impl SuiteReport {
    /// Creates the report of the result of [`run`](super::run) for `set`, `seed` and `columns`.
    #[must_use]
    pub fn new(set: Set, seed: u64, columns: &[Column], evaluated: &[Evaluated]) -> Self {
        Self::of_scores(set, seed, columns, &scores(evaluated))
    }

    /// Creates the report of the scores of consecutive seeds starting at `first`, grouped by seed.
    #[must_use]
    pub fn of_seeds(set: Set, first: u64, columns: &[Column], of_seeds: &[Vec<Score>]) -> Self {
        let [scores] = of_seeds else {
            let redrawn = |scores: &Vec<Score>| of_plants(scores).map(redrawn).sum::<u64>();
            return Self {
                seeds: Some(of_seeds.len()),
                plants: of_seeds.iter().map(|scores| plants(scores)).sum(),
                redrawn: of_seeds.iter().map(redrawn).sum(),
                ..Self::made(set, first, columns, &of_seeds.concat(), of_seeds)
            };
        };
        Self::of_scores(set, first, columns, scores)
    }

    /// Creates the report of the scores of all plants, grouped by plant.
    #[must_use]
    pub fn of_scores(set: Set, seed: u64, columns: &[Column], scores: &[Score]) -> Self {
        Self::made(set, seed, columns, scores, &[])
    }

    fn made(
        set: Set,
        seed: u64,
        columns: &[Column],
        scores: &[Score],
        of_seeds: &[Vec<Score>],
    ) -> Self {
        let conditions = set.conditions();
        let pairs: Vec<Vec<Option<Paired>>> = (0..conditions.len())
            .map(|place| paired(scores, columns.len(), place))
            .collect();
        let reports = |index: usize, of_delays: bool| -> Vec<ConditionReport> {
            let places = conditions.iter().enumerate();
            places
                .filter(|(_, condition)| condition.delay().is_some() == of_delays)
                .filter_map(|(place, condition)| {
                    let summary = summary_of(scores, index, place)?;
                    let of_seeds: Vec<Summary> = of_seeds
                        .iter()
                        .filter_map(|scores| summary_of(scores, index, place))
                        .collect();
                    let of = |score: &&Score| score.column == index && score.condition == place;
                    let errors = scores.iter().filter(of).map(|score| score.error);
                    let certainty = (Median::new(errors.collect()), pairs[place][index]);
                    Some(ConditionReport::new(
                        *condition, &summary, &of_seeds, certainty,
                    ))
                })
                .collect()
        };
        let ideal_errors = of_plants(scores).map(|one| one.ideal_error);
        Self {
            format: FORMAT,
            set: (set != Set::Paper).then(|| set.name()),
            seed,
            seeds: None,
            plants: plants(scores),
            redrawn: of_plants(scores).map(redrawn).sum(),
            collisions: COLLISIONS,
            ideal_error: ideal_errors.fold(0.0, f64::max),
            columns: columns
                .iter()
                .enumerate()
                .map(|(index, column)| ColumnReport {
                    name: column.name.clone(),
                    method: column.method.name(),
                    models_delay: models_delay(&conditions, scores, index),
                    delays: reports(index, true),
                    conditions: reports(index, false),
                })
                .collect(),
            files: Vec::new(),
            in_words: conditions.iter().map(ToString::to_string).collect(),
            unmodelled: conditions
                .iter()
                .map(|condition| matches!(condition, Condition::UnmodelledDelay(_)))
                .collect(),
        }
    }

    /// Adds a written file.
    pub fn wrote(&mut self, path: &Path) {
        self.files.push(path.display().to_string());
    }
}

/// Returns the first score of each plant.
fn of_plants(scores: &[Score]) -> impl Iterator<Item = &Score> {
    scores.chunk_by(|a, b| a.plant == b.plant).map(|of| &of[0])
}

/// Whether the errors of a column with an unmodelled delay differ from those of the previous condition.
fn models_delay(conditions: &[Condition], scores: &[Score], column: usize) -> bool {
    let errors = |condition: usize| {
        let of = move |score: &&Score| score.column == column && score.condition == condition;
        scores.iter().filter(of).map(|score| score.error.to_bits())
    };
    (1..conditions.len())
        .filter(|&place| matches!(conditions[place], Condition::UnmodelledDelay(_)))
        .any(|place| !errors(place - 1).eq(errors(place)))
}

fn redrawn(score: &Score) -> u64 {
    u64::from(score.redrawn)
}

/// Explanation of the last columns.
const CERTAINTY: &str = "95 %: interval of the median over all plants. Over least median: E minus that of the method \
    with the least median, plant by plant (95 % of its median); worse: plants with a larger E than that method has.";

impl fmt::Display for SuiteReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let seeds = self.seeds.map_or_else(
            || format!("seed {}", self.seed),
            |seeds| format!("seeds {} to {}", self.seed, self.seed + seeds as u64 - 1),
        );
        let drawn = format!(
            "{}{}, {seeds}, {} each; {} were redrawn for lack of collisions",
            counted(self.plants, "random plant"),
            self.set
                .map_or_else(String::new, |set| format!(" of the set {set}")),
            counted(self.collisions, "collision"),
            self.redrawn
        );
        writeln!(f, "{}", wrapped(&drawn))?;
        if self.seeds.is_some() {
            let each = "A value: median over the seeds (least-largest of a seed).";
            writeln!(f, "{each}")?;
        }
        for (place, condition) in self.in_words.iter().enumerate() {
            writeln!(f, "\n{condition}\n")?;
            let unmodelled = self.unmodelled[place];
            let columns: Vec<_> = self
                .columns
                .iter()
                .filter(|column| !unmodelled || column.models_delay)
                .map(|column| (&*column.name, column.found(place)))
                .collect();
            if !columns.is_empty() {
                let table = if self.seeds.is_some() {
                    spread_table(&columns)
                } else {
                    quantile_table(&columns)
                };
                writeln!(f, "{}", lines(&table))?;
            }
            if columns.len() < self.columns.len() {
                let same = "The other methods do not use the model of the delay: as above.";
                writeln!(f, "{}{same}", if columns.is_empty() { "" } else { "\n" })?;
            }
        }
        writeln!(f, "\n{}\n", legend(&[E, FRE, CERTAINTY]))?;
        if self.seeds.is_none() {
            writeln!(
                f,
                "{}\n",
                wrapped(
                    "These are the plants of one seed; --seeds 7 shows how the results vary from seed to seed."
                )
            )?;
        }
        for file in &self.files {
            writeln!(f, "wrote {file}")?;
        }
        Ok(())
    }
}

/// Returns the quantiles of each column, of one seed.
fn quantile_table(columns: &[(&str, &ConditionReport)]) -> Table {
    let header = [
        "method",
        "E % median",
        "75 %",
        "90 %",
        "max",
        "FRE/bound median",
        "90 %",
        "peak/ideal",
        "max",
        "diverged",
        "median, 95 %",
        "over least median",
        "worse",
        "limited plants",
        "samples %",
    ];
    let limited = columns.iter().any(|(_, found)| found.limited_plants > 0);
    let header = &header[..header.len() - if limited { 0 } else { 2 }];
    let mut table = plain_table(CellAlignment::Left, header);
    let ratio = |value: Option<f64>| number(value, |ratio| short(ratio, 2));
    for (name, found) in columns {
        let error = &found.mean_force_error_percent;
        let mut cells = vec![
            (*name).into(),
            number(Some(error.median), percent),
            number(error.quantile_75, percent),
            number(error.quantile_90, percent),
            number(error.largest, percent),
            ratio(Some(found.error_over_bound.median)),
            ratio(found.error_over_bound.quantile_90),
            ratio(Some(found.peak_over_ideal_peak.median)),
            ratio(found.peak_over_ideal_peak.largest),
            number(Some(found.diverged as f64), |count| count.to_string()),
        ];
        cells.extend(certainty(found));
        if limited {
            let count = |count: f64| count.to_string();
            cells.push(number(Some(found.limited_plants as f64), count));
            cells.push(number(Some(found.limited_samples_percent), percent));
        }
        table.add_row(cells);
    }
    table
}

/// Returns the interval of a median over the plants, and the comparison with the least median plant by plant.
fn certainty(found: &ConditionReport) -> [Cell; 3] {
    let interval = |of: Median| match of.low.zip(of.high) {
        Some((low, high)) => format!("{}-{}", percent(low), percent(high)),
        None => "-".to_owned(),
    };
    let (over, worse) = found.more_than_least.map_or_else(
        || ("-".to_owned(), "-".to_owned()),
        |paired| {
            let difference = paired.difference_percent;
            let median = percent(difference.median);
            (
                format!("{median} ({})", interval(difference)),
                paired.worse_plants.to_string(),
            )
        },
    );
    let own = found.median_interval_percent.map_or("-".into(), interval);
    [own, over, worse].map(|cell| Cell::new(cell).set_alignment(CellAlignment::Right))
}

/// Returns the spread of each column's quantiles over the seeds.
fn spread_table(columns: &[(&str, &ConditionReport)]) -> Table {
    let header = [
        "method",
        "E % median",
        "90 %",
        "max",
        "FRE/bound median",
        "diverged",
        "median, 95 %",
        "over least median",
        "worse",
    ];
    let mut table = plain_table(CellAlignment::Left, &header);
    for (name, found) in columns {
        let mut cells = vec![Cell::new(name)];
        if let Some(over) = &found.over_seeds {
            let spreads = [
                (over.median_percent, 1),
                (over.quantile_90_percent, 1),
                (over.largest_percent, 1),
                (over.error_over_bound, 2),
                (over.diverged, 0),
            ];
            cells.extend(spreads.map(|(spread, decimals)| {
                Cell::new(spread.in_short(decimals)).set_alignment(CellAlignment::Right)
            }));
        }
        cells.extend(certainty(found));
        table.add_row(cells);
    }
    table
}
