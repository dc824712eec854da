//! Scene of an evaluation: devices with their hands and tools, bodies, and the laws of their contacts.

use std::sync::Arc;

use super::force_field::ForceField;
use super::hand::{Drivetrain, WorldHand};
use super::hull::Hull;
use super::joints::WorldJoint;
use super::mass_table::MassTable;
use super::mesh::TriangleMesh;
use super::turning::Turning;
use super::vector::Vec3;
use crate::InvalidParameter;
use crate::error::{finite, positive};

/// Three numbers along the axes of the world's frame, for instance a position `[m]` or a force `[N]`.
pub type Vector = [f64; 3];

/// A device with three or six axes, its hand, and its tool.
///
/// Along each of its axes m x″ = f + F − k (x − x_rest) − b x′ + Σ tremor, with the contact force f on the
/// tool. Its axes are those of the world, or three of its own, along which its mobility is diagonal.
#[derive(Debug, Clone, PartialEq)]
pub struct WorldDevice {
    /// Name, for messages.
    pub name: String,
    /// The device's axes: unit vectors at right angles, along the world's axes; `None` for the world's own.
    pub own_axes: Option<[Vector; 3]>,
    /// Moving mass m along each axis, above 0 `[kg]`; infinite along an axis that the device lacks. The mechanism holds
    /// the device there and no motor gives a force along that axis, so the force is not evaluated.
    pub mass: Vector,
    /// Mass matrix of a linkage as a function of the tool's position; `None` for a constant mass. It determines the
    /// motion of the device; [`mass`](Self::mass), its value along the axes at the start, determines the weights of the
    /// evaluation.
    pub mass_table: Option<Arc<MassTable>>,
    /// Position of the tool's centre, that of mass, at t = 0 `[m]`.
    pub position: Vector,
    /// Velocity at t = 0 `[m/s]`.
    pub velocity: Vector,
    /// The tool, about the centre of mass.
    pub tool: Tool,
    /// Rotation of a six-axis device; `None` for a three-axis one, whose tool keeps the axes of the world.
    pub turning: Option<Turning>,
    /// The hand.
    pub hand: WorldHand,
    /// Quantum of the position sensor along each of the device's axes, 0 for a perfect one `[m]`.
    pub quantum: Vector,
    /// Friction, motors and noise of the sensors.
    pub drivetrain: Drivetrain,
}

/// The shape of a tool.
#[derive(Debug, Clone, PartialEq)]
pub enum Tool {
    /// A sphere, of radius 0 for a point; a box; or a capsule.
    Solid(Shape),
    /// Several spheres, each of which touches by the whole law of a pair.
    Spheres(Vec<SphereAt>),
}

impl Tool {
    /// A sphere of that radius `[m]`, 0 for a point.
    #[must_use]
    pub fn sphere(radius: f64) -> Self {
        Self::Solid(Shape::Sphere { radius })
    }
}

/// A sphere of a tool that has several.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SphereAt {
    /// Its centre in the tool's axes `[m]`.
    pub centre: Vector,
    /// Its radius, 0 for a point `[m]`.
    pub radius: f64,
}

/// A rigid body.
#[derive(Debug, Clone, PartialEq)]
pub struct WorldBody {
    /// Name, for messages.
    pub name: String,
    /// Shape in the body's own axes, about its centre of mass.
    pub shape: Shape,
    /// Centre of mass at t = 0 `[m]`.
    pub position: Vector,
    /// Unit quaternion `[w, x, y, z]` from the body's axes to the world's at t = 0.
    pub orientation: [f64; 4],
    /// Motion; `None` if it is fixed.
    pub motion: Option<FreeMotion>,
}

/// Mass, start and force of a body that moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FreeMotion {
    /// Mass, finite and above 0 `[kg]`.
    pub mass: f64,
    /// Moments of inertia about the centre of mass along the body's axes, finite and above 0 `[kg m²]`.
    pub inertia: Vector,
    /// Velocity of the centre of mass at t = 0 `[m/s]`.
    pub velocity: Vector,
    /// Angular velocity at t = 0, in world axes `[rad/s]`.
    pub angular_velocity: Vector,
    /// Constant force at the centre of mass `[N]`.
    pub force: Vector,
}

