//! The paper's Figs. 4 and 5: one row per method.

use crate::figure::{Grid, Kind, Limits, Panel, Role, Row, Series, Sheet};
use palpate_scene::Scene;
use palpate_study::sim::run::{Reference, Run, Tick};
use palpate_study::text::percent;

use crate::results::series::{
    FINE, JOULE_TO_MILLIJOULE, METRE_TO_MILLIMETRE, end_of_motors, ideal_device, ideal_force,
    ideal_object,
};
use crate::results::{finding, role};

/// Ideal and reference loop to which the runs are compared.
struct Comparison<'a> {
    /// The ideal.
    reference: &'a Reference,
    /// Name and run of the paper's own reference loop.
    fine: (&'a str, &'a Run),
    /// Position of the object's centre, from the object's position `[m]`.
    centre: f64,
}

/// Returns the paper's Figs. 4 and 5: a row per method with positions and force, and the leaks of all methods below.
/// `fine` is the paper's own reference loop.
#[must_use]
pub fn method_by_method(
    scene: &Scene,
    reference: &Reference,
    methods: &[(&str, &Run)],
    fine: (&str, &Run),
) -> Sheet {
    let centre = scene.centre_offset();
    let compared = Comparison {
        reference,
        fine,
        centre,
    };
    let object = if centre == 0.0 {
        "object"
    } else {
        "the object's centre"
    };
    let (names, runs): (Vec<&str>, Vec<&Run>) = methods.iter().copied().unzip();
    Sheet {
        title: finding::of_runs(&runs, &names).unwrap_or_default(),
        subtitle: scene.title.clone(),
        footnote: Some(format!(
            "Left: {object} and device. Right: force on the object; FRE: its error to the ideal force. \
             Bottom: energy that the held force created, accumulated. A curve ends where the device \
             leaves the safety box and the motors are switched off."
        )),
        x_label: "time [s]".into(),
        lines: vec![
            vec![
                position_grid(&compared, methods),
                force_grid(&compared, methods),
            ],
            vec![leak_grid(methods)],
        ],
        ..Sheet::default()
    }
}

/// Returns the positions of object and device, a row per method with its force rendering error.
fn position_grid(compared: &Comparison, methods: &[(&str, &Run)]) -> Grid {
    let accuracy = |&(name, run): &(&str, &Run)| match run.force.fidelity {
        Some(fidelity) => format!("{name}: FRE {} %", percent(fidelity.force_rendering_error)),
        None => name.into(),
    };
    let limits = Limits::Calm { times: 5.5 };
    Grid {
        heads: methods.iter().map(accuracy).collect(),
        same_scale: true,
        rows: rows(methods, "position [mm]", limits, |method| {
            positions(compared, method)
        }),
        ..Grid::default()
    }
}

/// Returns the forces on the object, a row per method with the time at which it left the safety box.
fn force_grid(compared: &Comparison, methods: &[(&str, &Run)]) -> Grid {
    let end = |(_, run): &(&str, &Run)| match run.left_box_at {
        Some(time) => format!("left the safety box at {time:.2} s"),
        None => String::new(),
    };
    let limits = Limits::Calm { times: 2.5 };
    Grid {
        heads: methods.iter().map(end).collect(),
        same_scale: true,
        rows: rows(methods, "force [N]", limits, |method| {
            forces(compared, method)
        }),
        ..Grid::default()
    }
}

/// Returns the accumulated leaks of all methods in one panel.
fn leak_grid(methods: &[(&str, &Run)]) -> Grid {
    let leaks = methods.iter().map(|&(name, run)| {
        let leak: fn(&Tick) -> f64 = |tick| tick.ledger.held_leak.accumulated;
        let scale = JOULE_TO_MILLIJOULE;
        series(run, name, role(run.method), Kind::Line, scale, leak)
    });
    Grid {
        rows: vec![Row {
            y_label: "leak [mJ]".into(),
            limits: Limits::Data,
            panels: vec![Panel {
                series: leaks.collect(),
            }],
            ..Row::default()
        }],
        ..Grid::default()
    }
}

/// Returns a row of one panel for each method.
fn rows(
    methods: &[(&str, &Run)],
    y_label: &str,
    limits: Limits,
    panel: impl Fn((&str, &Run)) -> Vec<Series>,
) -> Vec<Row> {
    let row = |method: &(&str, &Run)| Row {
        y_label: y_label.into(),
        limits,
        panels: vec![Panel {
            series: panel(*method),
        }],
        ..Row::default()
    };
    methods.iter().map(row).collect()
}

/// Returns the positions of object and device of the ideal and of a run `[mm]`.
fn positions(compared: &Comparison, (name, run): (&str, &Run)) -> Vec<Series> {
    let device: fn(&Tick) -> f64 = |tick| tick.true_device_position;
    let object: fn(&Tick) -> f64 = |tick| tick.output.object_position;
    let (mm, line) = (METRE_TO_MILLIMETRE, Kind::Line);
    let (reference, centre) = (compared.reference, compared.centre);
    let mut all = vec![ideal_object(reference, centre), ideal_device(reference)];
    all.push(series(run, "device", Role::Device, line, mm, device));
    let mut object = series(run, name, role(run.method), line, mm, object);
    object.y.iter_mut().for_each(|place| *place += mm * centre);
    all.push(object);
    all
}

/// Returns the forces on the object of the ideal, the reference loop and a run `[N]`.
fn forces(compared: &Comparison, (name, run): (&str, &Run)) -> Vec<Series> {
    let held: fn(&Tick) -> f64 = |tick| tick.held_force_on_object;
    let fine = compared.fine;
    let mut all = vec![
        ideal_force(compared.reference),
        series(fine.1, fine.0, FINE, Kind::Step, 1.0, held),
        series(run, name, role(run.method), Kind::Step, 1.0, held),
    ];
    all.extend(end_of_motors(run));
    all
}

/// Returns a value of the ticks of a run, times `scale`, up to the end of its motors.
fn series(
    run: &Run,
    name: &str,
    role: Role,
    kind: Kind,
    scale: f64,
    value: fn(&Tick) -> f64,
) -> Series {
    let ticks = seen(run);
    Series {
        name: name.into(),
        kind,
        role,
        x: ticks.iter().map(|tick| tick.time).collect(),
        y: ticks.iter().map(|tick| scale * value(tick)).collect(),
    }
}

/// Returns the ticks of a run up to the time at which its motors were switched off: after it, only the hand moves the
/// device.
fn seen(run: &Run) -> Vec<Tick> {
    let end = run.left_box_at.unwrap_or(f64::INFINITY);
    let before = |tick: &&Tick| tick.time <= end;
    run.ticks.iter().filter(before).copied().collect()
}
