//! The structs of bodies, laws and joints.

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
    /// Where it is at the start, and how it is turned: of a body that moves, its centre of mass. Default: the origin.
    pub pose: Pose,
    /// Mass, above 0 [kg]. INFINITY, the default: a fixed body, which takes no force; one with a velocity is refused.
    pub mass: f64,
    /// Moments of inertia about the centre of mass along its own axes [kg m^2]. All 0, the default: of its shape, filled evenly.
    pub inertia: [f64; 3],
    /// Velocity of the centre of mass at the start [m/s]. Default: 0.
    pub velocity: [f64; 3],
    /// Angular velocity at the start along the world's axes [rad/s]. Default: 0.
    pub angular_velocity: [f64; 3],
    /// A constant force at the centre of mass, its weight for instance [N]. Default: 0.
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
                orientation: palpate_world::NOT_TURNED,
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
    /// A body of that name and shape. The check of a world finds what else is wrong with its numbers.
    ///
    /// # Errors
    /// A fixed body with a velocity: the body would stand still, and no message would say so.
    pub(super) fn body(&self, name: &str, shape: Shape) -> Result<Body, Refusal<'static>> {
        let motion = if self.mass == f64::INFINITY {
            for (key, value) in [
                ("velocity", self.velocity),
                ("angular_velocity", self.angular_velocity),
            ] {
                if value != [0.0; 3] {
                    return Err(Refusal::Numbers(format!(
                        "body \"{name}\": {key} is {value:?}, and a fixed body (mass INFINITY) has none"
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

/// The law of a contact: how two surfaces push each other where they overlap, and rub. palpate_contact_law_default() fills it.
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
    /// Stiffness of the bristle by which they rub [N/m]. 0, the default: `stiffness`.
    pub friction_stiffness: f64,
    /// Damping of the bristle [N s/m]. 0, the default: `damping` times `friction_stiffness` over `stiffness`. Below 0: none.
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

/// The law of stiffness, damping, friction, and stiffness and damping of friction, as C gives them: a 0 of the last two is their
/// default; friction has no negative damping.
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

/// What a joint lets a body do.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bearing {
    /// Turn about the axis, and nothing else.
    Hinge = 0,
    /// Slide along the axis, and nothing else.
    Slider = 1,
}

/// A joint: a bearing of springs, stiff in all directions but one. palpate_joint_params_default() fills it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct JointParams {
    /// Size of this struct; palpate_joint_params_default() sets it.
    pub struct_size: usize,
    /// One of palpate_joint.
    pub kind: u32,
    /// 1: it has stops at `limits`. 0, the default: none.
    pub has_limits: u32,
    /// The middle of the bearing, in world axes as the bodies stand when a world is made or changed [m].
    pub point: [f64; 3],
    /// Along its axis, of any length above 0. Default: z.
    pub axis: [f64; 3],
    /// Stiffness against what it does not let pass, above 0 [N/m]. It has no default.
    pub stiffness: f64,
    /// The same of damping, not below 0 [N s/m]. Default: 0.
    pub damping: f64,
    /// Length of the bearing, above 0 [m]. It has no default.
    pub span: f64,
    /// Stiffness of a spring along or about the axis, not below 0 [N/m], of a hinge [N m/rad]. Default: 0.
    pub spring: f64,
    /// Where that spring is relaxed [m], of a hinge [rad]. Default: 0, as the bodies stand.
    pub rest: f64,
    /// Damping along or about the axis, not below 0 [N s/m], of a hinge [N m s/rad]. Default: 0.
    pub along_damping: f64,
    /// Where its stops are [m], of a hinge [rad].
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
    /// The joint of a body against another one, or the world. What is wrong with its numbers says the check of a world.
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

/// Fills parameters of a body with the defaults. `struct_size` is sizeof(palpate_body_params).
///
/// # Safety
/// `params` is NULL, or `struct_size` bytes can be written there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_body_params_init(
    params: *mut BodyParams,
    struct_size: usize,
) -> Status {
    // SAFETY: as the caller says.
    status(|| unsafe { sized::fill(params, struct_size, BodyParams::default()) })
}

/// Fills the law of a contact with the defaults. `struct_size` is sizeof(palpate_contact_law).
///
/// # Safety
/// `law` is NULL, or `struct_size` bytes can be written there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_law_init(law: *mut Law, struct_size: usize) -> Status {
    // SAFETY: as the caller says.
    status(|| unsafe { sized::fill(law, struct_size, Law::default()) })
}

/// Fills parameters of a joint with the defaults. `struct_size` is sizeof(palpate_joint_params).
///
/// # Safety
/// `params` is NULL, or `struct_size` bytes can be written there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_joint_params_init(
    params: *mut JointParams,
    struct_size: usize,
) -> Status {
    // SAFETY: as the caller says.
    status(|| unsafe { sized::fill(params, struct_size, JointParams::default()) })
}
