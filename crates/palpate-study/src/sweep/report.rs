//! Results of a sweep, as a table or as JSON.

use std::fmt;

use comfy_table::{CellAlignment, Table};
use palpate_scene::Scene;
use serde::Serialize;

use super::{Quantity, Swept, SweptWorld};
use crate::suite::Column;
use crate::text::{
    ABSOLUTE_LEAK, E, FRE, digits, drawn_title, legend, lines, number, percent, plain_table, short,
    wrapped,
};
use crate::tune::HEIGHTS;

/// Explanation of the column `rebound`.
const REBOUND: &str = "rebound: largest energy of a rebound over that of the ideal's first.";

/// Name and version of the JSON report.
const FORMAT: &str = "palpate sweep 1";

/// Results of every column at every value of a quantity.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct SweepReport {
    /// Name and version of this JSON.
    #[cfg_attr(any(test, feature = "schema"), schemars(extend("const" = FORMAT)))]
    pub format: &'static str,
    /// The scene's title.
    pub title: String,
    /// Seed of the random values of jitter, drops and sensor noise; none if nothing is random. The results are one
    /// draw.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// Varied quantity: `friction`, `box` or `damping`, or the key of the scene.
    pub over: String,
    /// Unit of the values; empty for a factor, and for a key, which has its unit in its name.
    pub unit: &'static str,
    /// One entry for each value.
    pub values: Vec<ValueReport>,
    /// Files that were written.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<String>,
}

/// Results of the columns at one value.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ValueReport {
    /// The value.
    pub value: f64,
    /// Zero-order-hold bound: minimum FRE of any held force `[%]`.
    pub hold_bound_percent: f64,
    /// Strongest force of the ideal `[N]`.
    pub ideal_peak_force_n: f64,
    /// One entry for each column.
    pub columns: Vec<ColumnReport>,
}

/// Results of a column at one value.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ColumnReport {
    /// Name of the column.
    pub name: String,
    /// Name of the method.
    pub method: &'static str,
    /// FRE at the scene's own start height `[%]`.
    pub force_rendering_error_percent: f64,
    /// Mean-force error E at the scene's own start height `[%]`.
    pub mean_force_error_percent: f64,
    /// Median FRE over the start heights `[%]`, if requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub median_force_rendering_error_percent: Option<f64>,
    /// Largest FRE over the start heights `[%]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub worst_force_rendering_error_percent: Option<f64>,
    /// Number of start heights from which the device left its safety box.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub left_box_heights: Option<usize>,
    /// Number of start heights from which the bounce was stable or almost stable.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub almost_stable_heights: Option<usize>,
    /// Strongest held force `[N]`.
    pub peak_force_n: f64,
    /// Sum of the absolute leaks of the held force `[J]`; one contact only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub absolute_leak_held_j: Option<f64>,
    /// Generated energy of the held forces `[J]`; worlds only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub leak_j: Option<f64>,
    /// Number of samples that the renderer rejected; worlds only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refused_samples: Option<usize>,
    /// Largest rebound energy relative to the ideal's first rebound; none without a rebound.
    pub largest_rebound_energy: Option<f64>,
    /// `stable`, `almost stable`, `unstable` or `diverged`; one contact only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bounce: Option<&'static str>,
    /// Time at which the device left its safety box `[s]`.
    pub left_box_at_s: Option<f64>,
}

impl SweepReport {
    /// Creates the report of the result of [`sweep`](super::sweep) for the `scene` at `values`.
    #[must_use]
    pub fn new(
        scene: &Scene,
        quantity: Quantity,
        values: &[f64],
        columns: &[Column],
        swept: &[Vec<Swept>],
    ) -> Self {
        let swept = values.iter().copied().zip(swept);
        Self {
            unit: quantity.unit(),
            ..Self::of_key(scene, quantity.name(), swept, columns)
        }
    }

    /// Creates the report of the results at each value of a key of the `scene`.
    #[must_use]
    pub fn of_key<'s>(
        scene: &Scene,
        key: &str,
        swept: impl Iterator<Item = (f64, &'s Vec<Swept>)>,
        columns: &[Column],
    ) -> Self {
        Self {
            format: FORMAT,
            title: scene.title.clone(),
            seed: scene.random_seed(),
            over: key.into(),
            unit: "",
            values: swept
                .map(|(value, swept)| ValueReport::new(value, columns, swept))
                .collect(),
            files: Vec::new(),
        }
    }

    /// Creates the report of the results of `methods` at each value of a key of a world with this title.
    #[must_use]
    pub fn of_worlds<'s>(
        title: &str,
        key: &str,
        swept: impl Iterator<Item = (f64, &'s Vec<SweptWorld>)>,
        methods: &[&'static str],
    ) -> Self {
        Self {
            format: FORMAT,
            title: title.into(),
            seed: None,
            over: key.into(),
            unit: "",
            values: swept
                .map(|(value, swept)| ValueReport::of_world(value, methods, swept))
                .collect(),
            files: Vec::new(),
        }
    }

    /// Adds a written file.
    pub fn wrote(&mut self, path: &std::path::Path) {
        self.files.push(path.display().to_string());
    }
}

impl ValueReport {
    fn new(value: f64, columns: &[Column], swept: &[Swept]) -> Self {
        // Hold bound and peak are properties of the ideal, equal for all columns.
        let ideal = swept.first();
        Self {
            value,
            hold_bound_percent: ideal.map_or(0.0, |swept| swept.own.hold_bound),
            ideal_peak_force_n: ideal.map_or(0.0, |swept| swept.ideal_peak_force),
            columns: columns
                .iter()
                .zip(swept)
                .map(|(column, swept)| ColumnReport {
                    name: column.name.clone(),
                    method: column.method.name(),
                    force_rendering_error_percent: swept.own.force_rendering_error,
                    mean_force_error_percent: swept.own.mean_force_error,
                    median_force_rendering_error_percent: swept
                        .over_heights
                        .map(|of| of.force_rendering_error.median),
                    worst_force_rendering_error_percent: swept
                        .over_heights
                        .map(|of| of.force_rendering_error.worst),
                    left_box_heights: swept.over_heights.map(|of| of.left_box),
                    almost_stable_heights: swept.over_heights.map(|of| of.almost_stable),
                    peak_force_n: swept.peak_force,
                    absolute_leak_held_j: Some(swept.leak),
                    leak_j: None,
                    refused_samples: None,
                    largest_rebound_energy: swept.rebound_energy,
                    bounce: Some(swept.stability.name()),
                    left_box_at_s: swept.left_box_at,
                })
                .collect(),
        }
    }

