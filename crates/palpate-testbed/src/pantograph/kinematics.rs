//! Forward and inverse kinematics of the end-point.
//!
//! Motor 1 is at the origin, motor 2 at (d, 0). Angles are counter-clockwise from +x `[rad]`, x points right, y away
//! from the base:
//!
//! ```text
//! A = l (cos θ1, sin θ1)     B = (d, 0) + l (cos θ2, sin θ2)     |P − A| = |P − B| = L
//! ```
//!
//! All quantities of the distal links use their directions (P − A)/L and (P − B)/L instead of an arccosine of their
//! angle. An arccosine loses the side of the elbow on which P lies, and with it the sign of an entry of the Jacobian.

use thiserror::Error;

use super::parameter::PantographParameter as Parameter;
use crate::InvalidParameter;
use crate::error::positive;

/// Below this |sin| of the angle between the distal links a pose counts as singular.
pub const SINGULAR_SINE: f64 = 1e-6;

/// On which side of the line from elbow 1 to elbow 2 the end-point lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Assembly {
    /// To the left of the way from A to B: away from the base while A lies to the left of B.
    #[default]
    Far,
    /// To the right of that way.
    Near,
}

impl Assembly {
    fn sign(self) -> f64 {
        match self {
            Self::Far => 1.0,
            Self::Near => -1.0,
        }
    }
}

/// Origin of x. y is zero on the line through the motors in both cases.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Origin {
    /// On the axis of motor 1.
    #[default]
    Motor1,
    /// Half-way between the motors.
    Centre,
}

/// Seen from the motor towards the end-point, the side on which the elbow lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Elbow {
    /// Counter-clockwise of the line from the motor to the end-point.
    Left,
    /// Clockwise of it.
    Right,
}

/// Both elbows away from each other: the usual way to build the device.
pub const ELBOWS_OUT: [Elbow; 2] = [Elbow::Left, Elbow::Right];

/// Reason why a pose does not exist.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum NoPose {
    /// The links do not reach: |h| > 2L forwards, or a point outside an arm's ring backwards.
    #[error("the links do not reach this pose")]
    Unreachable,
    /// The distal links are parallel (|h| = 2L, or A = B), so the motors do not determine the
    /// motion of the end-point; or the end-point lies on a motor's axis.
    #[error("the pose is singular")]
    Singular,
    /// The point is reached with these elbows only in the other assembly.
    #[error("these elbows reach the point only in the other assembly")]
    OtherAssembly,
}

/// Lengths of a symmetric five-bar, and how it is put together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Geometry {
    /// Length l of the links on the motors `[m]`.
    pub proximal: f64,
    /// Length L of the links that meet in the end-point `[m]`.
    pub distal: f64,
    /// Distance d from motor 1 to motor 2 along +x `[m]`; 0 stacks them on one axis.
    pub base: f64,
    /// Side of the end-point.
    pub assembly: Assembly,
    /// Zero of x.
    pub origin: Origin,
}

/// A pose that exists: angles, directions of the four links, end-point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ArmPose {
    /// Motor angles θ1, θ2 `[rad]`.
    pub angles: [f64; 2],
    /// Unit vectors along the proximal links, from the motor to the elbow.
    pub proximal: [[f64; 2]; 2],
    /// Unit vectors along the distal links, from the elbow to the end-point.
    pub distal: [[f64; 2]; 2],
    /// End-point (x, y) `[m]`, in the geometry's own origin.
    pub position: [f64; 2],
    /// Sine of the angle from distal link 1 to distal link 2; its sign is the assembly's.
    pub sine: f64,
    /// Length l `[m]`, for the derivatives.
    length: f64,
    /// l / L.
    ratio: f64,
}

impl Geometry {
    /// The usual assembly with the origin on motor 1; lengths in `[m]`.
    ///
    /// # Errors
    ///
    /// A link's length is not finite and positive, or `base` is not finite and at least 0.
    pub fn new(proximal: f64, distal: f64, base: f64) -> Result<Self, InvalidParameter<Parameter>> {
        Self {
            proximal,
            distal,
            base,
            assembly: Assembly::Far,
            origin: Origin::Motor1,
        }
        .checked()
    }

