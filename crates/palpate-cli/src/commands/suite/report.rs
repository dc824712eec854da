//! What the suite found, as a table or as JSON.

use std::fmt;
use std::path::Path;

use comfy_table::CellAlignment;
use palpate_study::suite::{COLLISIONS, Column, DELAYS, Judged, Summary, summary};
use serde::Serialize;

use super::delay_in_words;
use crate::report::{counted, lines, number, percent, plain_table, short};

/// Name and version of the JSON report.
const FORMAT: &str = "palpate suite 1";

/// The summaries of a suite.
#[derive(Serialize)]
pub(super) struct Report {
    format: &'static str,
    seed: u64,
    plants: usize,
    /// Draws that were thrown away because object and device did not part often enough.
    redrawn: u64,
    collisions: usize,
    /// Largest error of any ideal's impulse, relative to the plant's largest impulse.
    ideal_error: f64,
    columns: Vec<ColumnReport>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    files: Vec<String>,
}

#[derive(Serialize)]
struct ColumnReport {
    name: String,
    method: &'static str,
    delays: Vec<DelayReport>,
}

#[derive(Serialize)]
struct DelayReport {
    delay_samples: usize,
    mean_force_error_percent: Quantiles,
    error_over_floor: Quantiles,
    peak_over_ideal_peak: Quantiles,
    diverged: usize,
    /// Plants on which a limit or a guard changed a force.
    limited_plants: usize,
    /// Share of all samples at which one did.
    limited_samples_percent: f64,
}

/// An infinite one is `null` in JSON.
#[derive(Serialize, Default)]
struct Quantiles {
    median: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    quantile_75: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    quantile_90: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    largest: Option<f64>,
}

impl From<Summary> for DelayReport {
    fn from(summary: Summary) -> Self {
        let [median, three_quarters, nine_tenths, largest] = summary.error;
        Self {
            delay_samples: summary.delay,
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

impl Report {
    pub fn new(seed: u64, columns: &[Column], judged: &[Judged]) -> Self {
        let ideal_errors = judged.iter().map(|one| one.ideal_error);
        Self {
            format: FORMAT,
            seed,
            plants: judged.len(),
            redrawn: judged.iter().map(|one| u64::from(one.plant.redrawn)).sum(),
            collisions: COLLISIONS,
            ideal_error: ideal_errors.fold(0.0, f64::max),
            columns: columns
                .iter()
                .enumerate()
                .map(|(index, column)| ColumnReport {
                    name: column.name.clone(),
                    method: column.method.name(),
                    delays: DELAYS
                        .into_iter()
                        .filter_map(|delay| summary(judged, index, delay))
                        .map(DelayReport::from)
                        .collect(),
                })
                .collect(),
            files: Vec::new(),
        }
    }

    /// Remembers a file that was written.
    pub fn wrote(&mut self, path: &Path) {
        self.files.push(path.display().to_string());
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{}, seed {}, {} each; {} were drawn again for want of collisions",
            counted(self.plants, "random plant"),
            self.seed,
            counted(self.collisions, "collision"),
            self.redrawn
        )?;
        for (place, delay) in DELAYS.into_iter().enumerate() {
            writeln!(f, "\n{}\n", delay_in_words(delay))?;
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
                .any(|column| column.delays[place].limited_plants > 0);
            let header = &header[..header.len() - if limited { 0 } else { 2 }];
            let mut table = plain_table(CellAlignment::Left, header);
            let ratio = |value: Option<f64>| number(value, |ratio| short(ratio, 2));
            for column in &self.columns {
                let found = &column.delays[place];
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
        writeln!(f)?;
        for file in &self.files {
            writeln!(f, "wrote {file}")?;
        }
        Ok(())
    }
}
