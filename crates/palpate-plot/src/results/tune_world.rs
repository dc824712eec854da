//! Curves of a method tuned on a world.

use crate::figure::{Figure, Kind, Limits, Panel, Role, Row, Series};
use palpate_study::text::{digits, percent};
use palpate_study::world::SettingReport;
use palpate_study::world::tune::{WorldPointReport, WorldTuneReport};

/// Returns error and leak over the damping, with one curve per coupling and the chosen setting.
#[must_use]
pub fn tune_world(report: &WorldTuneReport) -> Figure {
    let row = |y_label: &str, of: &dyn Fn(&WorldPointReport) -> f64| {
        let mut series = Vec::new();
        let coupling = |setting: &SettingReport| {
            (setting.coupling_stiffness_n_per_m, setting.coupling_mass_kg)
        };
        let mut rest = &report.curve[..];
        while let Some(first) = rest.first() {
            let of_this = coupling(&first.settings);
            let same = rest
                .iter()
                .take_while(|it| coupling(&it.settings) == of_this);
            let (points, others) = rest.split_at(same.count());
            rest = others;
            series.push(Series {
                name: name(of_this),
                kind: Kind::Line,
                role: Role::Compared(series.len()),
                x: points.iter().map(damping).collect(),
                y: points.iter().map(of).collect(),
            });
        }
        series.push(Series {
            name: format!("chosen: {}", report.best.settings.in_short()),
            kind: Kind::Points,
            role: Role::Mark,
            x: vec![damping(&report.best)],
            y: vec![of(&report.best)],
        });
        Row {
            y_label: y_label.into(),
            limits: Limits::Data,
            panels: vec![Panel { series }],
            ..Row::default()
        }
    };
    let error = |point: &WorldPointReport| point.mean_force_error_percent.unwrap_or(f64::NAN);
    Figure {
        title: format!(
            "{} with {}{} has the least {}: E {} %",
            report.method,
            report.best.settings.in_short(),
            if report.has_largest_damping() {
                ", the largest damping tried,"
            } else {
                ""
            },
            report.least,
            percent(error(&report.best))
        ),
        subtitle: report.title.clone(),
        footnote: Some(
            "E: error of the mean force of each period, over all devices and axes. Leak: energy that held forces \
             created. Chosen with knowledge of the ideal."
                .into(),
        ),
        x_label: "damping [N s/m]".into(),
        x_decades: false,
        columns: Vec::new(),
        rows: vec![
            row("error E [%]", &error),
            row("leak [mJ]", &|point| 1e3 * point.leak_j),
        ],
    }
}

fn damping(point: &WorldPointReport) -> f64 {
    point.settings.damping_n_s_per_m.unwrap_or(0.0)
}

fn name((stiffness, mass): (Option<f64>, Option<f64>)) -> String {
    match (stiffness, mass) {
        (None, _) => "every damping".into(),
        (Some(stiffness), None) => format!("k {} N/m", digits(stiffness)),
        (Some(stiffness), Some(mass)) => {
            format!("k {} N/m, m {} kg", digits(stiffness), digits(mass))
        }
    }
}
