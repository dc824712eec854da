//! World description and its checks.

use std::collections::HashSet;

use palpate_core::Range;

use crate::error::out_of_range;
use crate::geometry::rigid::{Matrix3, Vector3};
use crate::{
    Body, Contact, ContactLaw, Field, Free, Joint, JointKind, Motion, Party, Shape, Tool, Vector,
    WorldError, WorldErrors, WorldField, WorldPart,
};

/// World description: tools, bodies, joints, contact laws and force fields.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct World {
    /// One tool per device, in the order of the devices.
    pub tools: Vec<Tool>,
    /// The bodies.
    pub bodies: Vec<Body>,
    /// Contact laws. A law between two names has precedence over one between a name and [`Party::Any`], which has
    /// precedence over one between any two. The last of equal rank applies. A pair without a law does not touch.
    pub contacts: Vec<Contact>,
    /// The joints.
    pub joints: Vec<Joint>,
    /// The force fields. In a changed world the field with the same index continues.
    pub fields: Vec<Field>,
}

/// Allowed deviation of a unit vector's length from 1.
const LENGTH_TOLERANCE: f64 = 1e-6;
/// Relative excess of a moment of inertia over the sum of the other two that is tolerated, for rounded numbers.
const MOMENT_SLACK: f64 = 1e-3;
/// Maximum position of the stops of a hinge `[rad]`: its angle is known within half a turn in either direction.
const MAX_TURN: f64 = 3.0;

impl World {
    /// Returns the law between the tools or bodies of these names, if they touch.
    #[must_use]
    pub fn law(&self, one: &str, other: &str) -> Option<&ContactLaw> {
        let rank = |contact: &Contact| {
            let [a, b] = &contact.between;
            let fits = |party: &Party, name: &str| match party {
                Party::Any => Some(0),
                Party::Named(named) => (named == name).then_some(1),
            };
            let both = |a, b| Some(fits(a, one)? + fits(b, other)?);
            both(a, b).or_else(|| both(b, a))
        };
        self.contacts
            .iter()
            .filter_map(|contact| Some((rank(contact)?, &contact.law)))
            .max_by_key(|&(rank, _)| rank)
            .map(|(_, law)| law)
    }

    /// Checks the world.
    ///
    /// # Errors
    ///
    /// Returns all faults in the order tools, bodies, contacts, joints, fields (at least one).
    pub fn check(&self) -> Result<(), WorldErrors> {
        let mut faults = Vec::new();
        let mut names = HashSet::new();
        self.check_tools(&mut names, &mut faults);
        self.check_bodies(&mut names, &mut faults);
        self.check_contacts(&names, &mut faults);
        self.check_joints(&mut faults);
        self.check_fields(&mut faults);
        WorldErrors::check(faults)
    }

