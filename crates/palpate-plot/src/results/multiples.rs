//! Figures of many runs: one panel per run, with the ideal behind, all on the same axes.

use crate::figure::{Grid, Limits, Panel, Role, Row, Series};
use palpate_study::sim::run::Run;
use palpate_study::text::{digits, percent};

use crate::results::finding;
use crate::results::runs::{Devices, RunsFigure};
use crate::results::series::{
    JOULE_TO_MILLIJOULE, device_position, end_of_motors, held_force, ideal_force, object_position,
};

/// Panels side by side.
const COLUMNS: usize = 3;
/// Leak below which a heading shows 0 `[mJ]`: round-off of the sums.
const ROUND_OFF: f64 = 1e-9;
/// Role of every run, since each panel has only one.
const RENDERED: Role = Role::Compared(0);

/// Returns the panels of a figure and their small print.
pub(super) fn lines(figure: &RunsFigure) -> (Vec<Vec<Grid>>, String) {
    let lines = figure.runs.chunks(COLUMNS).map(|runs| {
        let row = |y_label: &str, panel: &dyn Fn(&Run) -> Vec<Series>| {
            let mut panels: Vec<Panel> = runs
                .iter()
                .map(|run| Panel { series: panel(run) })
                .collect();
            // Empty panels keep the last line as wide as the lines above.
            panels.resize_with(COLUMNS, Panel::default);
            Row {
                y_label: y_label.into(),
                limits: Limits::default(),
                panels,
                ..Row::default()
            }
        };
        vec![Grid {
            columns: runs.iter().map(head).collect(),
            rows: vec![
                row("position [mm]", &|run| positions(figure, run)),
                row("force on object [N]", &|run| forces(figure, run)),
            ],
            ..Grid::default()
        }]
    });
    let note = "FRE: error of the held force to the ideal force. mJ: sum of the absolute energies that the \
                held force created or took away."
        .into();
    (lines.collect(), note)
}

/// Returns name, error and leak of a run. For a run that ended early, the reason replaces the leak.
fn head(run: &Run) -> String {
    let error = run.force.fidelity.map_or_else(String::new, |fidelity| {
        format!("FRE {} %, ", percent(fidelity.force_rendering_error))
    });
    if finding::end(run).is_some() {
        let end = if run.diverged == Some(true) {
            "diverged"
        } else {
            "stopped"
        };
        return format!("{}: {error}{end}", run.method);
    }
    let leak = JOULE_TO_MILLIJOULE * run.last().ledger.held_leak.absolute;
    let leak = if leak < ROUND_OFF { 0.0 } else { leak };
    format!("{}: {error}{} mJ", run.method, digits(leak))
}

fn positions(figure: &RunsFigure, run: &Run) -> Vec<Series> {
    let mut all = figure.ideal_positions();
    if figure.devices != Devices::Recorded {
        all.push(device_position(run, "device", Role::Device));
    }
    all.extend(figure.recorded_object());
    all.push(object_position(run, "rendered", RENDERED));
    all
}

fn forces(figure: &RunsFigure, run: &Run) -> Vec<Series> {
    let mut all = vec![ideal_force(figure.reference)];
    all.extend(figure.recorded_force());
    all.push(held_force(run, "rendered", RENDERED));
    all.extend(end_of_motors(run));
    all
}
