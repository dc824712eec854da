//! Joints: hinges and sliders between two bodies, or between a body and the world.

use crate::Vector;

/// Degree of freedom of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum JointKind {
    /// Rotation about the axis.
    Hinge,
    /// Translation along the axis.
    Slider,
}

/// A joint, described for the initial poses of the bodies.
///
/// A joint is a bearing of springs, stiff in all directions but one. A hinge holds two points of its axis, `span`
/// apart, by K/2 each. A slider holds four points, half a span from its own point in both directions along the axis
/// and along a transverse direction, by K/4 each in the two directions perpendicular to the axis. The transverse
/// direction is the first of the body's axes with the smallest component along the joint axis, projected onto the
/// normal plane. A joint can have a spring, a damper and stops along or about the axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Name of the moving body.
    pub body: String,
    /// Name of the reference body, or `None` for the world.
    pub against: Option<String>,
    /// Kind of joint.
    pub kind: JointKind,
    /// Centre of the bearing, in world axes at the start `[m]`.
    pub point: Vector,
    /// Unit vector along the axis, in world axes at the start.
    pub axis: Vector,
    /// Springs, dampers and stops.
    pub law: JointLaw,
}

/// Springs, dampers and stops of a joint.
///
/// The coordinate q is the displacement along the axis `[m]` or the rotation about it `[rad]` of the body relative to
/// the reference body, 0 at the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLaw {
    /// K against constrained displacements, above 0 `[N/m]`.
    pub stiffness: f64,
    /// Damping of constrained displacements, at least 0 `[N s/m]`.
    pub damping: f64,
    /// Length of the bearing, above 0 `[m]`. The stiffness against tilt is K span^2/4 for a hinge and K span^2/8 for
    /// a slider; the latter also applies to rotation about the slider's axis `[N m/rad]`.
    pub span: f64,
    /// Stiffness of a spring along q, at least 0 `[N/m]`, for a hinge `[N m/rad]`.
    pub spring: f64,
    /// Rest position of this spring `[m]`, for a hinge `[rad]`.
    pub rest: f64,
    /// Damping along q, at least 0 `[N s/m]`, for a hinge `[N m s/rad]`.
    pub along_damping: f64,
    /// Stops: beyond these values of q a spring pushes back, with stiffness K for a slider and K span^2/4 for a
    /// hinge.
    pub limits: Option<[f64; 2]>,
}

impl JointLaw {
    /// Creates a bearing with this stiffness `[N/m]` and length `[m]`, without damping, spring and stops.
    #[must_use]
    pub fn new(stiffness: f64, span: f64) -> Self {
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
