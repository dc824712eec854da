//! What a slow host publishes.

use palpate_world::engine::BodyNow;
use palpate_world::engine::local::LocalContact;

use crate::scene::law_of;
use crate::world::{PALPATE_NO_BODY, Pose};

/// A body of a slow host as of a tick, along the world's axes. Its reference point is where the host takes torques about, as a
/// rule the centre of mass. It stands in arrays, so it has no struct_size and stays as it is. palpate_host_body_fixed() makes one
/// that does not move.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct HostBody {
    /// Where the reference point is, and how the body is turned.
    pub pose: Pose,
    /// Velocity of the reference point [m/s].
    pub velocity: [f64; 3],
    /// Angular velocity [rad/s].
    pub angular_velocity: [f64; 3],
    /// Acceleration of the reference point by everything but the tool, over the host's step [m/s^2].
    pub acceleration: [f64; 3],
    /// Angular acceleration by everything but the tool [rad/s^2].
    pub angular_acceleration: [f64; 3],
    /// What a wrench does to these six: rows are accelerations, columns force [N] and torque about the reference point [N m]. Of a
    /// free body of mass m, 1/m in the first three places of the diagonal, and the inverse of its inertia in the last three rows
    /// and columns; of a body that does not move, 0.
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

/// A place where a sphere, the tool or a part of a body, may touch a surface, along the world's axes, with the bodies where the
/// model says that they are. The surface is a plane or, with a curvature, a sphere; it is fixed to its body, and has no end. It
/// stands in arrays, so it has no struct_size and stays as it is. palpate_host_contact_at_gap() makes one for the tool,
/// palpate_host_contact_none() an empty place.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct HostContact {
    /// A point of the surface: as a rule the one that is nearest to the sphere [m].
    pub place: [f64; 3],
    /// Unit vector out of the surface there.
    pub normal: [f64; 3],
    /// Curvature of the surface [1/m]: 1/r of a ball of radius r, -1/r of the inside of one, 0 of a plane.
    pub curvature: f64,
    /// Stiffness, above 0 [N/m]. 0: there is no contact in this place of the array.
    pub stiffness: f64,
    /// Damping, not below 0 [N s/m].
    pub damping: f64,
    /// Coefficient of friction, not below 0.
    pub friction: f64,
    /// Stiffness of friction, above 0 [N/m]; 0: as `stiffness`.
    pub friction_stiffness: f64,
    /// Damping of friction [N s/m]; 0: `damping` times `friction_stiffness` over `stiffness`; below 0: none.
    pub friction_damping: f64,
    /// Of a sphere of a body, its centre [m]. Not looked at for the tool.
    pub centre: [f64; 3],
    /// Of a sphere of a body, its radius, not below 0 [m]. Not looked at for the tool.
    pub radius: f64,
    /// Place of the body whose surface is touched; PALPATE_NO_BODY: something that never moves.
    pub on: u32,
    /// Place of the body whose sphere touches; PALPATE_NO_BODY: the tool.
    pub of: u32,
}

impl HostContact {
    /// The contact, or none in an empty place.
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
