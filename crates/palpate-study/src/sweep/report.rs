//! Results of a sweep, as a table or as JSON.

use std::fmt;

use comfy_table::CellAlignment;
use palpate_scene::Scene;
use serde::Serialize;

use super::{Quantity, Swept};
use crate::suite::Column;
use crate::text::{
    ABSOLUTE_LEAK, FRE, digits, drawn_title, legend, lines, number, percent, plain_table, wrapped,
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
    /// Varied quantity: `friction`, `box` or `damping`.
    pub over: &'static str,
    /// Unit of the values; empty for a factor.
    pub unit: &'static str,
    /// One entry for each value.
    pub values: Vec<ValueReport>,
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
    /// Sum of the absolute leaks of the held force `[J]`.
    pub absolute_leak_held_j: f64,
    /// Largest rebound energy relative to the ideal's first rebound; none without a rebound.
    pub largest_rebound_energy: Option<f64>,
    /// `stable`, `almost stable`, `unstable` or `diverged`.
    pub bounce: &'static str,
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
        Self {
            format: FORMAT,
            title: scene.title.clone(),
            seed: scene.random_seed(),
            over: quantity.name(),
            unit: quantity.unit(),
            values: values
                .iter()
                .zip(swept)
                .map(|(value, swept)| ValueReport::new(*value, columns, swept))
                .collect(),
        }
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
                    absolute_leak_held_j: swept.leak,
                    largest_rebound_energy: swept.rebound_energy,
                    bounce: swept.stability.name(),
                    left_box_at_s: swept.left_box_at,
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
            let heights = at.columns.iter().any(|of| of.left_box_heights.is_some());
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
            for column in &at.columns {
                let mut cells = vec![
                    (&*column.name).into(),
                    number(Some(column.force_rendering_error_percent), percent),
                ];
                if heights {
                    cells.push(number(column.median_force_rendering_error_percent, percent));
                    cells.push(number(column.worst_force_rendering_error_percent, percent));
                }
                cells.extend([
                    number(Some(column.peak_force_n), |force| format!("{force:.2}")),
                    number(Some(1e3 * column.absolute_leak_held_j), digits),
                    number(column.largest_rebound_energy, |ratio| format!("{ratio:.2}")),
                    comfy_table::Cell::new(column.bounce).set_alignment(CellAlignment::Right),
                    number(column.left_box_at_s, |time| format!("{time:.2}")),
                ]);
                if heights {
                    cells.push(of_heights(column.almost_stable_heights));
                    cells.push(of_heights(column.left_box_heights));
                }
                table.add_row(cells);
            }
            writeln!(f, "{}", lines(&table))?;
        }
        writeln!(f, "\n{}", legend(&[FRE, ABSOLUTE_LEAK, REBOUND]))
    }
}