impl FreeMotion {
    /// A body of that mass `[kg]` at rest, whose `shape` it fills evenly. No force but those of contacts pulls
    /// at it.
    #[must_use]
    pub fn new(shape: &Shape, mass: f64) -> Self {
        Self {
            mass,
            inertia: shape.inertia(mass),
            velocity: [0.0; 3],
            angular_velocity: [0.0; 3],
            force: [0.0; 3],
        }
    }

    /// Returns the same body under a constant force `[N]`.
    #[must_use]
    pub fn pulled_by(self, force: Vector) -> Self {
        Self { force, ..self }
    }
}

/// The shape of a body.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// All points within a radius, above 0 `[m]`.
    Sphere {
        /// Radius `[m]`.
        radius: f64,
    },
    /// All points x with normal · x ≤ offset, of a fixed body.
    HalfSpace {
        /// Unit vector out of the solid, in the body's axes.
        normal: Vector,
        /// Position of the surface along the normal, from the body's position `[m]`.
        offset: f64,
    },
    /// A block along the body's axes.
    Box {
        /// Half of its length along each axis, above 0 `[m]`.
        half_extents: Vector,
    },
    /// All points within a radius of a segment along the body's z axis.
    Capsule {
        /// Radius, above 0 `[m]`.
        radius: f64,
        /// Half of the segment's length, above 0 `[m]`.
        half_length: f64,
    },
    /// A cylinder along the body's z axis.
    Cylinder {
        /// Radius, above 0 `[m]`.
        radius: f64,
        /// Half of its length, above 0 `[m]`.
        half_length: f64,
    },
    /// A surface of triangles in the body's axes.
    Mesh(Arc<TriangleMesh>),
    /// A convex solid in the body's axes.
    Hull(Arc<Hull>),
}

impl Shape {
    /// Moments of inertia `[kg m²]` about the centre along the body's axes, if `mass` `[kg]` fills it evenly;
    /// infinite for a half-space, which has to be fixed, and for an open mesh.
    #[must_use]
    pub fn inertia(&self, mass: f64) -> Vector {
        match *self {
            Self::Sphere { radius } => [0.4 * mass * radius * radius; 3],
            Self::HalfSpace { .. } => [f64::INFINITY; 3],
            Self::Mesh(ref mesh) => mesh.inertia(mass),
            Self::Hull(ref hull) => hull.mesh().inertia(mass),
            Self::Box {
                half_extents: [a, b, c],
            } => [b * b + c * c, a * a + c * c, a * a + b * b].map(|sum| mass * sum / 3.0),
            Self::Cylinder {
                radius,
                half_length,
            } => {
                let across = mass * (radius * radius / 4.0 + half_length * half_length / 3.0);
                [across, across, 0.5 * mass * radius * radius]
            }
            Self::Capsule {
                radius: r,
                half_length: h,
            } => {
                // Volumes over π r²: the cylinder 2 h, both ends together 4 r/3.
                let cylinder = mass * 2.0 * h / (2.0 * h + 4.0 * r / 3.0);
                let ends = mass - cylinder;
                let across = cylinder * (r * r / 4.0 + h * h / 3.0)
                    + ends * (0.4 * r * r + h * h + 0.75 * h * r);
                [across, across, 0.5 * cylinder * r * r + 0.4 * ends * r * r]
            }
        }
    }
}

/// The law of a contact with penetration p and its rate p′: N = max(0, K p + B p′) while p > 0; friction is a
/// bristle of stiffness k_t whose deflection z is cut to μ N/k_t, and its force is k_t z + B_t v_t, cut to μ N.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactLaw {
    /// K, above 0 `[N/m]`.
    pub stiffness: f64,
    /// B, at least 0 `[N s/m]`.
    pub damping: f64,
    /// μ, at least 0.
    pub friction: f64,
    /// k_t, above 0 `[N/m]`.
    pub friction_stiffness: f64,
    /// B_t, at least 0 `[N s/m]`.
    pub friction_damping: f64,
}

