//! Structs of bodies, laws and joints.

use palpate_world::{Body, Contact, ContactLaw, Free, Joint, JointKind, JointLaw, Motion, Shape};
use std::borrow::ToOwned;
use std::format;

use super::params::check;
use crate::choice;
use crate::edge::status;
use crate::sized::{self, SizedStruct};
use crate::status::{Refusal, Status};
use crate::world::Pose;

/// A body. palpate_body_params_default() fills it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct BodyParams {
    /// Size of this struct; palpate_body_params_default() sets it.
    pub struct_size: usize,
    /// Initial pose; the position of a moving body is its centre of mass. Default: the origin.
    pub pose: Pose,
    /// Mass, above 0 [kg]. INFINITY, the default: a fixed body, which must not have a velocity.
    pub mass: f64,
    /// Moments of inertia about the centre of mass along the body axes [kg m^2]. All 0, the default: those of a
    /// homogeneous solid of its shape.
    pub inertia: [f64; 3],
    /// Initial velocity of the centre of mass [m/s]. Default: 0.
    pub velocity: [f64; 3],
    /// Initial angular velocity in world axes [rad/s]. Default: 0.
    pub angular_velocity: [f64; 3],
    /// Constant force at the centre of mass, for instance its weight [N]. Default: 0.
    pub force: [f64; 3],
}

// SAFETY: `repr(C)`, a `usize` first, numbers only.
unsafe impl SizedStruct for BodyParams {
    const NAME: &'static str = "palpate_body_params";
}

impl Default for BodyParams {
    fn default() -> Self {
        Self {
            struct_size: size_of::<Self>(),
            pose: Pose {
                position: [0.0; 3],
                orientation: palpate_world::IDENTITY,
            },
            mass: f64::INFINITY,
            inertia: [0.0; 3],
            velocity: [0.0; 3],
            angular_velocity: [0.0; 3],
            force: [0.0; 3],
        }
    }
}

impl BodyParams {
    /// Returns a body with this name and shape. The check of the world validates the other numbers.
    ///
    /// # Errors
    /// Rejects a fixed body with a velocity, which would otherwise be ignored silently.
    pub(super) fn body(&self, name: &str, shape: Shape) -> Result<Body, Refusal<'static>> {
        let motion = if self.mass == f64::INFINITY {
            for (key, value) in [
                ("velocity", self.velocity),
                ("angular_velocity", self.angular_velocity),
            ] {
                if value != [0.0; 3] {
                    return Err(Refusal::Numbers(format!(
                        "body \"{name}\": {key} is {value:?}, but a fixed body (mass INFINITY) has none"
                    )));
                }
            }
            Motion::Fixed
        } else {
            Motion::Free(Free {
                mass: self.mass,
                inertia: (self.inertia != [0.0; 3]).then_some(self.inertia),
                velocity: self.velocity,
                angular_velocity: self.angular_velocity,
                force: self.force,
            })
        };
        let body = Body::new(name.to_owned(), shape, motion);
        let Pose {
            position,
            orientation,
        } = self.pose;
        Ok(body.at(position).turned(orientation))
    }
}

impl From<&Body> for BodyParams {
    fn from(body: &Body) -> Self {
        let pose = Pose {
            position: body.position,
            orientation: body.orientation,
        };
        let fixed = Self {
            pose,
            ..Self::default()
        };
        match &body.motion {
            Motion::Fixed => fixed,
            Motion::Free(free) => Self {
                mass: free.mass,
                inertia: free.inertia.unwrap_or_default(),
                velocity: free.velocity,
                angular_velocity: free.angular_velocity,
                force: free.force,
                ..fixed
            },
        }
    }
}

/// Contact law: normal force and friction of two overlapping surfaces. palpate_contact_law_default() fills it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Law {
    /// Size of this struct; palpate_contact_law_default() sets it.
    pub struct_size: usize,
    /// Stiffness, above 0 [N/m]. It has no default.
    pub stiffness: f64,
    /// Material damping, not below 0 [N s/m]. Default: 0.
    pub damping: f64,
    /// Coefficient of friction, not below 0. Default: 0.
    pub friction: f64,
    /// Stiffness of the friction bristle [N/m]. 0, the default: `stiffness`.
    pub friction_stiffness: f64,
    /// Damping of the bristle [N s/m]. 0, the default: `damping` times `friction_stiffness` over `stiffness`. Below
    /// 0: no damping.
    pub friction_damping: f64,
}

// SAFETY: `repr(C)`, a `usize` first, numbers only.
unsafe impl SizedStruct for Law {
    const NAME: &'static str = "palpate_contact_law";
}

impl Default for Law {
    fn default() -> Self {
        Self {
            struct_size: size_of::<Self>(),
            stiffness: 0.0,
            damping: 0.0,
            friction: 0.0,
            friction_stiffness: 0.0,
            friction_damping: 0.0,
        }
    }
}

impl Law {
    pub(super) fn checked(&self) -> Result<ContactLaw, Refusal<'static>> {
        check(&[
            ("stiffness", self.stiffness, true),
            ("damping", self.damping, false),
            ("friction", self.friction, false),
            ("friction_stiffness", self.friction_stiffness, false),
        ])?;
        if !self.friction_damping.is_finite() {
            return Err(Refusal::Number {
                name: "friction_damping",
                given: self.friction_damping,
                allowed: "finite",
            });
        }
        let numbers = [
            self.stiffness,
            self.damping,
            self.friction,
            self.friction_stiffness,
            self.friction_damping,
        ];
        Ok(law_of(numbers))
    }
}

