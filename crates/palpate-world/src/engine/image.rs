//! Image of an engine's body, with which a proxy collides during one step of the engine.

use nalgebra::{Matrix6, Quaternion, UnitQuaternion, Vector6};

use super::body::{BodyNow, BodyWrench, Stepping};
use crate::geometry::rigid::{Rigid, Rotation, Vector3};

/// Image of a body in motion.
#[derive(Clone, Copy, Debug)]
pub(super) struct Image {
    pub position: Vector3,
    pub orientation: Rotation,
    /// Velocity of the reference point `[m/s]` and angular velocity `[rad/s]`.
    pub twist: Vector6<f64>,
    /// Twist expected at the end of the sub-step, used by contact dampers.
    pub ahead: Vector6<f64>,
    /// Contact force `[N]` and torque about the reference point `[N m]`.
    pub load: Vector6<f64>,
    /// Force and torque of the contacts that involve no tool.
    pub other_load: Vector6<f64>,
    /// Impulse of `load` since the step began `[N s]`, `[N m s]`.
    pub impulse: Vector6<f64>,
    /// Translation and rotation since the step began `[m]`, `[rad]`.
    way: Vector6<f64>,
    gained: Vector6<f64>,
    /// Acceleration without contacts.
    pub acceleration: Vector6<f64>,
    pub mobility: Matrix6<f64>,
}

/// Offset of an image from its body: translation `[m]` and rotation vector `[rad]`.
#[derive(Clone, Copy, Debug)]
pub(super) struct ImageOffset {
    pub now: Vector6<f64>,
    /// Translation that the engine's integrator causes at the body's velocity `[m]`: a body that it accelerates from
    /// rest is ahead of the continuous motion by this distance, wherever no force varies within a step.
    pub of_stepping: Vector3,
}

impl ImageOffset {
    pub fn none() -> Self {
        Self {
            now: Vector6::zeros(),
            of_stepping: Vector3::zeros(),
        }
    }

    /// Decays the offset of a body without contact: the translation by at most `way` `[m]` and at most to the part
    /// `kept`, the rotation to the part `turned`.
    ///
    /// The translation decays to the nearest one between 0 and that of the integrator. A decay of the latter does the
    /// work of the body's other forces over it in each flight, at the same phase of the steps in each bounce, and a
    /// body pressed on a device can bounce on by that energy.
    pub fn decay(&mut self, way: f64, kept: f64, turned: f64) {
        let offset = linear(&self.now);
        let of_stepping = &self.of_stepping;
        let square = of_stepping.norm_squared();
        let part = if square > 0.0 {
            (offset.dot(of_stepping) / square).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let nearest = of_stepping * part;
        let rest = offset - nearest;
        let norm = rest.norm();
        let left = if norm > way { 1.0 - way / norm } else { 0.0 };
        let translation = nearest + rest * left.max(kept);
        self.now.fixed_rows_mut::<3>(0).copy_from(&translation);
        self.now.fixed_rows_mut::<3>(3).scale_mut(turned);
    }

    /// Shortens a translation beyond `most` `[m]` to it. Returns whether it was longer.
    pub fn limit(&mut self, most: f64) -> bool {
        let norm = linear(&self.now).norm();
        let is_beyond = norm > most;
        if is_beyond {
            self.now.fixed_rows_mut::<3>(0).scale_mut(most / norm);
        }
        is_beyond
    }
}

fn six(linear: &[f64; 3], angular: &[f64; 3]) -> Vector6<f64> {
    Vector6::new(
        linear[0], linear[1], linear[2], angular[0], angular[1], angular[2],
    )
}

pub(super) fn linear(six: &Vector6<f64>) -> Vector3 {
    Vector3::new(six[0], six[1], six[2])
}

pub(super) fn angular(six: &Vector6<f64>) -> Vector3 {
    Vector3::new(six[3], six[4], six[5])
}

impl Image {
    /// Returns an image of a body at an undefined position, with no acceleration.
    pub fn nowhere() -> Self {
        let none = Vector6::zeros();
        Self {
            position: Vector3::repeat(f64::MAX.sqrt()),
            orientation: Rotation::identity(),
            twist: none,
            ahead: none,
            load: none,
            other_load: none,
            impulse: none,
            way: none,
            gained: none,
            acceleration: none,
            mobility: Matrix6::zeros(),
        }
    }