impl ContactLaw {
    /// A spring of that stiffness `[N/m]` without damping and friction.
    #[must_use]
    pub fn spring(stiffness: f64) -> Self {
        Self {
            stiffness,
            damping: 0.0,
            friction: 0.0,
            friction_stiffness: stiffness,
            friction_damping: 0.0,
        }
    }

    /// Returns the same law with damping `[N s/m]`.
    #[must_use]
    pub fn damped(self, damping: f64) -> Self {
        Self { damping, ..self }
    }

    /// Returns the same law with friction of a coefficient and a bristle's stiffness `[N/m]`.
    #[must_use]
    pub fn rough(self, friction: f64, friction_stiffness: f64) -> Self {
        Self {
            friction,
            friction_stiffness,
            ..self
        }
    }
}

/// One side of a contact, by its number from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Member {
    /// The tool of a device.
    Device(usize),
    /// A body.
    Body(usize),
}

/// Two members in contact, and their law. The pair is unordered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    /// The two.
    pub between: [Member; 2],
    /// The law.
    pub law: ContactLaw,
}

/// Devices, bodies and the pairs that touch; a pair that is not listed does not.
///
/// All of it is in world axes and SI units. Forces on a tool are what its device gives to the hand.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct WorldScene {
    /// The devices.
    pub devices: Vec<WorldDevice>,
    /// The bodies.
    pub bodies: Vec<WorldBody>,
    /// The pairs.
    pub pairs: Vec<Pair>,
    /// The joints.
    pub joints: Vec<WorldJoint>,
    /// The force fields.
    pub fields: Vec<ForceField>,
}

/// A parameter of a scene outside its range; its name contains the device, body or pair, for instance
/// `bodies[1].motion.mass`.
pub type InvalidScene = InvalidParameter<String>;

impl WorldScene {
    /// Checks every number; which pairs can touch is checked with the pairs.
    ///
    /// # Errors
    ///
    /// The first parameter outside its range.
    pub(super) fn check(&self) -> Result<(), InvalidScene> {
        for (number, device) in self.devices.iter().enumerate() {
            device.check(&format!("devices[{number}]"))?;
        }
        for (number, body) in self.bodies.iter().enumerate() {
            body.check(&format!("bodies[{number}]"))?;
        }
        for (number, pair) in self.pairs.iter().enumerate() {
            pair.check(&format!("pairs[{number}]"), self)?;
        }
        for (number, joint) in self.joints.iter().enumerate() {
            joint.check(&format!("joints[{number}]"), self.bodies.len())?;
        }
        for (number, field) in self.fields.iter().enumerate() {
            field.check(&format!("fields[{number}]"), self.devices.len())?;
        }
        Ok(())
    }
}

const NOT_NEGATIVE: &str = "finite and at least 0";
pub(super) const ABOVE_ZERO: &str = "finite and above 0";
/// Tolerance on the length of a unit vector.
const LENGTH_TOLERANCE: f64 = 1e-6;

pub(super) fn all_finite(name: &str, values: &[f64]) -> Result<(), InvalidScene> {
    values
        .iter()
        .try_for_each(|value| finite(name.to_owned(), *value, "finite").map(|_| ()))
}

pub(super) fn above_zero(name: &str, values: &[f64]) -> Result<(), InvalidScene> {
    values
        .iter()
        .try_for_each(|value| positive(name.to_owned(), *value, ABOVE_ZERO).map(|_| ()))
}

pub(super) fn not_negative(name: &str, values: &[f64]) -> Result<(), InvalidScene> {
    values.iter().try_for_each(|&value| {
        let holds = value.is_finite() && value >= 0.0;
        InvalidParameter::unless(holds, name.to_owned(), value, NOT_NEGATIVE).map(|_| ())
    })
}