    fn of_world(value: f64, methods: &[&'static str], swept: &[SweptWorld]) -> Self {
        let ideal = swept.first();
        Self {
            value,
            hold_bound_percent: ideal.map_or(0.0, |swept| swept.own.hold_bound),
            ideal_peak_force_n: ideal.map_or(0.0, |swept| swept.ideal_peak_force),
            columns: methods
                .iter()
                .zip(swept)
                .map(|(method, swept)| ColumnReport {
                    name: (*method).into(),
                    method,
                    force_rendering_error_percent: swept.own.force_rendering_error,
                    mean_force_error_percent: swept.own.mean_force_error,
                    median_force_rendering_error_percent: None,
                    worst_force_rendering_error_percent: None,
                    left_box_heights: None,
                    almost_stable_heights: None,
                    peak_force_n: swept.peak_force,
                    absolute_leak_held_j: None,
                    leak_j: Some(swept.created),
                    refused_samples: Some(swept.refused),
                    largest_rebound_energy: None,
                    bounce: None,
                    left_box_at_s: None,
                })
                .collect(),
        }
    }
}

impl fmt::Display for SweepReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let unit = match self.unit {
            "" => String::new(),
            unit => format!(" {unit}"),
        };
        writeln!(f, "{}", wrapped(&drawn_title(&self.title, self.seed)))?;
        for at in &self.values {
            writeln!(
                f,
                "\n{} {}{unit}: hold bound {:.2} %, peak of the ideal {:.2} N\n",
                self.over, at.value, at.hold_bound_percent, at.ideal_peak_force_n
            )?;
            let is_world = at.columns.iter().any(|of| of.refused_samples.is_some());
            let table = if is_world {
                at.table_of_world()
            } else {
                at.table_of_contact()
            };
            writeln!(f, "{}", lines(&table))?;
        }
        let is_world = |of: &ColumnReport| of.refused_samples.is_some();
        let words: &[&str] = if self.values.iter().flat_map(|at| &at.columns).any(is_world) {
            &[E, FRE]
        } else {
            &[FRE, ABSOLUTE_LEAK, REBOUND]
        };
        writeln!(f, "\n{}", legend(words))?;
        for file in &self.files {
            writeln!(f, "wrote {file}")?;
        }
        Ok(())
    }
}

impl ValueReport {
    fn table_of_world(&self) -> Table {
        let header = ["method", "E %", "FRE %", "peak N", "leak mJ", "refused"];
        let mut table = plain_table(CellAlignment::Left, &header);
        for column in &self.columns {
            table.add_row([
                (&*column.name).into(),
                number(Some(column.mean_force_error_percent), percent),
                number(Some(column.force_rendering_error_percent), percent),
                number(Some(column.peak_force_n), |force| format!("{force:.2}")),
                number(column.leak_j.map(|leak| 1e3 * leak), |leak| short(leak, 3)),
                number(column.refused_samples.map(|count| count as f64), digits),
            ]);
        }
        table
    }

    fn table_of_contact(&self) -> Table {
        let heights = self.columns.iter().any(|of| of.left_box_heights.is_some());
        let mut header = vec!["method", "FRE %"];
        if heights {
            header.extend(["median", "worst"]);
        }
        header.extend(["peak N", "|leak| mJ", "rebound", "bounce", "left box s"]);
        if heights {
            // These columns count start heights.
            header.extend(["almost stable", "left box"]);
        }
        let of_heights = |count: Option<usize>| {
            number(count.map(|count| count as f64), |count| {
                format!("{count} of {HEIGHTS}")
            })
        };
        let mut table = plain_table(CellAlignment::Left, &header);
        for column in &self.columns {
            let mut cells = vec![
                (&*column.name).into(),
                number(Some(column.force_rendering_error_percent), percent),
            ];
            if heights {
                cells.push(number(column.median_force_rendering_error_percent, percent));
                cells.push(number(column.worst_force_rendering_error_percent, percent));
            }
            let leak = column.absolute_leak_held_j.map(|leak| 1e3 * leak);
            cells.extend([
                number(Some(column.peak_force_n), |force| format!("{force:.2}")),
                number(leak, digits),
                number(column.largest_rebound_energy, |ratio| format!("{ratio:.2}")),
                comfy_table::Cell::new(column.bounce.unwrap_or("-"))
                    .set_alignment(CellAlignment::Right),
                number(column.left_box_at_s, |time| format!("{time:.2}")),
            ]);
            if heights {
                cells.push(of_heights(column.almost_stable_heights));
                cells.push(of_heights(column.left_box_heights));
            }
            table.add_row(cells);
        }
        table
    }
}