    /// Creates the image of a body at the beginning of a step.
    pub fn new(body: &BodyNow, offset: &ImageOffset) -> Self {
        let [w, x, y, z] = body.orientation;
        let turned = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
        let twist = body.twist();
        Self {
            position: Vector3::from(body.position) + linear(&offset.now),
            orientation: Rotation::from_scaled_axis(angular(&offset.now)) * turned,
            twist,
            ahead: twist,
            acceleration: six(&body.acceleration, &body.angular_acceleration),
            mobility: Matrix6::from_fn(|row, column| body.mobility[row][column]),
            ..Self::nowhere()
        }
    }

    /// Begins a step.
    pub fn begin(&mut self) {
        self.impulse = Vector6::zeros();
        self.way = Vector6::zeros();
    }

    /// Returns a sum over the state that is finite only if the state is finite.
    pub fn sum(&self) -> f64 {
        let place = self.position.sum() + self.orientation.coords.sum();
        place + self.twist.sum() + self.impulse.sum()
    }

    /// Stops the image at its position. A non-finite state is replaced by [`nowhere`](Self::nowhere).
    pub fn stop(&mut self) {
        *self = if self.sum().is_finite() {
            Self {
                position: self.position,
                orientation: self.orientation,
                ..Self::nowhere()
            }
        } else {
            Self::nowhere()
        };
    }

    /// Returns the pose relative to `other`: translation `[m]` and rotation vector `[rad]`.
    pub fn apart_from(&self, other: &Self) -> Vector6<f64> {
        let turned = (self.orientation * other.orientation.inverse()).scaled_axis();
        six(&(self.position - other.position).into(), &turned.into())
    }

    /// Displaces the image by a translation `[m]` and a rotation vector `[rad]`.
    pub fn shift(&mut self, by: &Vector6<f64>) {
        self.position += linear(by);
        self.orientation = Rotation::from_scaled_axis(angular(by)) * self.orientation;
    }

    pub fn push(&mut self, half: f64) {
        self.gained = (self.acceleration + self.mobility * (self.load + self.other_load)) * half;
        self.twist += self.gained;
        self.impulse += self.load * half;
    }

    pub fn drift(&mut self, h: f64) {
        let way = self.twist * h;
        self.position += linear(&way);
        self.orientation = Rotation::from_scaled_axis(angular(&way)) * self.orientation;
        self.way += way;
        self.ahead = self.twist + self.gained;
    }

    pub fn velocity_at(&self, twist: &Vector6<f64>, place: &Vector3) -> Vector3 {
        linear(twist) + angular(twist).cross(&(place - self.position))
    }

    /// Adds a contact force at `place`.
    pub fn pushed_at(&mut self, force: &Vector3, place: &Vector3) {
        self.load += self.wrench_of(force, place);
    }

    /// Adds the force of a contact that involves no tool.
    pub fn pushed_otherwise_at(&mut self, force: &Vector3, place: &Vector3) {
        self.other_load += self.wrench_of(force, place);
    }

    fn wrench_of(&self, force: &Vector3, place: &Vector3) -> Vector6<f64> {
        let torque = (place - self.position).cross(force);
        six(&(*force).into(), &torque.into())
    }

    /// Returns the acceleration along `direction` per unit force along it at `place` `[1/kg]`.
    pub fn mobility_at(&self, direction: &Vector3, place: &Vector3) -> f64 {
        let torque = (place - self.position).cross(direction);
        let wrench = six(&(*direction).into(), &torque.into());
        wrench.dot(&(self.mobility * wrench))
    }

    /// Returns the pose of a shape that is fixed to the image.
    pub fn place(&self, position: &Vector3, orientation: &Rotation) -> Rigid {
        Rigid {
            position: self.position + self.orientation * position,
            orientation: self.orientation * orientation,
            velocity: Vector3::zeros(),
            spin: Vector3::zeros(),
        }
    }

    /// Returns the mean wrench over the step of `h` `[s]` that ends now.
    pub fn wrench(&self, h: f64) -> BodyWrench {
        let mean = self.impulse / h;
        BodyWrench {
            force: linear(&mean).into(),
            torque: angular(&mean).into(),
        }
    }

    /// Adds to an offset the displacement of the image over the step of `h` `[s]` minus that of a body that `stepping`
    /// integrates under the mean wrench.
    pub fn lead(&self, offset: &mut ImageOffset, body: &BodyNow, stepping: Stepping, h: f64) {
        let before = body.twist();
        let gained = self.acceleration * h + self.mobility * self.impulse;
        let ahead = stepping.ahead();
        offset.now += self.way - (before + gained * (0.5 + ahead)) * h;
        offset.of_stepping = linear(&(before + gained)) * (-ahead * h);
    }
}