pub(super) fn unit_length(name: &str, values: &[f64]) -> Result<(), InvalidScene> {
    let length = values.iter().map(|value| value * value).sum::<f64>().sqrt();
    let holds = (length - 1.0).abs() < LENGTH_TOLERANCE;
    InvalidParameter::unless(holds, name.to_owned(), length, "a vector of length 1").map(|_| ())
}

/// Tolerance on the length and perpendicularity of a device's axes.
const NOT_SQUARE: f64 = 1e-9;

impl WorldDevice {
    /// Whether a friction acts on the device.
    pub(super) fn has_friction(&self) -> bool {
        self.drivetrain.viscous_friction > 0.0 || self.drivetrain.coulomb_friction > 0.0
    }

    /// Whether the device has this axis.
    pub(super) fn moves_along(&self, axis: usize) -> bool {
        self.mass[axis].is_finite()
    }

    /// A vector of the world along the device's axes.
    pub(super) fn own(&self, vector: Vec3) -> Vec3 {
        self.own_axes
            .map_or(vector, |axes| Vec3(axes.map(|axis| Vec3(axis).dot(vector))))
    }

    /// A vector along the device's axes in the world.
    pub(super) fn out(&self, own: Vec3) -> Vec3 {
        self.own_axes.map_or(own, |axes| {
            let parts = axes.iter().zip(own.0);
            parts.fold(Vec3::ZERO, |sum, (axis, part)| sum + Vec3(*axis) * part)
        })
    }

    /// Returns the components of a force along the device's available axes.
    pub(super) fn along_its_axes(&self, force: Vec3) -> Vec3 {
        let own = self.own(force);
        Vec3(std::array::from_fn(|axis| {
            if self.moves_along(axis) {
                own.0[axis]
            } else {
                0.0
            }
        }))
    }

    fn check(&self, name: &str) -> Result<(), InvalidScene> {
        if let Some(axes) = &self.own_axes {
            let apart = |of: usize, with: usize| Vec3(axes[of]).dot(Vec3(axes[with]));
            let off = |(of, with): (usize, usize)| {
                let expected = if of == with { 1.0 } else { 0.0 };
                (apart(of, with) - expected).abs()
            };
            let pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
            let most = pairs
                .map(off)
                .into_iter()
                .fold(0.0, |a: f64, b| if b > a || b.is_nan() { b } else { a });
            let allowed = "unit vectors at right angles, to 1e-9";
            InvalidParameter::unless(
                most <= NOT_SQUARE,
                format!("{name}.own_axes"),
                most,
                allowed,
            )?;
        }
        let velocity = self.own(Vec3(self.velocity));
        let speed = velocity.norm();
        for (mass, velocity) in self.mass.iter().zip(velocity.0) {
            let allowed = "above 0, or infinite along an axis that the device lacks";
            InvalidParameter::unless(*mass > 0.0, format!("{name}.mass"), *mass, allowed)?;
            let rests = mass.is_finite() || velocity.abs() <= NOT_SQUARE * speed;
            let allowed = "0 along an axis that the device lacks";
            InvalidParameter::unless(rests, format!("{name}.velocity"), velocity, allowed)?;
        }
        let has_one = self.mass.iter().any(|mass| mass.is_finite());
        let allowed = "finite along at least one axis";
        InvalidParameter::unless(has_one, format!("{name}.mass"), self.mass[0], allowed)?;
        all_finite(&format!("{name}.position"), &self.position)?;
        all_finite(&format!("{name}.velocity"), &self.velocity)?;
        let tool = format!("{name}.tool");
        match &self.tool {
            Tool::Solid(Shape::Sphere { radius }) => not_negative(&tool, &[*radius])?,
            Tool::Solid(Shape::Box { half_extents }) => above_zero(&tool, half_extents)?,
            Tool::Solid(
                Shape::Capsule {
                    radius,
                    half_length,
                }
                | Shape::Cylinder {
                    radius,
                    half_length,
                },
            ) => above_zero(&tool, &[*radius, *half_length])?,
            Tool::Solid(Shape::Mesh(mesh)) if mesh.points().is_some() => {}
            Tool::Solid(_) => {
                let allowed =
                    "a sphere, a box, a capsule, a cylinder, a mesh with points or several spheres";
                InvalidParameter::unless(false, tool, f64::NAN, allowed)?;
            }
            Tool::Spheres(spheres) => {
                let count = spheres.len() as f64;
                InvalidParameter::unless(count > 0.0, tool.clone(), count, "at least one sphere")?;
                for sphere in spheres {
                    all_finite(&tool, &sphere.centre)?;
                    not_negative(&tool, &[sphere.radius])?;
                }
            }
        }
        if let Some(turning) = &self.turning {
            turning.check(&format!("{name}.turning"))?;
        }
        not_negative(&format!("{name}.quantum"), &self.quantum)?;
        let hand = &self.hand;
        all_finite(&format!("{name}.hand.force"), &hand.force)?;
        not_negative(&format!("{name}.hand.stiffness"), &[hand.stiffness])?;
        not_negative(&format!("{name}.hand.damping"), &[hand.damping])?;
        all_finite(&format!("{name}.hand.rest"), &hand.rest)?;
        for sine in hand.tremor.iter().flatten() {
            let name = format!("{name}.hand.tremor");
            all_finite(&name, &[sine.amplitude, sine.phase])?;
            above_zero(&name, &[sine.frequency_hz])?;
        }
        self.check_intention(name)
    }
}

