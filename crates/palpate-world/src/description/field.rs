//! Force fields on tools: potentials that need no contact.

use super::world::Faults;
use crate::{Tool, Vector, WorldField};

/// A force field on a tool.
///
/// The force acts on the tool's centre, so it has no torque. It is minus the gradient of a stored energy U(x), whose
/// gradient is continuous everywhere.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Name of the tool.
    pub tool: String,
    /// Kind of the field, with its parameters.
    pub kind: FieldKind,
}

/// Potential of a force field at a position x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FieldKind {
    /// Spring to a point. With the distance d, U = K d^2/2 within the range r, and U = K r (d - r/2) beyond it: the
    /// force stays at K r.
    Point {
        /// The point `[m]`.
        at: Vector,
        /// K, above 0 `[N/m]`.
        stiffness: f64,
        /// r, above 0 `[m]`.
        range: f64,
    },
    /// The same spring to a line.
    Line {
        /// A point of the line `[m]`.
        at: Vector,
        /// Unit vector along the line.
        axis: Vector,
        /// K, above 0 `[N/m]`.
        stiffness: f64,
        /// r, above 0 `[m]`.
        range: f64,
    },
    /// The same spring to a plane, on both sides.
    Plane {
        /// A point of the plane `[m]`.
        at: Vector,
        /// Unit normal of the plane.
        normal: Vector,
        /// K, above 0 `[N/m]`.
        stiffness: f64,
        /// r, above 0 `[m]`.
        range: f64,
    },
    /// Detents along an axis: with the displacement q, U = A/2 (1 - cos(2 pi q/p)) between the first position, at
    /// q = 0, and the last. Beyond them, U = K e^2/2 with the distance e from the nearest position.
    Detents {
        /// The first position `[m]`.
        at: Vector,
        /// Unit vector from the first to the last position.
        axis: Vector,
        /// Number of positions, at least 1.
        positions: u32,
        /// p: distance between two positions, above 0 `[m]`.
        period: f64,
        /// A: energy between two positions, at least 0 `[J]`. The largest force is pi A/p.
        amplitude: f64,
        /// K of the end stops, at least 0 `[N/m]`.
        stiffness: f64,
    },
    /// Constant force. Its work is external, as that of a body's constant force; it stores no energy.
    Constant {
        /// The force `[N]`.
        force: Vector,
    },
}

impl Faults<'_> {
    /// Reports the faults of a field.
    pub(super) fn field(&mut self, field: &Field, tools: &[Tool], is_body: bool) {
        let name = &field.tool;
        if is_body {
            let message = format!("{name:?} is a body; a field acts on a tool");
            self.fault(WorldField::Tool, message);
        } else if !tools.iter().any(|tool| tool.name == *name) {
            let message = format!("{name:?} is not a tool of this world");
            self.fault(WorldField::Tool, message);
        }
        match field.kind {
            FieldKind::Point {
                at,
                stiffness,
                range,
            } => self.spring(&at, stiffness, range),
            FieldKind::Line {
                at,
                axis,
                stiffness,
                range,
            } => {
                self.spring(&at, stiffness, range);
                self.unit(WorldField::Axis, &axis);
            }
            FieldKind::Plane {
                at,
                normal,
                stiffness,
                range,
            } => {
                self.spring(&at, stiffness, range);
                self.unit(WorldField::Normal, &normal);
            }
            FieldKind::Detents {
                at,
                axis,
                positions,
                period,
                amplitude,
                stiffness,
            } => {
                self.finite(WorldField::At, &at);
                self.unit(WorldField::Axis, &axis);
                if positions == 0 {
                    let message = "positions is 0, and has to be at least 1";
                    self.fault(WorldField::Positions, message.into());
                }
                self.above_zero(WorldField::Period, period);
                self.at_least_zero(WorldField::Amplitude, amplitude);
                self.at_least_zero(WorldField::Stiffness, stiffness);
            }
            FieldKind::Constant { force } => self.finite(WorldField::Force, &force),
        }
    }

    fn spring(&mut self, at: &Vector, stiffness: f64, range: f64) {
        self.finite(WorldField::At, at);
        self.above_zero(WorldField::Stiffness, stiffness);
        self.above_zero(WorldField::Range, range);
    }
}
