//! Curves of runs and of their ideal.

use crate::figure::{Kind, Role, Series};
use palpate_study::sim::run::{IdealPoint, Reference, Run};

pub(crate) const METRE_TO_MILLIMETRE: f64 = 1e3;
pub(crate) const JOULE_TO_MILLIJOULE: f64 = 1e3;

/// Role of the basic model at a high rate, the paper's reference.
pub(crate) const FINE: Role = Role::Compared(14);
/// Role of the marker where the motors are switched off.
pub(crate) const END: Role = Role::Compared(10);

pub(crate) fn times(run: &Run) -> Vec<f64> {
    run.ticks.iter().map(|tick| tick.time).collect()
}

/// Returns the force actually held, each value from the time at which it reached the motor.
pub(crate) fn held_force(run: &Run, name: &str, role: Role) -> Series {
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

pub(crate) fn ideal_force(reference: &Reference) -> Series {
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

/// Returns the object's centre, or its position if it has no radius.
pub(crate) fn object_position(run: &Run, name: &str, role: Role) -> Series {
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

/// Returns the object's centre, `centre` `[m]` from its position.
pub(crate) fn ideal_object(reference: &Reference, centre: f64) -> Series {
    let place: fn(&IdealPoint) -> f64 = |point| point.object_position;
    ideal_position(reference, ("ideal", Role::Reference), centre, place)
}

/// Returns the device position of the ideal.
pub(crate) fn ideal_device(reference: &Reference) -> Series {
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

/// Returns a marker on the zero-force line at the time when the safety box switched the motors off.
pub(crate) fn end_of_motors(run: &Run) -> Option<Series> {
    run.left_box_at.map(|time| Series {
        name: "safety box left".into(),
        kind: Kind::Points,
        role: END,
        x: vec![time],
        y: vec![0.0],
    })
}

pub(crate) fn device_position(run: &Run, name: &str, role: Role) -> Series {
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

/// Returns the accumulated generated energy of the held force.
pub(crate) fn held_leak(run: &Run, name: &str, role: Role) -> Series {
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