impl WorldBody {
    fn check(&self, name: &str) -> Result<(), InvalidScene> {
        let shape = format!("{name}.shape");
        match self.shape {
            Shape::Sphere { radius } => above_zero(&shape, &[radius])?,
            Shape::Mesh(_) | Shape::Hull(_) => {}
            Shape::HalfSpace { normal, offset } => {
                unit_length(&shape, &normal)?;
                all_finite(&shape, &[offset])?;
            }
            Shape::Box { half_extents } => above_zero(&shape, &half_extents)?,
            Shape::Capsule {
                radius,
                half_length,
            }
            | Shape::Cylinder {
                radius,
                half_length,
            } => above_zero(&shape, &[radius, half_length])?,
        }
        all_finite(&format!("{name}.position"), &self.position)?;
        unit_length(&format!("{name}.orientation"), &self.orientation)?;
        let Some(motion) = &self.motion else {
            return Ok(());
        };
        InvalidParameter::unless(
            !matches!(self.shape, Shape::HalfSpace { .. }),
            format!("{name}.motion"),
            motion.mass,
            "none, because a half-space is fixed",
        )?;
        above_zero(&format!("{name}.motion.mass"), &[motion.mass])?;
        above_zero(&format!("{name}.motion.inertia"), &motion.inertia)?;
        all_finite(&format!("{name}.motion.velocity"), &motion.velocity)?;
        let turning = format!("{name}.motion.angular_velocity");
        all_finite(&turning, &motion.angular_velocity)?;
        all_finite(&format!("{name}.motion.force"), &motion.force)
    }
}

impl Pair {
    fn check(&self, name: &str, scene: &WorldScene) -> Result<(), InvalidScene> {
        for member in self.between {
            let (number, count) = match member {
                Member::Device(number) => (number, scene.devices.len()),
                Member::Body(number) => (number, scene.bodies.len()),
            };
            InvalidParameter::unless(
                number < count,
                format!("{name}.between"),
                number as f64,
                "the number of a device or body of the scene, from 0",
            )?;
        }
        let law = &self.law;
        above_zero(&format!("{name}.law.stiffness"), &[law.stiffness])?;
        not_negative(&format!("{name}.law.damping"), &[law.damping])?;
        not_negative(&format!("{name}.law.friction"), &[law.friction])?;
        let bristle = format!("{name}.law.friction_stiffness");
        above_zero(&bristle, &[law.friction_stiffness])?;
        not_negative(
            &format!("{name}.law.friction_damping"),
            &[law.friction_damping],
        )
    }
}
