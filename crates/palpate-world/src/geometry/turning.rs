//! Rotational drive of a tool, without its contacts.

use crate::geometry::rigid::{Rigid, Rotation, Vector3};

/// Torque on a tool without its contacts, over an interval.
///
/// ```text
/// torque = start - lambda (L - L at the start) + k (rotation vector from the tool to the aim)
/// ```
///
/// L is the angular momentum about the mass centre, along the world's axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TurningDrive {
    /// Torque at the start of the interval, without that of the spring `[N m]`.
    pub torque: Vector3,
    /// lambda `[1/s]`.
    pub damping_rate: f64,
    /// k `[N m/rad]`.
    pub stiffness: f64,
    /// Orientation at which the spring is relaxed.
    pub aim: Rotation,
    /// Angular momentum at the start `[N m s]`.
    pub spin: Vector3,
    /// Angular velocity of a tool that is fixed between samples, used only by contact damping `[rad/s]`.
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

    /// Returns whether it has a torque at any orientation or angular momentum.
    #[inline]
    pub fn acts(&self) -> bool {
        let torque = &self.torque;
        self.stiffness > 0.0
            || self.damping_rate != 0.0
            || torque.x != 0.0
            || torque.y != 0.0
            || torque.z != 0.0
    }

    /// Begins an interval.
    pub fn begin(&mut self, rigid: &Rigid) {
        self.spin = rigid.spin;
    }

    /// Returns the torque without the part that depends on the current angular momentum `[N m]`.
    fn at(&self, rigid: &Rigid) -> Vector3 {
        let mut torque = self.torque + self.spin * self.damping_rate;
        if self.stiffness > 0.0 {
            torque += (self.aim * rigid.orientation.inverse()).scaled_axis() * self.stiffness;
        }
        torque
    }

    /// Returns the torque in the first half of a sub-step `[N m]`.
    pub fn first_torque(&self, rigid: &Rigid) -> Vector3 {
        self.at(rigid) - rigid.spin * self.damping_rate
    }

    /// Returns the torque in the second half of a sub-step, without that of the `contacts`. It uses the damping at
    /// the end, so that both halves together are of second order `[N m]`.
    pub fn second_torque(&self, rigid: &Rigid, contacts: &Vector3, half: f64) -> Vector3 {
        let undamped = self.at(rigid);
        if self.damping_rate == 0.0 {
            return undamped;
        }
        let end = (rigid.spin + (contacts + undamped) * half) / (1.0 + half * self.damping_rate);
        undamped - end * self.damping_rate
    }
}
