//! From runs to figures.

pub mod calibration;
mod compared;
mod experiment;
mod finding;
mod multiples;
mod overlay;
mod runs;
mod steps;

pub use compared::compared;
pub use experiment::method_by_method;

pub use runs::{Devices, RunsFigure};
pub use steps::step_by_step;

use palpate_scene::method::MethodName;
use palpate_sim::run::{IdealPoint, Reference, Run, RunMethod};

use palpate_figure::{Kind, Role, Series};

const METRE_TO_MILLIMETRE: f64 = 1e3;
const JOULE_TO_MILLIJOULE: f64 = 1e3;

/// Those that a figure shows of many methods where nobody has named any: the plain spring, the usual
/// remedy, the paper's method, and the default here.
pub const SHOWN: [MethodName; 4] = [
    MethodName::Basic,
    MethodName::VirtualDamper,
    MethodName::Hfcr,
    MethodName::Coupled,
];

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

/// A method looks the same in every figure.
pub fn role(method: impl Into<RunMethod>) -> Role {
    let method = match method.into() {
        RunMethod::BuiltIn(method) => method,
        RunMethod::Own(_) => return Role::Compared(10),
    };
    Role::Compared(method.info().colour.into())
}

/// The basic model at a high rate, beside what it is to judge.
const FINE: Role = Role::Compared(14);
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

/// The object's centre, `centre` `[m]` from its place.
fn ideal_object(reference: &Reference, centre: f64) -> Series {
    let place: fn(&IdealPoint) -> f64 = |point| point.object_position;
    ideal_position(reference, ("ideal", Role::Reference), centre, place)
}

/// The device of the ideal.
fn ideal_device(reference: &Reference) -> Series {
    let place: fn(&IdealPoint) -> f64 = |point| point.device_position;
    ideal_position(
        reference,
        ("ideal device", Role::BesideReference),
        0.0,
        place,
    )
}

fn ideal_position(
    reference: &Reference,
    (name, role): (&str, Role),
    offset: f64,
    place: fn(&IdealPoint) -> f64,
) -> Series {
    Series {
        name: name.into(),
        kind: Kind::Line,
        role,
        x: reference.curve.iter().map(|point| point.time).collect(),
        y: (reference.curve.iter())
            .map(|point| METRE_TO_MILLIMETRE * (place(point) + offset))
            .collect(),
    }
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

fn device_position(run: &Run, name: &str, role: Role) -> Series {
    Series {
        name: name.into(),
        kind: Kind::Line,
        role,
        x: times(run),
        y: run
            .ticks
            .iter()
            .map(|tick| METRE_TO_MILLIMETRE * tick.true_device_position)
            .collect(),
    }
}

/// The energy that the held force has created, accumulated.
fn held_leak(run: &Run, name: &str, role: Role) -> Series {
    Series {
        name: name.into(),
        kind: Kind::Line,
        role,
        x: times(run),
        y: (run.ticks.iter())
            .map(|tick| JOULE_TO_MILLIJOULE * tick.ledger.held_leak.accumulated)
            .collect(),
    }
}