    /// Returns the same geometry if its numbers are allowed.
    ///
    /// # Errors
    ///
    /// As for [`Geometry::new`].
    pub fn checked(self) -> Result<Self, InvalidParameter<Parameter>> {
        positive(Parameter::Proximal, self.proximal, "finite and above 0 m")?;
        positive(Parameter::Distal, self.distal, "finite and above 0 m")?;
        let base = self.base;
        InvalidParameter::unless(
            base.is_finite() && base >= 0.0,
            Parameter::Base,
            base,
            "finite and at least 0 m",
        )?;
        Ok(self)
    }

    fn x_offset(&self) -> f64 {
        match self.origin {
            Origin::Motor1 => 0.0,
            Origin::Centre => -0.5 * self.base,
        }
    }

    /// The pose for motor angles `[rad]`.
    ///
    /// # Errors
    ///
    /// [`NoPose::Unreachable`] if the elbows are further apart than 2L or an angle is not finite,
    /// [`NoPose::Singular`] if the distal links are parallel.
    pub fn forward(&self, angles: [f64; 2]) -> Result<ArmPose, NoPose> {
        let proximal = angles.map(|angle| {
            let (sin, cos) = angle.sin_cos();
            [cos, sin]
        });
        let l = self.proximal;
        let a = scaled(l, proximal[0]);
        let b = [self.base + l * proximal[1][0], l * proximal[1][1]];
        let h = [b[0] - a[0], b[1] - a[1]];
        let apart = h[0].hypot(h[1]);
        let height_squared = self.distal * self.distal - 0.25 * apart * apart;
        if height_squared.is_nan() || height_squared < 0.0 {
            return Err(NoPose::Unreachable);
        }
        if apart < SINGULAR_SINE * self.distal {
            return Err(NoPose::Singular);
        }
        let side = self.assembly.sign() * height_squared.sqrt() / apart;
        let to_p = [0.5 * h[0] - side * h[1], 0.5 * h[1] + side * h[0]];
        let distal = [
            scaled(1.0 / self.distal, to_p),
            scaled(1.0 / self.distal, [to_p[0] - h[0], to_p[1] - h[1]]),
        ];
        let sine = cross(distal[0], distal[1]);
        if sine.abs() < SINGULAR_SINE {
            return Err(NoPose::Singular);
        }
        Ok(ArmPose {
            angles,
            proximal,
            distal,
            position: [a[0] + to_p[0] + self.x_offset(), a[1] + to_p[1]],
            sine,
            length: l,
            ratio: l / self.distal,
        })
    }

    /// The motor angles in (−π, π\] `[rad]` that bring the end-point to `position` `[m]` with these
    /// elbows.
    ///
    /// # Errors
    ///
    /// The point is out of reach, on a motor's axis or in a singular pose, or these elbows reach it
    /// only in the other [`Assembly`].
    pub fn inverse(&self, position: [f64; 2], elbows: [Elbow; 2]) -> Result<[f64; 2], NoPose> {
        let x = position[0] - self.x_offset();
        let y = position[1];
        let first = self.arm([x, y], elbows[0])?;
        let second = self.arm([x - self.base, y], elbows[1])?;
        let (l, angles) = (self.proximal, [first, second]);
        let from_elbow = |angle: f64, motor: f64| {
            let (sin, cos) = angle.sin_cos();
            [
                (x - motor - l * cos) / self.distal,
                (y - l * sin) / self.distal,
            ]
        };
        let sine = cross(from_elbow(first, 0.0), from_elbow(second, self.base));
        if sine.abs() < SINGULAR_SINE {
            Err(NoPose::Singular)
        } else if sine * self.assembly.sign() < 0.0 {
            Err(NoPose::OtherAssembly)
        } else {
            Ok(angles)
        }
    }

