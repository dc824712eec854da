//! What turns a tool from outside of its contacts.

use crate::rigid::{Rigid, Rotation, Vector3};

/// What turns a tool from outside of the contacts, over an interval.
///
/// ```text
/// torque = start - lambda (L - L at the start) + k (rotation vector from the tool to the aim)
/// ```
///
/// L is the angular momentum about the mass centre, along the world's axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TurningDrive {
    /// Torque at the interval's start `[N m]`, but for that of the spring.
    pub torque: Vector3,
    /// lambda `[1/s]`.
    pub damping_rate: f64,
    /// k `[N m/rad]`.
    pub stiffness: f64,
    /// Where the spring turns the tool to.
    pub aim: Rotation,
    /// Angular momentum at the start `[N m s]`.
    pub spin: Vector3,
    /// Angular velocity that only the damping of contacts sees, of a tool that is held between samples `[rad/s]`.
    pub apparent_turning: Vector3,
}

impl TurningDrive {
    pub fn none() -> Self {
        Self {
            torque: Vector3::zeros(),
            damping_rate: 0.0,
            stiffness: 0.0,
            aim: Rotation::identity(),
            spin: Vector3::zeros(),
            apparent_turning: Vector3::zeros(),
        }
    }

    /// An interval begins.
    pub fn begin(&mut self, rigid: &Rigid) {
        self.spin = rigid.spin;
    }

    /// The torque but for what the angular momentum itself takes from it `[N m]`.
    fn at(&self, rigid: &Rigid) -> Vector3 {
        let mut torque = self.torque + self.spin * self.damping_rate;
        if self.stiffness > 0.0 {
            torque += (self.aim * rigid.orientation.inverse()).scaled_axis() * self.stiffness;
        }
        torque
    }

    /// Torque in the first half of a sub-step's push `[N m]`.
    pub fn first_torque(&self, rigid: &Rigid) -> Vector3 {
        self.at(rigid) - rigid.spin * self.damping_rate
    }

    /// Torque in the second half beside that of the `contacts`: with the damping at its end, so that both halves
    /// together are of second order `[N m]`.
    pub fn second_torque(&self, rigid: &Rigid, contacts: &Vector3, half: f64) -> Vector3 {
        let undamped = self.at(rigid);
        let end = (rigid.spin + (contacts + undamped) * half) / (1.0 + half * self.damping_rate);
        undamped - end * self.damping_rate
    }
}
