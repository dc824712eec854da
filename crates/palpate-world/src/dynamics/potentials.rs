//! Force fields in motion.

use std::f64::consts::{PI, TAU};

use nalgebra::ComplexField;

use crate::description::field::FieldKind;
use crate::dynamics::moving_body::Part;
use crate::geometry::rigid::Vector3;

/// Sums of a field since the interval began.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pulled {
    /// Impulse on the tool `[N s]`.
    pub impulse: Vector3,
    /// First moment of the impulse about the interval's beginning `[N s^2]`.
    pub moment: Vector3,
    /// Work on the tool's proxy `[J]`.
    pub work: f64,
}

impl Pulled {
    fn none() -> Self {
        Self {
            impulse: Vector3::zeros(),
            moment: Vector3::zeros(),
            work: 0.0,
        }
    }
}

/// Region of a field within which its energy is smooth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Region {
    /// No force acts.
    Outside,
    Inside,
    /// Before the first position of the detents.
    Before,
    /// Beyond the range, or the last position of the detents.
    Beyond,
}

/// A field, with its state.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Potential {
    /// Index of its tool.
    pub tool: usize,
    kind: FieldKind,
    region: Region,
    /// Stored energy `[J]`.
    pub stored: f64,
    /// Force on the tool `[N]`.
    pub force: Vector3,
    pub past: Pulled,
}

impl Potential {
    pub fn new(tool: usize, kind: FieldKind) -> Self {
        Self {
            tool,
            kind,
            region: Region::Outside,
            stored: 0.0,
            force: Vector3::zeros(),
            past: Pulled::none(),
        }
    }

    /// Begins an interval.
    pub fn begin(&mut self) {
        self.past = Pulled::none();
    }

    /// Returns whether the tool has passed into another region.
    pub fn changed_from(&self, other: &Self) -> bool {
        self.region != other.region
    }

    /// Returns whether a force acts on the tool, or did since the interval began.
    pub fn acts(&self) -> bool {
        self.region != Region::Outside || self.past.impulse != Vector3::zeros()
    }

    /// Returns whether its work is external energy.
    pub fn is_supplied(&self) -> bool {
        matches!(self.kind, FieldKind::Constant { .. })
    }

    /// Evaluates the field at the current pose of its tool.
    pub fn look(&mut self, part: &Part) {
        let place = part.rigid.position;
        match self.kind {
            FieldKind::Point {
                at,
                stiffness,
                range,
            } => self.spring(place - Vector3::from(at), stiffness, range),
            FieldKind::Line {
                at,
                axis,
                stiffness,
                range,
            } => {
                let (off, axis) = (place - Vector3::from(at), Vector3::from(axis));
                self.spring(off - axis * axis.dot(&off), stiffness, range);
            }
            FieldKind::Plane {
                at,
                normal,
                stiffness,
                range,
            } => {
                let (off, normal) = (place - Vector3::from(at), Vector3::from(normal));
                self.spring(normal * normal.dot(&off), stiffness, range);
            }
            FieldKind::Detents {
                at,
                axis,
                positions,
                period,
                amplitude,
                stiffness,
            } => {
                let axis = Vector3::from(axis);
                let q = axis.dot(&(place - Vector3::from(at)));
                let last = f64::from(positions - 1) * period;
                let beyond = q - q.clamp(0.0, last);
                let push;
                if beyond == 0.0 {
                    // U = A sin^2(pi q/p), which is accurate near a position also.
                    let half = ComplexField::sin(PI * q / period);
                    self.stored = amplitude * half * half;
                    push = -PI * amplitude / period * ComplexField::sin(TAU * q / period);
                    self.region = Region::Inside;
                } else {
                    self.stored = 0.5 * stiffness * beyond * beyond;
                    push = -stiffness * beyond;
                    self.region = if stiffness == 0.0 {
                        Region::Outside
                    } else if beyond < 0.0 {
                        Region::Before
                    } else {
                        Region::Beyond
                    };
                }
                self.force = axis * push;
            }
            FieldKind::Constant { force } => {
                self.force = force.into();
                self.region = Region::Inside;
            }
        }
    }

    /// Evaluates a spring of limited force for the displacement `off` `[m]`.
    fn spring(&mut self, off: Vector3, stiffness: f64, range: f64) {
        let distance = off.norm();
        if distance <= range {
            self.stored = 0.5 * stiffness * distance * distance;
            self.force = off * -stiffness;
            self.region = Region::Inside;
        } else {
            self.stored = stiffness * range * (distance - 0.5 * range);
            self.force = off * (-stiffness * range / distance);
            self.region = Region::Beyond;
        }
    }

    /// Adds half a sub-step under the force to the sums, at the time `at` since the interval began `[s]`.
    #[inline]
    pub fn entry<const BOOKS: bool>(&mut self, part: &Part, [half, at]: [f64; 2]) {
        let impulse = self.force * half;
        self.past.impulse += impulse;
        self.past.moment += impulse * at;
        if BOOKS {
            self.past.work += impulse.dot(&part.mean.velocity);
        }
    }

    /// Returns an upper bound of the squared angular frequency of the tool in the field, for its mobility `[1/s^2]`.
    pub fn square(&self, part: &Part) -> f64 {
        let mobility = part.mobility.linear.max();
        match self.kind {
            FieldKind::Point { stiffness, .. }
            | FieldKind::Line { stiffness, .. }
            | FieldKind::Plane { stiffness, .. } => stiffness * mobility,
            FieldKind::Detents {
                period,
                amplitude,
                stiffness,
                ..
            } => (0.5 * amplitude * (TAU / period).powi(2)).max(stiffness) * mobility,
            FieldKind::Constant { .. } => 0.0,
        }
    }

    /// Returns an upper bound of the angular frequency at which the tool passes detents within `h` `[s]` `[rad/s]`.
    pub fn passing(&self, part: &Part, h: f64) -> f64 {
        match self.kind {
            FieldKind::Detents { axis, period, .. } if self.region == Region::Inside => {
                let speed = Vector3::from(axis).dot(&part.rigid.velocity).abs();
                let by_force = part.mobility.acceleration(&part.force).norm();
                let pushed = part.drive.acceleration.norm() + by_force;
                TAU * (speed + pushed * h) / period
            }
            _ => 0.0,
        }
    }
}