    /// Reports the faults of the tools, and collects their names.
    fn check_tools<'n>(&'n self, names: &mut HashSet<&'n str>, faults: &mut Vec<WorldError>) {
        if self.tools.is_empty() {
            let message = "there is no tool; a world needs one for each device";
            faults.push(WorldError::new(
                WorldPart::World,
                WorldField::Tools,
                "the world",
                message,
            ));
        }
        for (number, tool) in self.tools.iter().enumerate() {
            let subject = format!("tool {:?}", tool.name);
            let mut of = Faults::new(faults, WorldPart::Tool(number), &subject);
            of.name(&tool.name, names);
            of.shape(&tool.shape, true, false);
            of.tool(&tool.shape);
            if tool.axes == [false; 3] {
                let message = if tool.own_axes.is_none() {
                    "the device has no axis of the world; give it at least one of x, y and z"
                } else {
                    "the device has none of its own axes; give it at least one. If a device of a loop lacks an axis of \
                     the world, its own axes have to include that axis"
                };
                of.fault(WorldField::Axes, message.into());
            }
            if !tool.gives_torque && !tool.turns {
                let message = "gives_torque is false, and applies only to a tool that turns; make the tool turn or \
                               remove gives_torque";
                of.fault(WorldField::GivesTorque, message.into());
            }
            if let Some(off) = tool.own_axes.map(off_right_angles)
                && off > MAX_OFF_RIGHT_ANGLES
            {
                of.fault(
                    WorldField::OwnAxes,
                    format!(
                        "own_axes are {:?}, with a deviation from orthonormal vectors of {off:e}; at most \
                         {MAX_OFF_RIGHT_ANGLES:e} is allowed",
                        tool.own_axes.unwrap_or_default()
                    ),
                );
            }
        }
    }

    /// Reports the faults of the bodies, and collects their names.
    fn check_bodies<'n>(&'n self, names: &mut HashSet<&'n str>, faults: &mut Vec<WorldError>) {
        for (number, body) in self.bodies.iter().enumerate() {
            let subject = format!("body {:?}", body.name);
            let mut of = Faults::new(faults, WorldPart::Body(number), &subject);
            of.name(&body.name, names);
            of.shape(&body.shape, false, body.motion == Motion::Fixed);
            of.finite(WorldField::Position, &body.position);
            of.unit(WorldField::Orientation, &body.orientation);
            if let Motion::Free(free) = &body.motion {
                of.free(free);
                of.inertia(free, &body.shape);
            }
        }
    }

    /// Reports the faults of the contact laws, of which each is between two of `names`.
    fn check_contacts(&self, names: &HashSet<&str>, faults: &mut Vec<WorldError>) {
        for (number, contact) in self.contacts.iter().enumerate() {
            let [one, other] = contact.between.each_ref().map(Party::as_str);
            let subject = format!("contact between {one:?} and {other:?}");
            let mut of = Faults::new(faults, WorldPart::Contact(number), &subject);
            for party in &contact.between {
                if let Party::Named(name) = party
                    && !names.contains(name.as_str())
                {
                    of.fault(
                        WorldField::Between,
                        format!("{name:?} is neither a tool nor a body of this world"),
                    );
                }
            }
            of.pair(&contact.between, &self.tools);
            let law = &contact.law;
            of.above_zero(WorldField::Stiffness, law.stiffness);
            of.at_least_zero(WorldField::Damping, law.damping);
            of.at_least_zero(WorldField::Friction, law.friction);
            of.above_zero(WorldField::FrictionStiffness, law.friction_stiffness);
            of.at_least_zero(WorldField::FrictionDamping, law.friction_damping);
        }
    }

    /// Reports the faults of the joints.
    fn check_joints(&self, faults: &mut Vec<WorldError>) {
        for (number, joint) in self.joints.iter().enumerate() {
            let against = joint.against.as_deref().unwrap_or("world");
            let subject = format!("joint of {:?} and {against:?}", joint.body);
            let mut of = Faults::new(faults, WorldPart::Joint(number), &subject);
            of.joint(joint, &self.bodies);
        }
    }

    /// Reports the faults of the fields.
    fn check_fields(&self, faults: &mut Vec<WorldError>) {
        for (number, field) in self.fields.iter().enumerate() {
            let subject = format!("field {number} on {:?}", field.tool);
            let is_body = self.bodies.iter().any(|body| body.name == field.tool);
            let mut of = Faults::new(faults, WorldPart::Field(number), &subject);
            of.field(field, &self.tools, is_body);
        }
    }
}

/// Returns whether a vector has length 1.
pub(crate) fn is_unit(values: &[f64]) -> bool {
    let length = values.iter().map(|value| value * value).sum::<f64>().sqrt();
    (length - 1.0).abs() < LENGTH_TOLERANCE
}

/// Collector of the faults of one part of a world.
pub(crate) struct Faults<'a> {
    all: &'a mut Vec<WorldError>,
    place: WorldPart,
    subject: &'a str,
}

impl<'a> Faults<'a> {
    pub(crate) fn new(all: &'a mut Vec<WorldError>, place: WorldPart, subject: &'a str) -> Self {
        Self {
            all,
            place,
            subject,
        }
    }

    pub(crate) fn fault(&mut self, field: WorldField, message: String) {
        let error = WorldError::new(self.place, field, self.subject, message);
        self.all.push(error);
    }

