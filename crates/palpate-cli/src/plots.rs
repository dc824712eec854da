//! From runs to figures.

use palpate_scene::Scene;
use palpate_sim::run::{IdealPoint, Reference, Run, RunMethod, Tick};

use palpate_figure::{Figure, Grid, Kind, Limits, Panel, Role, Row, Series, Sheet};
use palpate_study::report::Replayed;

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
    let centre = runs.first().map_or(0.0, |run| run.centre_offset);
    let mut positions = ideal_positions(reference, centre);
    positions.extend(
        runs.iter()
            .map(|run| object_position(run, run.method.name(), role(run.method))),
    );
    if runs.len() == 1 {
        positions.push(device_position(&runs[0], "device"));
    }
    let mut forces = vec![ideal_force(reference)];
    forces.extend(
        runs.iter()
            .map(|run| held_force(run, run.method.name(), role(run.method))),
    );
    forces.extend(runs.iter().filter_map(end_of_motors));
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

/// What a recording has beside the motion, tick by tick.
#[derive(Debug, Default)]
pub struct Recorded {
    /// Time `[s]`.
    pub time: Vec<f64>,
    /// Device position `[m]`.
    pub device_position: Vec<f64>,
    /// Object position `[m]`.
    pub object_position: Vec<f64>,
    /// Force on the object that was really held `[N]`.
    pub force_on_object: Vec<f64>,
    /// Leak of the held force since the first tick `[J]`.
    pub held_leak: Vec<f64>,
}

impl Recorded {
    /// Lets time count from `start` `[s]`.
    pub fn count_from(&mut self, start: f64) {
        self.time.iter_mut().for_each(|time| *time -= start);
    }
}

/// A replay: all runs over each other, and what was recorded beside them.
pub fn replay(
    title: &str,
    replayed: &Replayed,
    reference: &Reference,
    runs: &[Run],
    recorded: Option<&Recorded>,
) -> Figure {
    let title = match replayed.known_to() {
        Some(known) => format!("{title}, the hand's force known to {known}"),
        None => title.into(),
    };
    let mut figure = overlay(&title, reference, runs);
    let how = match replayed {
        Replayed::Motion => {
            "Motion replay: the device moves as recorded, whatever the force. Ideal: the object in \
             continuous time, on that motion."
        }
        Replayed::Hand(_) => {
            "Hand replay: the device moves under the new force and the hand's, as estimated from the \
             recording. Ideal: object and device in continuous time, in that hand."
        }
    };
    let beside = match recorded {
        Some(recorded) => {
            add_recorded(&mut figure, recorded);
            // One device is shown beside the recorded one.
            if runs.len() == 1 && matches!(replayed, Replayed::Hand(_)) {
                let device = &recorded.device_position;
                let series = curve_of(recorded, "", device, METRE_TO_MILLIMETRE, Kind::Line);
                figure.rows[0].panels[0].series.push(series);
            }
            // What a loop that ran away leaked is no measure of what was recorded.
            if runs.iter().all(|run| run.diverged != Some(true)) {
                figure.rows[2].limits = Limits::Data;
            }
            " Recorded: what the recorded loop did."
        }
        None => "",
    };
    figure.footnote = Some(format!(
        "{how}{beside} Leak: energy created by the held force, accumulated."
    ));
    figure
}

fn add_recorded(figure: &mut Figure, recorded: &Recorded) {
    let curves = [
        (&recorded.object_position, METRE_TO_MILLIMETRE, Kind::Line),
        (&recorded.force_on_object, 1.0, Kind::Step),
        (&recorded.held_leak, JOULE_TO_MILLIJOULE, Kind::Line),
    ];
    for (row, (values, scale, kind)) in figure.rows.iter_mut().zip(curves) {
        for panel in &mut row.panels {
            let series = curve_of(recorded, "recorded", values, scale, kind);
            panel.series.push(series);
        }
    }
}

