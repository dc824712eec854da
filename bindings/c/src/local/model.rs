//! Bodies and contacts that a low-rate simulator publishes.

use palpate_world::engine::BodyNow;
use palpate_world::engine::local::LocalContact;

use crate::scene::law_of;
use crate::world::{PALPATE_NO_BODY, Pose};

/// A body of the simulator at a tick, in world axes. Torques are about its reference point, usually the centre of
/// mass. The struct is an array element, so it has no struct_size and its layout is fixed. palpate_host_body_fixed()
/// returns an immovable body.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct HostBody {
    /// Position of the reference point, and orientation of the body.
    pub pose: Pose,
    /// Velocity of the reference point [m/s].
    pub velocity: [f64; 3],
    /// Angular velocity [rad/s].
    pub angular_velocity: [f64; 3],
    /// Acceleration of the reference point over the simulator's step, without the tool's contribution [m/s^2].
    pub acceleration: [f64; 3],
    /// Angular acceleration without the tool's contribution [rad/s^2].
    pub angular_acceleration: [f64; 3],
    /// Mobility matrix: rows are accelerations, columns force [N] and torque about the reference point [N m]. For a
    /// free body of mass m, the first three diagonal entries are 1/m, and the last three rows and columns are the
    /// inverse inertia; for an immovable body all entries are 0.
    pub mobility: [[f64; 6]; 6],
}

impl From<&HostBody> for BodyNow {
    fn from(body: &HostBody) -> Self {
        Self {
            position: body.pose.position,
            orientation: body.pose.orientation,
            velocity: body.velocity,
            angular_velocity: body.angular_velocity,
            acceleration: body.acceleration,
            angular_acceleration: body.angular_acceleration,
            mobility: body.mobility,
        }
    }
}

/// A potential contact of a sphere (the tool or a part of a body) with a surface, in world axes at the bodies' poses
/// in the model. The surface is a plane or, with a curvature, a sphere; it is attached to its body and unbounded.
/// The struct is an array element, so it has no struct_size and its layout is fixed. palpate_host_contact_at_gap()
/// returns one for the tool, palpate_host_contact_none() an empty one.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct HostContact {
    /// A point of the surface, usually the closest to the sphere [m].
    pub place: [f64; 3],
    /// Unit normal out of the surface at this point.
    pub normal: [f64; 3],
    /// Curvature of the surface [1/m]: 1/r for a ball of radius r, -1/r for its inside, 0 for a plane.
    pub curvature: f64,
    /// Stiffness, above 0 [N/m]. 0: this array element has no contact.
    pub stiffness: f64,
    /// Damping, not below 0 [N s/m].
    pub damping: f64,
    /// Coefficient of friction, not below 0.
    pub friction: f64,
    /// Tangential stiffness of friction, above 0 [N/m]; 0: equal to `stiffness`.
    pub friction_stiffness: f64,
    /// Damping of friction [N s/m]; 0: `damping` times `friction_stiffness` over `stiffness`; below 0: no damping.
    pub friction_damping: f64,
    /// Centre of a body's sphere [m]. Ignored for the tool.
    pub centre: [f64; 3],
    /// Radius of a body's sphere, not below 0 [m]. Ignored for the tool.
    pub radius: f64,
    /// Index of the body with the surface; PALPATE_NO_BODY: a fixed surface.
    pub on: u32,
    /// Index of the body with the sphere; PALPATE_NO_BODY: the tool.
    pub of: u32,
}

impl HostContact {
    /// Returns the contact, or `None` for an empty element.
    pub(super) fn local(&self) -> Option<LocalContact> {
        if self.stiffness == 0.0 {
            return None;
        }
        let law = law_of([
            self.stiffness,
            self.damping,
            self.friction,
            self.friction_stiffness,
            self.friction_damping,
        ]);
        let body = |place: u32| (place != PALPATE_NO_BODY).then_some(place as usize);
        let (place, normal) = (self.place, self.normal);
        let contact = match body(self.of) {
            None => LocalContact::of_tool(0, body(self.on), place, normal, law),
            Some(of) => {
                let sphere = (of, self.centre, self.radius);
                LocalContact::of_body(sphere, body(self.on), place, normal, law)
            }
        };
        Some(contact.curved(self.curvature))
    }
}
