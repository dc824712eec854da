//! From runs to figures.

use palpate_sim::method::MethodName;
use palpate_sim::run::{Reference, Run, Tick};

use crate::figure::{Figure, Kind, Limits, Panel, Role, Row, Series};

const METRE_TO_MILLIMETRE: f64 = 1e3;
const JOULE_TO_MILLIJOULE: f64 = 1e3;

/// All runs over each other: object position, force, and the leaks of the force that was held.
pub fn overlay(title: &str, reference: &Reference, runs: &[Run]) -> Figure {
    let compared = |value: fn(&Tick) -> f64, scale: f64, kind: Kind| {
        runs.iter().map(move |run| Series {
            name: run.method.name().into(),
            kind,
            role: role(run.method),
            x: times(run),
            y: run.ticks.iter().map(|tick| scale * value(tick)).collect(),
        })
    };
    let mut positions = ideal_positions(reference);
    positions.extend(compared(
        |tick| tick.output.object_position,
        METRE_TO_MILLIMETRE,
        Kind::Line,
    ));
    if runs.len() == 1 {
        positions.push(device_position(&runs[0], "device"));
    }
    let mut forces = vec![ideal_force(reference)];
    forces.extend(
        runs.iter()
            .map(|run| held_force(run, run.method.name(), role(run.method))),
    );
    let row = |y_label: &str, limits, series| Row {
        y_label: y_label.into(),
        limits,
        panels: vec![Panel { series }],
    };
    Figure {
        title: title.into(),
        footnote: Some(
            "Ideal: object and device in continuous time. Leak: energy created by the held force, \
             accumulated."
                .into(),
        ),
        x_label: "time [s]".into(),
        x_decades: false,
        columns: Vec::new(),
        rows: vec![
            row("position [mm]", Limits::default(), positions),
            row("force on object [N]", Limits::default(), forces),
            row(
                "held leak [mJ]",
                Limits::Calm { times: 3.0 },
                compared(
                    |tick| tick.ledger.held_leak.accumulated,
                    JOULE_TO_MILLIJOULE,
                    Kind::Line,
                )
                .collect(),
            ),
        ],
    }
}

/// The paper's Fig. 2: one column for each step of the method.
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
    };
    Figure {
        title: title.into(),
        footnote: Some(
            "Leaks are accumulated; the original one is that of the spring force on the same \
             motion."
                .into(),
        ),
        x_label: "time [s]".into(),
        x_decades: false,
        columns: steps.iter().map(|(name, _)| (*name).into()).collect(),
        rows: vec![
            row("position [mm]", &|run| {
                let mut series = ideal_positions(reference);
                let object = run
                    .ticks
                    .iter()
                    .map(|tick| METRE_TO_MILLIMETRE * tick.output.object_position)
                    .collect();
                series.push(Series {
                    name: "rendered".into(),
                    kind: Kind::Line,
                    role: Role::Compared(0),
                    x: times(run),
                    y: object,
                });
                series.push(device_position(run, "rendered device"));
                series
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

/// A method looks the same in every figure.
pub fn role(method: MethodName) -> Role {
    Role::Compared(match method {
        MethodName::Hfcr => 0,
        MethodName::Coupled => 9,
        MethodName::Basic => 1,
        MethodName::VirtualDamper => 2,
        MethodName::PopcRef => 3,
        MethodName::Seh => 4,
        MethodName::HfcrModSt => 5,
        MethodName::HfcrMod => 6,
        MethodName::Popc => 7,
    })
}

/// What is not a method looks like none.
const DEVICE: Role = Role::Compared(8);

fn times(run: &Run) -> Vec<f64> {
    run.ticks.iter().map(|tick| tick.time).collect()
}

/// The force that was really held, each from when it reached the motor.
fn held_force(run: &Run, name: &str, role: Role) -> Series {
    let last = run.last();
    let end = (last.time, last.held_force_on_object);
    let held = run
        .held
        .iter()
        .map(|held| (held.from, held.force_on_object));
    let (x, y) = held.chain([end]).unzip();
    Series {
        name: name.into(),
        kind: Kind::Step,
        role,
        x,
        y,
    }
}

fn ideal_force(reference: &Reference) -> Series {
    Series {
        name: "ideal".into(),
        kind: Kind::Line,
        role: Role::Reference,
        x: reference.curve.iter().map(|point| point.time).collect(),
        y: reference
            .curve
            .iter()
            .map(|point| point.force_on_object)
            .collect(),
    }
}

fn ideal_positions(reference: &Reference) -> Vec<Series> {
    let curve = |name: &str, value: fn(&palpate_sim::run::IdealPoint) -> f64| Series {
        name: name.into(),
        kind: Kind::Line,
        role: Role::Reference,
        x: reference.curve.iter().map(|point| point.time).collect(),
        y: reference
            .curve
            .iter()
            .map(|point| METRE_TO_MILLIMETRE * value(point))
            .collect(),
    };
    vec![
        curve("ideal", |point| point.object_position),
        curve("", |point| point.device_position),
    ]
}

fn device_position(run: &Run, name: &str) -> Series {
    Series {
        name: name.into(),
        kind: Kind::Line,
        role: DEVICE,
        x: times(run),
        y: run
            .ticks
            .iter()
            .map(|tick| METRE_TO_MILLIMETRE * tick.true_device_position)
            .collect(),
    }
}
