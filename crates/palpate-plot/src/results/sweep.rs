//! Curves of a sweep.

use std::cmp::Ordering;

use crate::figure::{Figure, Kind, Limits, Panel, Role, Row, Series};
use crate::results::role;
use palpate_scene::method::MethodName;
use palpate_study::sweep::report::{ColumnReport, SweepReport, ValueReport};

/// Ratio of the largest to the least value from which the horizontal axis is logarithmic.
const DECADES_FROM: f64 = 20.0;

/// Returns the role of a column: the role of its method if all columns are methods by their names.
fn role_of(columns: &[ColumnReport], number: usize) -> Role {
    let of_method = |column: &ColumnReport| {
        let method = MethodName::named(column.method)?;
        (column.name == column.method).then_some(method)
    };
    let methods: Option<Vec<_>> = columns.iter().map(of_method).collect();
    methods.map_or(Role::Compared(number), |methods| role(methods[number]))
}

/// Returns the force errors and the generated energy of each column over the values, with the hold bound; side by side
/// for each value of a second quantity.
#[must_use]
pub fn sweep(report: &SweepReport) -> Figure {
    let mut order: Vec<_> = report.values.iter().collect();
    order.sort_by(|a, b| a.value.total_cmp(&b.value));
    let least = order.first().map_or(0.0, |at| at.value);
    let most = order.last().map_or(0.0, |at| at.value);
    let x_decades = least > 0.0 && most >= DECADES_FROM * least;
    let mut seconds: Vec<Option<f64>> = order.iter().map(|at| at.and_value).collect();
    seconds.sort_by(|a, b| a.partial_cmp(b).unwrap_or(Ordering::Equal));
    seconds.dedup();
    let names = order.first().map_or(&[][..], |at| &at.columns);
    let panel =
        |second: &Option<f64>, bound: Option<&str>, of: &dyn Fn(&ColumnReport) -> Option<f64>| {
            let order = || order.iter().filter(|at| at.and_value == *second);
            let along = |at: &ValueReport| {
                if x_decades {
                    at.value.log10()
                } else {
                    at.value
                }
            };
            let x: Vec<f64> = order().map(|at| along(at)).collect();
            let mut series: Vec<_> = names
                .iter()
                .enumerate()
                .map(|(number, column)| Series {
                    name: column.name.clone(),
                    kind: Kind::Line,
                    role: role_of(names, number),
                    x: x.clone(),
                    y: order()
                        .map(|at| at.columns.get(number).and_then(of).unwrap_or(f64::NAN))
                        .collect(),
                })
                .collect();
            if let Some(name) = bound {
                let y = order().map(|at| at.hold_bound_percent).collect();
                let reference = Series {
                    name: name.into(),
                    kind: Kind::Line,
                    role: Role::Reference,
                    x,
                    y,
                };
                series.insert(0, reference);
            }
            Panel { series }
        };
    let row = |y_label: &str, bound: Option<&str>, of: &dyn Fn(&ColumnReport) -> Option<f64>| Row {
        y_label: y_label.into(),
        limits: Limits::Data,
        panels: seconds
            .iter()
            .map(|second| panel(second, bound, of))
            .collect(),
        ..Row::default()
    };
    let columns = (report.and.iter()).flat_map(|name| {
        let values = seconds.iter().flatten();
        values.map(move |value| format!("{name} {value}"))
    });
    let is_world = names.iter().any(|of| of.leak_j.is_some());
    let leak = |of: &ColumnReport| of.leak_j.or(of.absolute_leak_held_j).map(|leak| 1e3 * leak);
    let unit = match report.unit {
        "" => String::new(),
        unit => format!(" [{unit}]"),
    };
    Figure {
        title: match &report.and {
            None => format!("Force errors over {}", report.over),
            Some(and) => format!("Force errors over {} and {and}", report.over),
        },
        subtitle: report.title.clone(),
        footnote: Some(format!(
            "E: error of the mean force of each period. FRE: error of the held force; hold bound: its least value. \
             Leak: energy that the held force creates or takes away{}.",
            if is_world {
                ""
            } else {
                ", sum of the absolute values"
            }
        )),
        x_label: format!("{}{unit}", report.over),
        x_decades,
        columns: columns.collect(),
        rows: vec![
            row("error E [%]", None, &|of| Some(of.mean_force_error_percent)),
            row("FRE [%]", Some("hold bound"), &|of| {
                Some(of.force_rendering_error_percent)
            }),
            row("leak [mJ]", None, &leak),
        ],
    }
}
