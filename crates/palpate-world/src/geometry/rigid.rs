//! A rigid body in motion.

use nalgebra::{Quaternion, UnitQuaternion};

use crate::geometry::axes::{OwnAxes, own, scaled};

pub(crate) type Vector3 = nalgebra::Vector3<f64>;
pub(crate) type Matrix3 = nalgebra::Matrix3<f64>;
pub(crate) type Rotation = UnitQuaternion<f64>;

/// State of a tool or body. The state variable is the angular momentum, not the angular velocity, because it is
/// constant without torque.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rigid {
    /// Position of the centre of mass `[m]`.
    pub position: Vector3,
    pub orientation: Rotation,
    /// Velocity of the centre of mass `[m/s]`.
    pub velocity: Vector3,
    /// Angular momentum about the centre of mass, along the world's axes `[N m s]`.
    pub spin: Vector3,
}

impl Rigid {
    /// Returns whether its axes are those of the world.
    #[inline]
    pub fn is_upright(&self) -> bool {
        let q = self.orientation.quaternion();
        q.w == 1.0 && q.i == 0.0 && q.j == 0.0 && q.k == 0.0
    }
}

/// Response of a tool or body to forces and torques.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Mobility {
    /// 1/m along each axis `[1/kg]`; 0 if no force moves the body.
    pub linear: Vector3,
    /// Axes of `linear`.
    pub linear_axes: OwnAxes,
    /// Inverse moments of inertia along the body's axes `[1/(kg m^2)]`; 0 if no torque turns the body.
    pub angular: Vector3,
    /// Whether all three moments are equal.
    pub is_round: bool,
}

impl Mobility {
    /// Returns the mobility of an immovable body.
    pub fn none() -> Self {
        Self {
            linear: Vector3::zeros(),
            linear_axes: None,
            angular: Vector3::zeros(),
            is_round: true,
        }
    }

    pub fn of_body(mass: f64, moments: [f64; 3]) -> Self {
        let angular = Vector3::from(moments.map(|moment| 1.0 / moment));
        Self {
            linear: Vector3::repeat(1.0 / mass),
            linear_axes: None,
            angular,
            is_round: angular.x == angular.y && angular.y == angular.z,
        }
    }

    /// Returns whether no torque turns the body.
    #[inline]
    pub fn does_not_turn(&self) -> bool {
        self.is_round && self.angular.x == 0.0
    }

    /// Returns the acceleration by a force `[m/s^2]`.
    #[inline]
    pub fn acceleration(&self, force: &Vector3) -> Vector3 {
        scaled(&self.linear_axes, &self.linear, force)
    }

    /// Returns the sum over all movable axes of the products of two vectors' components, divided by the mobility.
    #[inline]
    pub fn weighted(&self, one: &Vector3, other: &Vector3) -> f64 {
        let (one, other) = (own(&self.linear_axes, one), own(&self.linear_axes, other));
        let mut sum = 0.0;
        for axis in 0..3 {
            if self.linear[axis] > 0.0 {
                sum += one[axis] * other[axis] / self.linear[axis];
            }
        }
        sum
    }

    /// Returns the angular velocity for an angular momentum `[rad/s]`.
    #[inline]
    pub fn turning(&self, orientation: &Rotation, spin: &Vector3) -> Vector3 {
        if self.is_round {
            spin * self.angular.x
        } else {
            let own = orientation.inverse_transform_vector(spin);
            orientation * own.component_mul(&self.angular)
        }
    }

    /// Returns the angular momentum for an angular velocity `[N m s]`; 0 if no torque turns the body.
    pub fn spin(&self, orientation: &Rotation, turning: &Vector3) -> Vector3 {
        let own = orientation.inverse_transform_vector(turning);
        let spin = own.zip_map(&self.angular, |turning, mobility| {
            if mobility > 0.0 {
                turning / mobility
            } else {
                0.0
            }
        });
        orientation * spin
    }

    /// Returns the orientation after `h` `[s]` without torque, to second order (midpoint rule), for the angular velocity
    /// `start` at its start `[rad/s]`.
    #[inline]
    pub fn turned(
        &self,
        orientation: &Rotation,
        start: &Vector3,
        spin: &Vector3,
        h: f64,
    ) -> Rotation {
        if self.is_round {
            return rotation(start * h) * orientation;
        }
        let midway = rotation(start * (0.5 * h)) * orientation;
        rotation(self.turning(&midway, spin) * h) * orientation
    }

    /// Returns the kinetic energy of translation and rotation `[J]`; 0 for an immovable body.
    pub fn kinetic_energy(&self, rigid: &Rigid) -> f64 {
        let turning = self.turning(&rigid.orientation, &rigid.spin);
        let by_motion = self.weighted(&rigid.velocity, &rigid.velocity);
        0.5 * (by_motion + rigid.spin.dot(&turning))
    }
}

/// Returns a rotation by approximately `vector` `[rad]` with Cayley's map: the angle is too small by a twelfth of its
/// cube. It preserves the second order of the midpoint rule and needs no sine.
fn rotation(vector: Vector3) -> Rotation {
    UnitQuaternion::new_normalize(Quaternion::from_parts(1.0, vector * 0.5))
}

/// Converts a rotation to a quaternion `[w, x, y, z]`.
pub(crate) fn quaternion(rotation: &Rotation) -> crate::Quaternion {
    let q = rotation.quaternion();
    [q.w, q.i, q.j, q.k]
}

/// Converts a quaternion `[w, x, y, z]` to a rotation.
pub(crate) fn orientation([w, x, y, z]: crate::Quaternion) -> Rotation {
    UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z))
}
