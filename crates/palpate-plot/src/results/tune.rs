//! Curves of a tuned setting.

use crate::figure::{Figure, Kind, Limits, Panel, Role, Row, Series};
use palpate_study::text::{digits, percent};
use palpate_study::tune::Spread;
use palpate_study::tune::report::{PointReport, TuneReport};

/// Returns the curves of a report over the values, with the chosen value.
#[must_use]
pub fn tune(report: &TuneReport) -> Figure {
    let x: Vec<f64> = report
        .curve
        .iter()
        .map(|point| point.value_n_s_per_m)
        .collect();
    let series = |index, name: &str, value: &dyn Fn(&PointReport) -> f64| Series {
        name: name.into(),
        kind: Kind::Line,
        role: Role::Compared(index),
        x: x.clone(),
        y: report.curve.iter().map(value).collect(),
    };
    let best = report.best.value_n_s_per_m;
    let chosen = format!("chosen: {} N s/m", digits(best));
    let row = |y_label: &str, of: &dyn Fn(&PointReport) -> Spread| {
        let mut all = vec![
            series(1, "own height", &|point| of(point).own),
            series(2, "worst height", &|point| of(point).worst),
            series(0, "median height", &|point| of(point).median),
        ];
        // The line of the chosen value spans all drawn values.
        let heights = || all.iter().flat_map(|series| &series.y).copied();
        let heights = || heights().filter(|height| height.is_finite());
        let (least, most) = (
            heights().fold(f64::INFINITY, f64::min),
            heights().fold(f64::NEG_INFINITY, f64::max),
        );
        let mark = |name: &str, kind, x: Vec<f64>, y: Vec<f64>| Series {
            name: name.into(),
            kind,
            role: Role::Mark,
            x,
            y,
        };
        let at = of(&report.best).median;
        all.push(mark("", Kind::Line, vec![best, best], vec![least, most]));
        all.push(mark(&chosen, Kind::Points, vec![best], vec![at]));
        Row {
            y_label: y_label.into(),
            limits: Limits::Data,
            panels: vec![Panel { series: all }],
            ..Row::default()
        }
    };
    let error = report.best.mean_force_error_percent;
    Figure {
        title: format!(
            "{} with a {} of {} N s/m has the least {}: E {} % in the median, {} % at the worst height",
            report.method,
            report.setting_in_words(),
            digits(best),
            report.least,
            percent(error.median),
            percent(error.worst)
        ),
        subtitle: report.title.clone(),
        footnote: Some(format!(
            "E: error of the mean force of each period. Leak: energy that the held force creates or takes \
             away. {} start heights within ±{} % of the scene's gap; chosen by the median.",
            report.start_heights,
            100.0 * report.height_range
        )),
        x_label: format!("{} [N s/m]", report.setting_in_words()),
        x_decades: false,
        columns: Vec::new(),
        rows: vec![
            row("error E [%]", &|point| point.mean_force_error_percent),
            row("sum of leaks [mJ]", &|point| {
                let leak = point.absolute_leak_j;
                Spread {
                    own: 1e3 * leak.own,
                    median: 1e3 * leak.median,
                    worst: 1e3 * leak.worst,
                }
            }),
        ],
    }
}