    /// The angles for each of the four pairs of elbows, in the order left-left, left-right,
    /// right-left, right-right.
    pub fn inverse_all(&self, position: [f64; 2]) -> [Result<[f64; 2], NoPose>; 4] {
        use Elbow::{Left, Right};
        [[Left, Left], [Left, Right], [Right, Left], [Right, Right]]
            .map(|elbows| self.inverse(position, elbows))
    }

    /// The angle of one arm whose motor is at the origin.
    fn arm(&self, p: [f64; 2], elbow: Elbow) -> Result<f64, NoPose> {
        let (l, distal) = (self.proximal, self.distal);
        let reach = p[0].hypot(p[1]);
        if reach < SINGULAR_SINE * distal {
            return Err(NoPose::Singular);
        }
        // Law of cosines at the motor.
        let cosine = (l * l + reach * reach - distal * distal) / (2.0 * l * reach);
        if cosine.is_nan() || cosine.abs() > 1.0 {
            return Err(NoPose::Unreachable);
        }
        let opening = cosine.acos();
        let bearing = p[1].atan2(p[0]);
        let angle = match elbow {
            Elbow::Left => bearing + opening,
            Elbow::Right => bearing - opening,
        };
        Ok(wrapped(angle))
    }
}

impl ArmPose {
    /// Directions of the distal links `[rad]`, by atan2(P − elbow).
    #[must_use]
    pub fn distal_angles(&self) -> [f64; 2] {
        self.distal.map(|u| u[1].atan2(u[0]))
    }

    /// J = ∂P/∂θ `[m/rad]`; row 0 is x, column i is motor i.
    ///
    /// From |P − A| = |P − B| = L: the end-point moves along a distal link only as fast as that
    /// link's elbow does, u_i · P′ = u_i · l t_i θ_i′. Two such equations give P′ in every pose
    /// in which the links are not parallel.
    #[must_use]
    #[inline]
    pub fn jacobian(&self) -> [[f64; 2]; 2] {
        let [u1, u2] = self.distal;
        let first = self.length * cross(self.proximal[0], u1) / self.sine;
        let second = self.length * cross(self.proximal[1], u2) / self.sine;
        [
            [first * u2[1], -second * u1[1]],
            [-first * u2[0], second * u1[0]],
        ]
    }

    /// W = ∂φ/∂θ: how the directions φ of the distal links follow the motors.
    #[must_use]
    #[inline]
    pub fn distal_rates(&self) -> [[f64; 2]; 2] {
        let scale = self.ratio / self.sine;
        let row = |u: [f64; 2]| {
            [
                -scale * cross(self.proximal[0], u),
                scale * cross(self.proximal[1], u),
            ]
        };
        // The other link closes the loop, so each row has the other link's direction.
        [row(self.distal[1]), row(self.distal[0])]
    }

    /// On which side each elbow lies.
    #[must_use]
    pub fn elbows(&self) -> [Elbow; 2] {
        // The elbow is on the left of motor → P where the arm bends to the right at the elbow.
        [0, 1].map(|i| {
            if cross(self.proximal[i], self.distal[i]) <= 0.0 {
                Elbow::Left
            } else {
                Elbow::Right
            }
        })
    }

    /// Motor torques JᵀF `[N m]` that balance −F `[N]` at the end-point.
    #[must_use]
    #[inline]
    pub fn torques(&self, force: [f64; 2]) -> [f64; 2] {
        let j = self.jacobian();
        [0, 1].map(|i| j[0][i] * force[0] + j[1][i] * force[1])
    }
}

/// Returns the same direction in (−π, π\].
fn wrapped(angle: f64) -> f64 {
    let (sin, cos) = angle.sin_cos();
    sin.atan2(cos)
}

#[inline]
pub(super) fn scaled(factor: f64, v: [f64; 2]) -> [f64; 2] {
    [factor * v[0], factor * v[1]]
}

#[inline]
pub(super) fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// Sine of the angle from `a` to `b`, for unit vectors.
#[inline]
pub(super) fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}
