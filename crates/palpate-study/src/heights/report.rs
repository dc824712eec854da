//! Results over the start heights, as a table or as JSON.

use std::fmt;

use comfy_table::CellAlignment;
use serde::Serialize;

use super::OverHeights;
use crate::studied::{Compared, Studied};
use crate::sweep::table::text;
use crate::text::{digits, drawn_title, lines, number, percent, plain_table};
use crate::tune::{HEIGHT_RANGE, HEIGHTS, Spread};

/// Name and version of the JSON report.
const FORMAT: &str = "palpate heights 1";

/// Results over the start heights of several scenes.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct HeightsReport {
    /// Name and version of this JSON.
    #[cfg_attr(any(test, feature = "schema"), schemars(extend("const" = FORMAT)))]
    pub format: &'static str,
    /// Number of start heights.
    pub start_heights: usize,
    /// Largest change of the gap, as a share of the scene's.
    pub height_range: f64,
    /// Model device mass of the renderer over the true mass.
    pub model_mass_factor: f64,
    /// One entry for each scene, in the order given.
    pub scenes: Vec<SceneReport>,
    /// Files that were written.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<String>,
}

/// Results of the columns on one scene.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct SceneReport {
    /// The scene's title.
    pub title: String,
    /// Seed of the random values of jitter, drops and sensor noise; none if nothing is random. The results are one
    /// draw.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// Zero-order-hold bound: minimum FRE of any held force `[%]`.
    pub hold_bound_percent: f64,
    /// One entry for each column.
    pub columns: Vec<ColumnReport>,
}

/// Results of a column on one scene.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ColumnReport {
    /// Name of the column.
    pub name: String,
    /// Name of the method.
    pub method: &'static str,
    /// Mean-force error E over the start heights `[%]`.
    pub mean_force_error_percent: Spread,
    /// FRE at the scene's own start height `[%]`.
    pub force_rendering_error_percent: f64,
    /// FRE over the start heights `[%]`.
    pub force_rendering_error_over_heights_percent: Spread,
    /// FRE over the zero-order-hold bound; none if the bound is 0.
    pub error_over_bound: Option<f64>,
    /// Number of start heights from which the loop diverged.
    pub diverged: usize,
    /// The chosen damping, for a column with several dampings.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damping_n_s_per_m: Option<f64>,
}

impl HeightsReport {
    /// Creates the report on `scenes`, whose renderers had `model_mass_factor` times the device's mass as the model
    /// mass.
    #[must_use]
    pub fn new(model_mass_factor: f64, scenes: Vec<SceneReport>) -> Self {
        Self {
            format: FORMAT,
            start_heights: HEIGHTS,
            height_range: HEIGHT_RANGE,
            model_mass_factor,
            scenes,
            files: Vec::new(),
        }
    }
}

/// Columns of the table as CSV.
pub const COLUMNS: [&str; 12] = [
    "title",
    "hold_bound_percent",
    "column",
    "method",
    "own_mean_force_error_percent",
    "median_mean_force_error_percent",
    "worst_mean_force_error_percent",
    "own_force_rendering_error_percent",
    "median_force_rendering_error_percent",
    "worst_force_rendering_error_percent",
    "diverged_heights",
    "damping_n_s_per_m",
];

impl HeightsReport {
    /// Returns a row for each scene and column, in the order of [`COLUMNS`]; missing values are empty.
    pub fn rows(&self) -> impl Iterator<Item = [String; COLUMNS.len()]> + '_ {
        self.scenes.iter().flat_map(|scene| {
            scene.columns.iter().map(|of| {
                let error = &of.mean_force_error_percent;
                let fre = &of.force_rendering_error_over_heights_percent;
                [
                    scene.title.clone(),
                    scene.hold_bound_percent.to_string(),
                    of.name.clone(),
                    of.method.into(),
                    error.own.to_string(),
                    error.median.to_string(),
                    error.worst.to_string(),
                    fre.own.to_string(),
                    fre.median.to_string(),
                    fre.worst.to_string(),
                    of.diverged.to_string(),
                    text(of.damping_n_s_per_m),
                ]
            })
        })
    }
}

impl SceneReport {
    /// Creates the report of the result of [`over_heights`](super::over_heights) for the `scene`.
    #[must_use]
    pub fn new<S: Studied>(scene: &S, columns: &[S::Column], found: &[OverHeights]) -> Self {
        Self {
            title: scene.title().into(),
            seed: scene.random_seed(),
            // The hold bound is a property of the ideal, equal for all columns.
            hold_bound_percent: found.first().map_or(0.0, |one| one.own.hold_bound),
            columns: columns
                .iter()
                .zip(found)
                .map(|(column, found)| ColumnReport {
                    name: column.name().into(),
                    method: column.method(),
                    mean_force_error_percent: found.error,
                    force_rendering_error_percent: found.own.force_rendering_error,
                    force_rendering_error_over_heights_percent: found.force_rendering_error,
                    error_over_bound: found.own.error_over_bound,
                    diverged: found.diverged,
                    damping_n_s_per_m: found.damping,
                })
                .collect(),
        }
    }
}

impl fmt::Display for HeightsReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{} start heights within ±{} %, model mass {} times the device's mass",
            self.start_heights,
            100.0 * self.height_range,
            self.model_mass_factor
        )?;
        for scene in &self.scenes {
            writeln!(
                f,
                "\n{}; hold bound {:.2} %\n",
                drawn_title(&scene.title, scene.seed),
                scene.hold_bound_percent
            )?;
            let header = [
                "method",
                "E % own",
                "median",
                "worst",
                "FRE % own",
                "median",
                "worst",
                "diverged",
                "best B",
            ];
            let chosen = scene
                .columns
                .iter()
                .any(|column| column.damping_n_s_per_m.is_some());
            let header = &header[..header.len() - usize::from(!chosen)];
            let mut table = plain_table(CellAlignment::Left, header);
            for column in &scene.columns {
                let error = &column.mean_force_error_percent;
                let fre = &column.force_rendering_error_over_heights_percent;
                let hundredths = |value: f64| number(Some(value), |value| format!("{value:.2}"));
                let mut cells = vec![
                    (&*column.name).into(),
                    hundredths(error.own),
                    hundredths(error.median),
                    hundredths(error.worst),
                    number(Some(column.force_rendering_error_percent), percent),
                    number(Some(fre.median), percent),
                    number(Some(fre.worst), percent),
                    number(Some(column.diverged as f64), |count| {
                        format!("{count} of {}", self.start_heights)
                    }),
                ];
                if chosen {
                    cells.push(number(column.damping_n_s_per_m, digits));
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