    fn name<'n>(&mut self, name: &'n str, taken: &mut HashSet<&'n str>) {
        if name.is_empty() || name == "*" {
            self.fault(WorldField::Name, format!("{name:?} is not a valid name"));
        } else if !taken.insert(name) {
            self.fault(
                WorldField::Name,
                "the name is taken by another tool or body".into(),
            );
        }
    }

    fn within(&mut self, field: WorldField, value: f64, range: Range) {
        if let Some(message) = out_of_range(field, value, range) {
            self.fault(field, message);
        }
    }

    pub(super) fn above_zero(&mut self, field: WorldField, value: f64) {
        self.within(field, value, Range::Positive);
    }

    pub(super) fn at_least_zero(&mut self, field: WorldField, value: f64) {
        self.within(field, value, Range::NotNegative);
    }

    pub(crate) fn finite(&mut self, field: WorldField, values: &[f64]) {
        let mut faults = values
            .iter()
            .filter_map(|value| out_of_range(field, *value, Range::Finite));
        if let Some(message) = faults.next() {
            self.fault(field, message);
        }
    }

    /// Reports two names between which no contact is possible.
    fn pair(&mut self, between: &[Party; 2], tools: &[Tool]) {
        let [Party::Named(one), Party::Named(other)] = between else {
            return;
        };
        let is_tool = |name: &String| tools.iter().any(|tool| tool.name == *name);
        if one == other {
            self.fault(
                WorldField::Between,
                format!("{one:?} cannot touch itself; give two different names"),
            );
        } else if is_tool(one) && is_tool(other) {
            self.fault(
                WorldField::Between,
                "two tools do not touch each other; name a tool and a body, or two bodies".into(),
            );
        }
    }

    pub(crate) fn unit(&mut self, field: WorldField, values: &[f64]) {
        let length = values.iter().map(|value| value * value).sum::<f64>().sqrt();
        let is_unit = is_unit(values);
        if !(length > 0.0 && length.is_finite()) {
            self.fault(
                field,
                format!("{field} has length {length}, so it has no direction; give a finite length above 0"),
            );
        } else if !is_unit {
            self.fault(
                field,
                format!("{field} has length {length}, and has to have length 1"),
            );
        }
    }

    fn shape(&mut self, shape: &Shape, may_be_a_point: bool, fixed: bool) {
        match *shape {
            Shape::Sphere { radius } if may_be_a_point => {
                self.at_least_zero(WorldField::Radius, radius)
            }
            Shape::Sphere { radius } => self.above_zero(WorldField::Radius, radius),
            Shape::HalfSpace { normal, offset } => {
                if !fixed {
                    self.fault(
                        WorldField::Shape,
                        "a half-space has to be a fixed body".into(),
                    );
                }
                self.unit(WorldField::Normal, &normal);
                self.finite(WorldField::Offset, &[offset]);
            }
            Shape::Mesh(_) | Shape::Hull(_) => {}
            Shape::Spheres { ref spheres } => {
                if !may_be_a_point {
                    let message =
                        "several spheres are allowed only for a tool; a body has one shape";
                    self.fault(WorldField::Shape, message.into());
                }
                if spheres.is_empty() {
                    self.fault(
                        WorldField::Spheres,
                        "there is no sphere; give at least one".into(),
                    );
                }
                for sphere in spheres {
                    self.finite(WorldField::Centre, &sphere.centre);
                    self.at_least_zero(WorldField::Radius, sphere.radius);
                }
            }
            Shape::Box { half_extents } => {
                for half in half_extents {
                    self.above_zero(WorldField::HalfExtents, half);
                }
            }
            Shape::Capsule {
                radius,
                half_length,
            }
            | Shape::Cylinder {
                radius,
                half_length,
            } => {
                self.above_zero(WorldField::Radius, radius);
                self.above_zero(WorldField::HalfLength, half_length);
            }
        }
    }

    fn joint(&mut self, joint: &Joint, bodies: &[Body]) {
        let mut moves = false;
        for name in [Some(&joint.body), joint.against.as_ref()]
            .into_iter()
            .flatten()
        {
            match bodies.iter().find(|body| body.name == *name) {
                Some(body) => moves |= body.motion != Motion::Fixed,
                None => self.fault(
                    WorldField::Between,
                    format!("{name:?} is not a body of this world"),
                ),
            }
        }
        if joint.against.as_ref() == Some(&joint.body) {
            self.fault(
                WorldField::Between,
                "a body has no joint with itself".into(),
            );
        } else if !moves {
            self.fault(
                WorldField::Between,
                "one of the two has to be a body that moves".into(),
            );
        }
        self.finite(WorldField::Point, &joint.point);
        self.unit(WorldField::Axis, &joint.axis);
        let law = &joint.law;
        self.above_zero(WorldField::Stiffness, law.stiffness);
        self.at_least_zero(WorldField::Damping, law.damping);
        self.above_zero(WorldField::Span, law.span);
        self.at_least_zero(WorldField::Spring, law.spring);
        self.finite(WorldField::Rest, &[law.rest]);
        self.at_least_zero(WorldField::AlongDamping, law.along_damping);
        if let Some(limits) = law.limits {
            let [low, high] = limits;
            self.finite(WorldField::Limits, &limits);
            if low > high {
                let message =
                    format!("limits are {low} and {high}; the lower limit has to come first");
                self.fault(WorldField::Limits, message);
            }
            if joint.kind == JointKind::Hinge && (low < -MAX_TURN || high > MAX_TURN) {
                let message = format!(
                    "limits are {low} and {high}, and those of a hinge have to be between -{MAX_TURN} and {MAX_TURN} \
                     rad"
                );
                self.fault(WorldField::Limits, message);
            }
        }
    }

    /// Checks that the shape is allowed for a tool.
    fn tool(&mut self, shape: &Shape) {
        match shape {
            Shape::Sphere { .. }
            | Shape::Spheres { .. }
            | Shape::Box { .. }
            | Shape::Capsule { .. }
            | Shape::Cylinder { .. } => {}
            Shape::Mesh(mesh) if mesh.shell().is_some() => {}
            _ => self.fault(
                WorldField::Shape,
                "a tool has to be a sphere, of radius 0 or more, several spheres, a box, a capsule, a cylinder or a mesh with a \
                 shell of points"
                    .into(),
            ),
        }
    }

    /// Checks that a mesh without given moments of inertia is closed.
    fn inertia(&mut self, free: &Free, shape: &Shape) {
        let (mesh, word) = match shape {
            Shape::Mesh(mesh) => (mesh, "mesh"),
            Shape::Hull(hull) => (hull.mesh(), "hull"),
            _ => return,
        };
        if free.inertia.is_some() {
            return;
        }
        let filled = mesh.mass_properties(1.0);
        let is_solid = filled.is_none_or(|of| of.moments.iter().all(|moment| *moment > 0.0));
        if is_solid && shape.moments(free.mass).is_some() {
            return;
        }
        let message = match filled {
            None => {
                "the mesh has open edges, so its inertia cannot be computed; close the mesh, or give three moments of \
                 inertia about its origin, which is then the centre of mass"
                    .into()
            }
            Some(of) if !is_solid => format!(
                "the {word} intersects itself, so parts of it count as hollows: its moments of inertia for 1 kg would \
                 be {:?} kg m^2, and they have to be above 0; repair it, or give three moments about the {word}'s \
                 origin, which is then the centre of mass",
                of.moments
            ),
            Some(of) => format!(
                "the {word} has its centre of mass at {:?} m, or its axes are not principal axes, so three \
                 moments of inertia do not describe its rotation; balance the body, or give three moments about the \
                 {word}'s origin, which is then the centre of mass",
                of.centre
            ),
        };
        self.fault(WorldField::Inertia, message);
    }

    fn free(&mut self, free: &Free) {
        self.above_zero(WorldField::Mass, free.mass);
        if let Some([a, b, c]) = free.inertia
            && a.min(b).min(c) > 0.0
        {
            let (sum, most) = (a + b + c, a.max(b).max(c));
            if most > (sum - most) * (1.0 + MOMENT_SLACK) {
                self.fault(
                    WorldField::Inertia,
                    format!(
                        "inertia has a moment of {most}, and it has to be at most the sum of the other two, {}",
                        sum - most
                    ),
                );
            }
        }
        for moment in free.inertia.iter().flatten() {
            self.above_zero(WorldField::Inertia, *moment);
        }
        let vectors: [(WorldField, &Vector); 3] = [
            (WorldField::Velocity, &free.velocity),
            (WorldField::AngularVelocity, &free.angular_velocity),
            (WorldField::Force, &free.force),
        ];
        for (field, vector) in vectors {
            self.finite(field, vector);
        }
    }
}

/// Allowed deviation of a device's axes from orthogonal unit vectors.
const MAX_OFF_RIGHT_ANGLES: f64 = 1e-9;

/// Returns the largest deviation of the axes' dot products from those of orthogonal unit vectors; infinite for
/// non-finite axes.
fn off_right_angles(axes: [Vector; 3]) -> f64 {
    let columns = Matrix3::from_columns(&axes.map(Vector3::from));
    let off = columns.tr_mul(&columns) - Matrix3::identity();
    off.iter().fold(0.0, |most: f64, off| {
        if off.is_finite() {
            most.max(off.abs())
        } else {
            f64::INFINITY
        }
    })
}