fn curve_of(recorded: &Recorded, name: &str, values: &[f64], scale: f64, kind: Kind) -> Series {
    Series {
        name: name.into(),
        kind,
        role: RECORDED,
        x: recorded.time.clone(),
        y: values.iter().map(|value| scale * value).collect(),
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
                let mut series = ideal_positions(reference, run.centre_offset);
                series.push(object_position(run, "rendered", Role::Compared(0)));
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

/// The paper's Figs. 4 and 5: a row for each method, with positions beside the force, and the leaks
/// of all of them below. `fine` is the loop that the paper takes for the truth.
pub fn method_by_method(
    scene: &Scene,
    reference: &Reference,
    methods: &[(&str, &Run)],
    fine: (&str, &Run),
) -> Sheet {
    let centre = scene.centre_offset();
    // What follows the end of the motors is the hand alone.
    let seen = |run: &Run| -> Vec<Tick> {
        let end = run.left_box_at.unwrap_or(f64::INFINITY);
        let before = |tick: &&Tick| tick.time <= end;
        run.ticks.iter().filter(before).copied().collect()
    };
    let series = |run: &Run, name: &str, role, kind, scale: f64, value: fn(&Tick) -> f64| {
        let ticks = seen(run);
        Series {
            name: name.into(),
            kind,
            role,
            x: ticks.iter().map(|tick| tick.time).collect(),
            y: ticks.iter().map(|tick| scale * value(tick)).collect(),
        }
    };
    let positions = |&(name, run): &(&str, &Run)| {
        let device: fn(&Tick) -> f64 = |tick| tick.true_device_position;
        let object: fn(&Tick) -> f64 = |tick| tick.output.object_position;
        let (mm, line) = (METRE_TO_MILLIMETRE, Kind::Line);
        let mut all = ideal_positions(reference, centre);
        all.push(series(run, "device", DEVICE, line, mm, device));
        let mut object = series(run, name, role(run.method), line, mm, object);
        object.y.iter_mut().for_each(|place| *place += mm * centre);
        all.push(object);
        all
    };
    let forces = |&(name, run): &(&str, &Run)| {
        let held: fn(&Tick) -> f64 = |tick| tick.held_force_on_object;
        let mut all = vec![
            ideal_force(reference),
            series(fine.1, fine.0, FINE, Kind::Step, 1.0, held),
            series(run, name, role(run.method), Kind::Step, 1.0, held),
        ];
        all.extend(end_of_motors(run));
        all
    };
    let rows = |y_label: &str, limits, panel: &dyn Fn(&(&str, &Run)) -> Vec<Series>| {
        let row = |method| Row {
            y_label: y_label.into(),
            limits,
            panels: vec![Panel {
                series: panel(method),
            }],
        };
        methods.iter().map(row).collect()
    };
    let accuracy = |&(name, run): &(&str, &Run)| match run.force.fidelity {
        Some(fidelity) => format!("{name}: FRE {:.1} %", fidelity.force_rendering_error),
        None => name.into(),
    };
    let end = |(_, run): &(&str, &Run)| match run.left_box_at {
        Some(time) => format!("left the safety box at {time:.2} s"),
        None => String::new(),
    };
    let leaks = methods.iter().map(|&(name, run)| {
        let leak: fn(&Tick) -> f64 = |tick| tick.ledger.held_leak.accumulated;
        let scale = JOULE_TO_MILLIJOULE;
        series(run, name, role(run.method), Kind::Line, scale, leak)
    });
    let object = if centre == 0.0 {
        "object"
    } else {
        "the object's centre"
    };
    Sheet {
        title: scene.title.clone(),
        footnote: Some(format!(
            "Left: {object} and device. Right: the force held on the object; FRE is its error to the \
             ideal. Below: energy created by the held force, accumulated. Curves end where the \
             device leaves the safety box, which switches the motors off."
        )),
        x_label: "time [s]".into(),
        x_decades: false,
        lines: vec![
            vec![
                Grid {
                    heads: methods.iter().map(accuracy).collect(),
                    same_scale: true,
                    rows: rows("position [mm]", Limits::Calm { times: 5.5 }, &positions),
                    ..Grid::default()
                },
                Grid {
                    heads: methods.iter().map(end).collect(),
                    same_scale: true,
                    rows: rows("force [N]", Limits::Calm { times: 2.5 }, &forces),
                    ..Grid::default()
                },
            ],
            vec![Grid {
                rows: vec![Row {
                    y_label: "leak [mJ]".into(),
                    limits: Limits::Data,
                    panels: vec![Panel {
                        series: leaks.collect(),
                    }],
                }],
                ..Grid::default()
            }],
        ],
    }
}

/// A method looks the same in every figure.
pub fn role(method: impl Into<RunMethod>) -> Role {
    let method = match method.into() {
        RunMethod::BuiltIn(method) => method,
        RunMethod::Own(_) => return Role::Compared(10),
    };
    Role::Compared(method.info().colour.into())
}

/// What is not a method looks like none.
const DEVICE: Role = Role::Compared(8);
/// The basic model at a high rate, beside what it is to judge.
const FINE: Role = Role::Compared(14);
/// What was recorded, in dots: what is replayed shows between them.
const RECORDED: Role = Role::Compared(38);
/// The end of the motors.
const END: Role = Role::Compared(10);

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

/// The object's centre, or its place where it has no radius.
fn object_position(run: &Run, name: &str, role: Role) -> Series {
    Series {
        name: name.into(),
        kind: Kind::Line,
        role,
        x: times(run),
        y: run
            .ticks
            .iter()
            .map(|tick| METRE_TO_MILLIMETRE * (tick.output.object_position + run.centre_offset))
            .collect(),
    }
}

/// The object's centre, `centre` `[m]` from its place, and the device.
fn ideal_positions(reference: &Reference, centre: f64) -> Vec<Series> {
    let curve = |name: &str, offset: f64, value: fn(&IdealPoint) -> f64| Series {
        name: name.into(),
        kind: Kind::Line,
        role: Role::Reference,
        x: reference.curve.iter().map(|point| point.time).collect(),
        y: reference
            .curve
            .iter()
            .map(|point| METRE_TO_MILLIMETRE * (value(point) + offset))
            .collect(),
    };
    vec![
        curve("ideal", centre, |point| point.object_position),
        curve("", 0.0, |point| point.device_position),
    ]
}

/// Where the safety box has switched the motors off, on the line of no force.
fn end_of_motors(run: &Run) -> Option<Series> {
    run.left_box_at.map(|time| Series {
        name: "safety box left".into(),
        kind: Kind::Points,
        role: END,
        x: vec![time],
        y: vec![0.0],
    })
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
