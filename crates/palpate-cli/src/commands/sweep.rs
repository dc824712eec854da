//! `palpate sweep`: one quantity of a scene over several values.

use std::fmt;

use comfy_table::CellAlignment;
use palpate_scene::Measure;
use palpate_scene::method::MethodName;
use palpate_study::suite::Column;
use palpate_study::sweep::{Quantity, Swept, sweep};
use palpate_study::tune::{HEIGHTS, tunable};
use serde::Serialize;

use super::simulate::read_scene;
use crate::arguments::SweepArguments;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::report::{digits, lines, number, percent, plain_table};
use crate::results::print;

/// Runs every column at every value.
pub fn run(arguments: &SweepArguments) -> Result<(), Failure> {
    let quantity = arguments.over;
    let compared = &arguments.compared;
    let columns = match (&compared.method, &compared.columns, quantity) {
        // Without a name, those that have what is varied.
        (None, None, Quantity::Damping) => MethodName::ALL
            .into_iter()
            .filter(|method| tunable(*method).is_some())
            .map(Column::of)
            .collect(),
        _ => compared.columns()?,
    };
    let mut scene = read_scene(&arguments.scene)?.scene;
    if let Some(collisions) = arguments.collisions {
        scene.measure = Measure::Collisions(collisions);
    }
    let values = &arguments.values.0;
    let progress = Progress::new(values.len());
    progress.begin(quantity.name());
    let done = || progress.advance();
    let swept = sweep(&scene, quantity, values, &columns, arguments.heights, done)
        .map_err(|error| Failure::input(format!("{}: {error}", arguments.scene.display())))?;
    drop(progress);
    let report = Report {
        format: "palpate sweep 1",
        title: scene.title.clone(),
        over: quantity.name(),
        unit: quantity.unit(),
        values: values
            .iter()
            .zip(&swept)
            .map(|(value, swept)| ValueReport::new(*value, &columns, swept))
            .collect(),
    };
    print(&if arguments.json {
        serde_json::to_string_pretty(&report).expect("a report has string keys only") + "\n"
    } else {
        report.to_string()
    })
}

#[derive(Serialize)]
struct Report {
    format: &'static str,
    title: String,
    over: &'static str,
    unit: &'static str,
    values: Vec<ValueReport>,
}

#[derive(Serialize)]
struct ValueReport {
    value: f64,
    hold_floor_percent: f64,
    ideal_peak_force_n: f64,
    columns: Vec<ColumnReport>,
}

#[derive(Serialize)]
struct ColumnReport {
    name: String,
    method: &'static str,
    force_rendering_error_percent: f64,
    mean_force_error_percent: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    median_force_rendering_error_percent: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    worst_force_rendering_error_percent: Option<f64>,
    /// Of the start heights.
    #[serde(skip_serializing_if = "Option::is_none")]
    left_box_heights: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    almost_stable_heights: Option<usize>,
    peak_force_n: f64,
    absolute_leak_held_j: f64,
    largest_rebound_energy: Option<f64>,
    bounce: &'static str,
    left_box_at_s: Option<f64>,
}

impl ValueReport {
    fn new(value: f64, columns: &[Column], swept: &[Swept]) -> Self {
        // Floor and peak are the ideal's, whatever the column.
        let ideal = swept.first();
        Self {
            value,
            hold_floor_percent: ideal.map_or(0.0, |swept| swept.own.hold_floor),
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

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let unit = match self.unit {
            "" => String::new(),
            unit => format!(" {unit}"),
        };
        writeln!(f, "{}", self.title)?;
        for at in &self.values {
            writeln!(
                f,
                "\n{} {}{unit}: floor {:.2} %, peak of the ideal {:.2} N\n",
                self.over, at.value, at.hold_floor_percent, at.ideal_peak_force_n
            )?;
            let header = [
                "method",
                "FRE %",
                "median",
                "worst",
                "peak N",
                "|leak| mJ",
                "rebound",
                "bounce",
                "left box s",
                "almost stable",
                "left box",
            ];
            // The last two count start heights.
            let heights = at.columns.iter().any(|of| of.left_box_heights.is_some());
            let header = &header[..header.len() - if heights { 0 } else { 2 }];
            let of_heights = |count: Option<usize>| {
                number(count.map(|count| count as f64), |count| {
                    format!("{count} of {HEIGHTS}")
                })
            };
            let mut table = plain_table(CellAlignment::Left, header);
            for column in &at.columns {
                let mut cells = vec![
                    (&*column.name).into(),
                    number(Some(column.force_rendering_error_percent), percent),
                    number(column.median_force_rendering_error_percent, percent),
                    number(column.worst_force_rendering_error_percent, percent),
                    number(Some(column.peak_force_n), |force| format!("{force:.2}")),
                    number(Some(1e3 * column.absolute_leak_held_j), digits),
                    number(column.largest_rebound_energy, |ratio| format!("{ratio:.2}")),
                    comfy_table::Cell::new(column.bounce).set_alignment(CellAlignment::Right),
                    number(column.left_box_at_s, |time| format!("{time:.2}")),
                ];
                if heights {
                    cells.push(of_heights(column.almost_stable_heights));
                    cells.push(of_heights(column.left_box_heights));
                }
                table.add_row(cells);
            }
            writeln!(f, "{}", lines(&table))?;
        }
        Ok(())
    }
}
