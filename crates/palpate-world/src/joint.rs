//! Joints: hinges and sliders between two bodies, or between a body and the world.

use crate::Vector;

/// What a joint lets a body do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum JointKind {
    /// Turn about the axis, and nothing else.
    Hinge,
    /// Slide along the axis, and nothing else.
    Slider,
}

/// A joint, as the bodies stand at the start.
///
/// It is a bearing of springs, stiff in all directions but one. A hinge holds two points of its axis, `span` apart, by
/// K/2 each. A slider holds four points, half a span from its own in both directions along the axis and across it, by K/4
/// each in the two directions across the axis. The points across the axis lie along the first of those axes of the body that are least
/// along it, as far as that is across. Along or about the axis it may have a spring, a damper and stops.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Name of the body that moves.
    pub body: String,
    /// Name of the body against which it does, or `None` for the world.
    pub against: Option<String>,
    /// What it lets the body do.
    pub kind: JointKind,
    /// The middle of the bearing, in world axes at the start `[m]`.
    pub point: Vector,
    /// Unit vector along the axis, in world axes at the start.
    pub axis: Vector,
    /// Its springs.
    pub law: JointLaw,
}

/// Springs, dampers and stops of a joint.
///
/// Its coordinate q is the way along the axis `[m]` or the angle about it `[rad]` of the body against the other one, 0 at the
/// start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLaw {
    /// K against a displacement that the joint does not let pass, above 0 `[N/m]`.
    pub stiffness: f64,
    /// Damping of such a displacement, at least 0 `[N s/m]`.
    pub damping: f64,
    /// Length of the bearing, above 0 `[m]`: against tilt a hinge has K span^2/4, and a slider K span^2/8, as it has
    /// against a turn about its axis `[N m/rad]`.
    pub span: f64,
    /// Stiffness of a spring along q, at least 0: `[N/m]`, of a hinge `[N m/rad]`.
    pub spring: f64,
    /// Where that spring is relaxed: `[m]`, of a hinge `[rad]`.
    pub rest: f64,
    /// Damping along q, at least 0: `[N s/m]`, of a hinge `[N m s/rad]`.
    pub along_damping: f64,
    /// Stops: beyond these values of q a spring pushes back, K of a slider and K span^2/4 of a hinge.
    pub limits: Option<[f64; 2]>,
}

impl JointLaw {
    /// A bearing of that stiffness `[N/m]` and length `[m]`, without damping, spring and stops.
    #[must_use]
    pub fn of(stiffness: f64, span: f64) -> Self {
        Self {
            stiffness,
            damping: 0.0,
            span,
            spring: 0.0,
            rest: 0.0,
            along_damping: 0.0,
            limits: None,
        }
    }
}
