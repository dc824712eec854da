//! What the suite found, as a table or as JSON.

use std::fmt;
use std::path::Path;

use comfy_table::CellAlignment;
use serde::Serialize;

use super::spread::summary_of;
use super::{COLLISIONS, Column, Condition, Judged, Score, Set, Summary, plants, scores};
use crate::text::{E, FRE, counted, legend, lines, number, percent, plain_table, short, wrapped};

/// Name and version of the JSON report.
const FORMAT: &str = "palpate suite 1";

/// The summaries of a suite.
#[derive(Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
pub struct SuiteReport {
    /// Name and version of this JSON.
    #[cfg_attr(any(test, feature = "schema"), schemars(extend("const" = FORMAT)))]
    pub format: &'static str,
    /// Name of the set, where it is not the paper's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub set: Option<&'static str>,
    /// Seed of the draws.
    pub seed: u64,
    /// Number of plants.
    pub plants: usize,
    /// Draws that were thrown away because object and device did not part often enough.
    pub redrawn: u64,
    /// Collisions over which a plant is judged.
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
}

/// What a column did on all plants.
#[derive(Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ColumnReport {
    /// Name of the column.
    pub name: String,
    /// Name of the method.
    pub method: &'static str,
    /// One entry for each delay, of the paper's set.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub delays: Vec<ConditionReport>,
    /// One entry for each condition, of every other set.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub conditions: Vec<ConditionReport>,
}

/// What a column did on all plants under one condition.
#[derive(Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ConditionReport {
    /// Delay of the loop, of the paper's set `[samples]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub delay_samples: Option<usize>,
    /// The condition in words, of every other set.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub condition: Option<String>,
    /// Mean-force error E `[%]`.
    pub mean_force_error_percent: Quantiles,
    /// FRE over the hold floor.
    pub error_over_floor: Quantiles,
    /// Peak force over that of the ideal.
    pub peak_over_ideal_peak: Quantiles,
    /// Plants on which the loop ran away.
    pub diverged: usize,
    /// Plants on which a limit or a guard changed a force.
    pub limited_plants: usize,
    /// Share of all samples at which one did.
    pub limited_samples_percent: f64,
}

/// An infinite one is `null` in JSON.
#[derive(Serialize, Default)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Quantiles {
    /// What half are below.
    pub median: f64,
    /// What three quarters are below.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub quantile_75: Option<f64>,
    /// What nine tenths are below.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub quantile_90: Option<f64>,
    /// The largest.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub largest: Option<f64>,
}

impl ConditionReport {
    fn new(condition: Condition, summary: &Summary) -> Self {
        let [median, three_quarters, nine_tenths, largest] = summary.error;
        Self {
            delay_samples: condition.delay(),
            condition: condition.delay().is_none().then(|| condition.to_string()),
            mean_force_error_percent: Quantiles {
                median,
                quantile_75: Some(three_quarters),
                quantile_90: Some(nine_tenths),
                largest: Some(largest),
            },
            error_over_floor: Quantiles {
                median: summary.error_over_floor[0],
                quantile_90: Some(summary.error_over_floor[1]),
                ..Quantiles::default()
            },
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
    /// What was found under the condition of this place.
    fn found(&self, place: usize) -> &ConditionReport {
        self.delays
            .get(place)
            .unwrap_or_else(|| &self.conditions[place])
    }
}

impl SuiteReport {
    /// The report on what [`run`](super::run) gave for `set`, `seed` and `columns`.
    #[must_use]
    pub fn new(set: Set, seed: u64, columns: &[Column], judged: &[Judged]) -> Self {
        Self::of_scores(set, seed, columns, &scores(judged))
    }

    /// The same from the scores of all plants, those of each plant together.
    #[must_use]
    pub fn of_scores(set: Set, seed: u64, columns: &[Column], scores: &[Score]) -> Self {
        let conditions = set.conditions();
        let reports = |index: usize, of_delays: bool| -> Vec<ConditionReport> {
            let places = conditions.iter().enumerate();
            places
                .filter(|(_, condition)| condition.delay().is_some() == of_delays)
                .filter_map(|(place, condition)| {
                    let summary = summary_of(scores, index, place)?;
                    Some(ConditionReport::new(*condition, &summary))
                })
                .collect()
        };
        let of_plants = || scores.chunk_by(|a, b| a.plant == b.plant).map(|of| &of[0]);
        let ideal_errors = of_plants().map(|one| one.ideal_error);
        Self {
            format: FORMAT,
            set: (set != Set::Paper).then(|| set.name()),
            seed,
            plants: plants(scores),
            redrawn: of_plants().map(|one| u64::from(one.redrawn)).sum(),
            collisions: COLLISIONS,
            ideal_error: ideal_errors.fold(0.0, f64::max),
            columns: columns
                .iter()
                .enumerate()
                .map(|(index, column)| ColumnReport {
                    name: column.name.clone(),
                    method: column.method.name(),
                    delays: reports(index, true),
                    conditions: reports(index, false),
                })
                .collect(),
            files: Vec::new(),
            in_words: conditions.iter().map(ToString::to_string).collect(),
        }
    }

    /// Remembers a file that was written.
    pub fn wrote(&mut self, path: &Path) {
        self.files.push(path.display().to_string());
    }
}

impl fmt::Display for SuiteReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let drawn = format!(
            "{}{}, seed {}, {} each; {} were drawn again for want of collisions",
            counted(self.plants, "random plant"),
            self.set
                .map_or_else(String::new, |set| format!(" of the set {set}")),
            self.seed,
            counted(self.collisions, "collision"),
            self.redrawn
        );
        writeln!(f, "{}", wrapped(&drawn))?;
        for (place, condition) in self.in_words.iter().enumerate() {
            writeln!(f, "\n{condition}\n")?;
            let header = [
                "method",
                "E % median",
                "75 %",
                "90 %",
                "max",
                "FRE/floor median",
                "90 %",
                "peak/ideal median",
                "max",
                "diverged",
                "limited plants",
                "samples %",
            ];
            let limited = self
                .columns
                .iter()
                .any(|column| column.found(place).limited_plants > 0);
            let header = &header[..header.len() - if limited { 0 } else { 2 }];
            let mut table = plain_table(CellAlignment::Left, header);
            let ratio = |value: Option<f64>| number(value, |ratio| short(ratio, 2));
            for column in &self.columns {
                let found = column.found(place);
                let error = &found.mean_force_error_percent;
                let mut cells = vec![
                    (&*column.name).into(),
                    number(Some(error.median), percent),
                    number(error.quantile_75, percent),
                    number(error.quantile_90, percent),
                    number(error.largest, percent),
                    ratio(Some(found.error_over_floor.median)),
                    ratio(found.error_over_floor.quantile_90),
                    ratio(Some(found.peak_over_ideal_peak.median)),
                    ratio(found.peak_over_ideal_peak.largest),
                    number(Some(found.diverged as f64), |count| count.to_string()),
                ];
                if limited {
                    let count = |count: f64| count.to_string();
                    cells.push(number(Some(found.limited_plants as f64), count));
                    cells.push(number(Some(found.limited_samples_percent), percent));
                }
                table.add_row(cells);
            }
            writeln!(f, "{}", lines(&table))?;
        }
        writeln!(f, "\n{}\n", legend(&[E, FRE]))?;
        for file in &self.files {
            writeln!(f, "wrote {file}")?;
        }
        Ok(())
    }
}