/// Returns the contact law of stiffness, damping, friction, and stiffness and damping of friction in the C convention:
/// 0 in the last two selects the default, and a negative friction damping selects no damping.
pub(crate) fn law_of(
    [
        stiffness,
        damping,
        friction,
        friction_stiffness,
        friction_damping,
    ]: [f64; 5],
) -> ContactLaw {
    let friction_stiffness = if friction_stiffness == 0.0 {
        stiffness
    } else {
        friction_stiffness
    };
    ContactLaw {
        stiffness,
        damping,
        friction,
        friction_stiffness,
        friction_damping: if friction_damping == 0.0 {
            ContactLaw::usual_friction_damping(stiffness, damping, friction_stiffness)
        } else {
            friction_damping.max(0.0)
        },
    }
}

impl From<&Contact> for Law {
    fn from(contact: &Contact) -> Self {
        let ContactLaw {
            stiffness,
            damping,
            friction,
            friction_stiffness,
            friction_damping,
        } = contact.law;
        Self {
            stiffness,
            damping,
            friction,
            friction_stiffness,
            friction_damping: if friction_damping > 0.0 {
                friction_damping
            } else {
                -1.0
            },
            ..Self::default()
        }
    }
}

/// Degree of freedom of a joint.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bearing {
    /// Rotation about the axis only.
    Hinge = 0,
    /// Translation along the axis only.
    Slider = 1,
}

/// A joint: a bearing made of springs, stiff in all directions except one. palpate_joint_params_default() fills it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct JointParams {
    /// Size of this struct; palpate_joint_params_default() sets it.
    pub struct_size: usize,
    /// A palpate_joint.
    pub kind: u32,
    /// 1: stops at `limits`. 0, the default: no stops.
    pub has_limits: u32,
    /// Centre of the bearing in world axes, at the bodies' poses when the world is created or changed [m].
    pub point: [f64; 3],
    /// Direction of the axis, of any length above 0. Default: z.
    pub axis: [f64; 3],
    /// Stiffness in the constrained directions, above 0 [N/m]. It has no default.
    pub stiffness: f64,
    /// Damping in the constrained directions, not below 0 [N s/m]. Default: 0.
    pub damping: f64,
    /// Length of the bearing, above 0 [m]. It has no default.
    pub span: f64,
    /// Stiffness of a spring along or about the axis, not below 0 [N/m], for a hinge [N m/rad]. Default: 0.
    pub spring: f64,
    /// Rest position of that spring [m], for a hinge [rad]. Default: 0, the initial pose.
    pub rest: f64,
    /// Damping along or about the axis, not below 0 [N s/m], for a hinge [N m s/rad]. Default: 0.
    pub along_damping: f64,
    /// Positions of the stops [m], for a hinge [rad].
    pub limits: [f64; 2],
}

// SAFETY: `repr(C)`, a `usize` first, numbers only.
unsafe impl SizedStruct for JointParams {
    const NAME: &'static str = "palpate_joint_params";
}

impl Default for JointParams {
    fn default() -> Self {
        Self {
            struct_size: size_of::<Self>(),
            kind: Bearing::Hinge as u32,
            has_limits: 0,
            point: [0.0; 3],
            axis: [0.0, 0.0, 1.0],
            stiffness: 0.0,
            damping: 0.0,
            span: 0.0,
            spring: 0.0,
            rest: 0.0,
            along_damping: 0.0,
            limits: [0.0; 2],
        }
    }
}

impl JointParams {
    /// Returns the joint of a body with another one or the world. The check of the world validates its numbers.
    pub(super) fn joint(
        &self,
        body: &str,
        against: Option<&str>,
    ) -> Result<Joint, Refusal<'static>> {
        let kind = match self.kind {
            kind if kind == Bearing::Hinge as u32 => JointKind::Hinge,
            kind if kind == Bearing::Slider as u32 => JointKind::Slider,
            given => {
                return Err(Refusal::Choice {
                    name: "kind",
                    given,
                    allowed: "PALPATE_JOINT_HINGE or PALPATE_JOINT_SLIDER",
                });
            }
        };
        let has_limits = choice::switch("has_limits", self.has_limits)?;
        let length = self.axis.iter().map(|x| x * x).sum::<f64>().sqrt();
        let is_direction = length > 0.0 && length.is_finite();
        Ok(Joint {
            body: body.to_owned(),
            against: against.map(ToOwned::to_owned),
            kind,
            point: self.point,
            axis: if is_direction {
                self.axis.map(|x| x / length)
            } else {
                self.axis
            },
            law: JointLaw {
                stiffness: self.stiffness,
                damping: self.damping,
                span: self.span,
                spring: self.spring,
                rest: self.rest,
                along_damping: self.along_damping,
                limits: has_limits.then_some(self.limits),
            },
        })
    }
}

/// Fills body parameters with the defaults. `struct_size` is sizeof(palpate_body_params).
///
/// # Safety
/// `params` is NULL, or `struct_size` bytes can be written there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_body_params_init(
    params: *mut BodyParams,
    struct_size: usize,
) -> Status {
    // SAFETY: guaranteed by the caller.
    status(|| unsafe { sized::fill(params, struct_size, BodyParams::default()) })
}

/// Fills a contact law with the defaults. `struct_size` is sizeof(palpate_contact_law).
///
/// # Safety
/// `law` is NULL, or `struct_size` bytes can be written there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_law_init(law: *mut Law, struct_size: usize) -> Status {
    // SAFETY: guaranteed by the caller.
    status(|| unsafe { sized::fill(law, struct_size, Law::default()) })
}

/// Fills joint parameters with the defaults. `struct_size` is sizeof(palpate_joint_params).
///
/// # Safety
/// `params` is NULL, or `struct_size` bytes can be written there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_joint_params_init(
    params: *mut JointParams,
    struct_size: usize,
) -> Status {
    // SAFETY: guaranteed by the caller.
    status(|| unsafe { sized::fill(params, struct_size, JointParams::default()) })
}
