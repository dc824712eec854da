//! The paper's Fig. 2: the method step by step.

use crate::figure::{Figure, Kind, Limits, Panel, Role, Row, Series};
use palpate_study::sim::run::{Reference, Run, Tick};
use palpate_study::text::percent;

use crate::results::finding;
use crate::results::series::{
    JOULE_TO_MILLIJOULE, device_position, held_force, ideal_device, ideal_force, ideal_object,
    object_position, times,
};

/// Returns the paper's Fig. 2: one column per step of the method.
#[must_use]
pub fn step_by_step(title: &str, reference: &Reference, steps: &[(&str, &Run)]) -> Figure {
    let curve = |run: &Run, value: fn(&Tick) -> f64| Series {
        name: "rendered".into(),
        kind: Kind::Line,
        role: Role::Compared(0),
        x: times(run),
        y: run
            .ticks
            .iter()
            .map(|tick| JOULE_TO_MILLIJOULE * value(tick))
            .collect(),
    };
    let row = |y_label: &str, panel: &dyn Fn(&Run) -> Vec<Series>| Row {
        y_label: y_label.into(),
        limits: Limits::Data,
        panels: steps
            .iter()
            .map(|(_, run)| Panel { series: panel(run) })
            .collect(),
        ..Row::default()
    };
    let errors: Vec<Option<f64>> = steps.iter().map(|(_, run)| finding::error(run)).collect();
    let heads = steps
        .iter()
        .zip(&errors)
        .map(|((name, _), error)| match error {
            Some(error) => format!("{name}: FRE {} %", percent(*error)),
            None => (*name).into(),
        });
    Figure {
        title: falling(steps, &errors),
        subtitle: title.into(),
        footnote: Some(
            "FRE: error of the held force to the ideal force. Leak: energy created by the held force, \
             accumulated; the original one is that of the spring force on the same motion."
                .into(),
        ),
        x_label: "time [s]".into(),
        x_decades: false,
        columns: heads.collect(),
        rows: vec![
            row("position [mm]", &|run| {
                vec![
                    ideal_object(reference, run.centre_offset),
                    ideal_device(reference),
                    object_position(run, "rendered", Role::Compared(0)),
                    device_position(run, "device", Role::Device),
                ]
            }),
            row("force on object [N]", &|run| {
                vec![
                    ideal_force(reference),
                    held_force(run, "rendered", Role::Compared(0)),
                ]
            }),
            row("original leak [mJ]", &|run| {
                vec![curve(run, |tick| tick.ledger.original_leak.accumulated)]
            }),
            row("remaining leak [mJ]", &|run| {
                vec![curve(run, |tick| tick.ledger.held_leak.accumulated)]
            }),
        ],
    }
}

/// States whether and how the errors decrease from step to step.
fn falling(steps: &[(&str, &Run)], errors: &[Option<f64>]) -> String {
    let known: Vec<f64> = errors.iter().flatten().copied().collect();
    let (Some(first), Some(last)) = (known.first(), known.last()) else {
        return String::new();
    };
    let (from, to) = (percent(*first), percent(*last));
    if known.len() == errors.len() && known.is_sorted_by(|a, b| a > b) {
        return format!("The force error falls at each step, from FRE {from} % to {to} %");
    }
    let least = known.iter().copied().fold(f64::INFINITY, f64::min);
    let place = errors.iter().position(|error| *error == Some(least));
    let name = place.map_or("", |place| steps[place].0);
    format!(
        "The force error is least with {name}: FRE {} %",
        percent(least)
    )
}
