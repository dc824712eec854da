//! Figures of a few superimposed runs: positions, force, and generated energy of the held force.

use crate::figure::{Grid, Limits, Panel, Role, Row, Series};

use crate::results::role;
use crate::results::runs::{Devices, RunsFigure};
use crate::results::series::{
    device_position, end_of_motors, held_force, held_leak, ideal_force, object_position,
};

/// Returns the panels of a figure and their small print.
pub(super) fn lines(figure: &RunsFigure) -> (Vec<Vec<Grid>>, String) {
    let runs = figure.runs;
    let named = || {
        runs.iter()
            .map(|run| (run, run.method.name(), role(run.method)))
    };
    let mut positions = figure.ideal_positions();
    let (mut note, mut beside) = (String::new(), Vec::new());
    match (figure.devices, runs) {
        (Devices::Recorded, _) => {}
        (_, [run]) => {
            positions.push(device_position(run, "device", Role::Device));
            // Only one device is shown beside the recorded one.
            positions.extend(figure.recorded_device());
        }
        _ => {
            note = "Thin lines: the device under each method. ".into();
            beside.extend(named().map(|(run, _, role)| device_position(run, "", thin(role))));
        }
    }
    // Recorded curves are drawn behind: the run of the recorded method coincides with them.
    positions.extend(figure.recorded_object());
    positions.extend(named().map(|(run, name, role)| object_position(run, name, role)));
    positions.extend(beside);

    let mut forces = vec![ideal_force(figure.reference)];
    forces.extend(figure.recorded_force());
    forces.extend(named().map(|(run, name, role)| held_force(run, name, role)));
    forces.extend(runs.iter().filter_map(end_of_motors));

    let mut leaks: Vec<Series> = figure.recorded_leak().into_iter().collect();
    leaks.extend(named().map(|(run, name, role)| held_leak(run, name, role)));
    // A diverged loop's leak must not set the scale of the others. Without a diverged loop the axis shows the largest
    // leak: the smallest may be round-off.
    let leak_limits = if runs.iter().any(|run| run.diverged == Some(true)) {
        Limits::Calm { times: 3.0 }
    } else {
        Limits::Data
    };

    let row = |y_label: &str, limits, series| Row {
        y_label: y_label.into(),
        limits,
        panels: vec![Panel { series }],
        ..Row::default()
    };
    let grid = Grid {
        rows: vec![
            row("position [mm]", Limits::default(), positions),
            row("force on object [N]", Limits::default(), forces),
            row("held leak [mJ]", leak_limits, leaks),
        ],
        ..Grid::default()
    };
    note += "Leak: energy created by the held force, accumulated.";
    (vec![vec![grid]], note)
}

/// Returns the role of the companion of a method: the same look, thinner.
fn thin(role: Role) -> Role {
    match role {
        Role::Compared(number) => Role::Beside(number),
        other => other,
    }
}
