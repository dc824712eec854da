//! Results of a sweep, as a table or as JSON.

use std::fmt;

use comfy_table::{Cell, CellAlignment, Table};
use serde::Serialize;

use super::{Quantity, Swept};
use crate::studied::{Compared, Leak, Studied};
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
    /// Second varied quantity or key, if there are two.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub and: Option<String>,
    /// One entry for each value; for each pair of values, if there are two quantities.
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
    /// Value of the second quantity.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub and_value: Option<f64>,
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
    pub fn new<S: Studied>(
        scene: &S,
        quantity: Quantity,
        values: &[f64],
        columns: &[S::Column],
        swept: &[Vec<Swept>],
    ) -> Self {
        let values: Vec<_> = values.iter().map(|value| (*value, None)).collect();
        Self {
            unit: quantity.unit(),
            ..Self::of_names(scene, (quantity.name(), None), &values, columns, swept)
        }
    }

    /// Creates the report of the results at each value, or pair of values, of quantities or keys with these `names`.
    #[must_use]
    pub fn of_names<S: Studied>(
        scene: &S,
        names: (&str, Option<&str>),
        values: &[(f64, Option<f64>)],
        columns: &[S::Column],
        swept: &[Vec<Swept>],
    ) -> Self {
        let values = values.iter().zip(swept);
        Self {
            format: FORMAT,
            title: scene.title().into(),
            seed: scene.random_seed(),
            over: names.0.into(),
            unit: "",
            and: names.1.map(Into::into),
            values: values
                .map(|(values, swept)| ValueReport::new(*values, columns, swept))
                .collect(),
            files: Vec::new(),
        }
    }
}

impl ValueReport {
    fn new<C: Compared>(
        (value, and_value): (f64, Option<f64>),
        columns: &[C],
        swept: &[Swept],
    ) -> Self {
        // Hold bound and peak are properties of the ideal, equal for all columns.
        let ideal = swept.first();
        Self {
            value,
            and_value,
            hold_bound_percent: ideal.map_or(0.0, |swept| swept.own.hold_bound),
            ideal_peak_force_n: ideal.map_or(0.0, |swept| swept.outcome.ideal_peak_force),
            columns: (columns.iter().zip(swept))
                .map(|(column, swept)| ColumnReport::new(column, swept))
                .collect(),
        }
    }
}

impl ColumnReport {
    fn new(column: &impl Compared, swept: &Swept) -> Self {
        let outcome = &swept.outcome;
        let heights = swept.over_heights;
        let of_heights = heights.and_then(|of| of.left_box_and_stable);
        let (absolute, created) = match outcome.leak {
            Leak::Absolute(leak) => (Some(leak), None),
            Leak::Created(leak) => (None, Some(leak)),
        };
        Self {
            name: column.name().into(),
            method: column.method(),
            force_rendering_error_percent: swept.own.force_rendering_error,
            mean_force_error_percent: swept.own.mean_force_error,
            median_force_rendering_error_percent: heights.map(|of| of.force_rendering_error.median),
            worst_force_rendering_error_percent: heights.map(|of| of.force_rendering_error.worst),
            left_box_heights: of_heights.map(|[left_box, _]| left_box),
            almost_stable_heights: of_heights.map(|[_, almost_stable]| almost_stable),
            peak_force_n: outcome.peak_force,
            absolute_leak_held_j: absolute,
            leak_j: created,
            refused_samples: created.map(|_| outcome.refused),
            largest_rebound_energy: outcome.bounce.and_then(|it| it.rebound_energy),
            bounce: outcome.bounce.map(|it| it.stability.name()),
            left_box_at_s: outcome.bounce.and_then(|it| it.left_box_at),
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
            let and = match (&self.and, at.and_value) {
                (Some(name), Some(value)) => format!(", {name} {value}"),
                _ => String::new(),
            };
            writeln!(
                f,
                "\n{} {}{unit}{and}: hold bound {:.2} %, peak of the ideal {:.2} N\n",
                self.over, at.value, at.hold_bound_percent, at.ideal_peak_force_n
            )?;
            writeln!(f, "{}", lines(&at.table()))?;
        }
        let is_world = |of: &ColumnReport| of.refused_samples.is_some();
        let words: &[&str] = if self.values.iter().flat_map(|at| &at.columns).any(is_world) {
            &[E, FRE]
        } else {
            &[E, FRE, ABSOLUTE_LEAK, REBOUND]
        };
        writeln!(f, "\n{}", legend(words))?;
        for file in &self.files {
            writeln!(f, "wrote {file}")?;
        }
        Ok(())
    }
}

/// Header and values of a column of a text table.
type Written = (&'static str, fn(&ColumnReport) -> Cell);

impl ValueReport {
    /// Returns the table of the columns that the renderer has.
    fn table(&self) -> Table {
        let has = |of: fn(&ColumnReport) -> bool| self.columns.iter().any(of);
        let mut shown: Vec<Written> = vec![
            ("method", |of| Cell::new(&of.name)),
            ("E %", |of| {
                number(Some(of.mean_force_error_percent), percent)
            }),
            ("FRE %", |of| {
                number(Some(of.force_rendering_error_percent), percent)
            }),
        ];
        if has(|of| of.median_force_rendering_error_percent.is_some()) {
            shown.push(("median", |of| {
                number(of.median_force_rendering_error_percent, percent)
            }));
            shown.push(("worst", |of| {
                number(of.worst_force_rendering_error_percent, percent)
            }));
        }
        shown.push(("peak N", |of| {
            number(Some(of.peak_force_n), |force| format!("{force:.2}"))
        }));
        if has(|of| of.leak_j.is_some()) {
            shown.push(("leak mJ", |of| {
                number(of.leak_j.map(|leak| 1e3 * leak), |leak| short(leak, 3))
            }));
            shown.push(("refused", |of| {
                number(of.refused_samples.map(|count| count as f64), digits)
            }));
        } else {
            shown.push(("|leak| mJ", |of| {
                number(of.absolute_leak_held_j.map(|leak| 1e3 * leak), digits)
            }));
            shown.push(("rebound", |of| {
                number(of.largest_rebound_energy, |ratio| format!("{ratio:.2}"))
            }));
            shown.push(("bounce", |of| {
                Cell::new(of.bounce.unwrap_or("-")).set_alignment(CellAlignment::Right)
            }));
            shown.push(("left box s", |of| {
                number(of.left_box_at_s, |time| format!("{time:.2}"))
            }));
        }
        if has(|of| of.left_box_heights.is_some()) {
            // These columns count start heights.
            shown.push(("almost stable", |of| of_heights(of.almost_stable_heights)));
            shown.push(("left box", |of| of_heights(of.left_box_heights)));
        }
        let header: Vec<_> = shown.iter().map(|(header, _)| *header).collect();
        let mut table = plain_table(CellAlignment::Left, &header);
        for column in &self.columns {
            table.add_row(shown.iter().map(|(_, cell)| cell(column)));
        }
        table
    }
}

fn of_heights(count: Option<usize>) -> Cell {
    number(count.map(|count| count as f64), |count| {
        format!("{count} of {HEIGHTS}")
    })
}
