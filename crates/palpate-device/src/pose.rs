//! Data exchanged by a loop and its device: poses and wrenches.

use std::time::Duration;

/// Three numbers along the axes of the device's frame, for instance a position `[m]`, a force `[N]` or a
/// torque `[N m]`. A device with fewer than three axes uses the first ones and leaves the others at 0.
pub type Vector = [f64; 3];

/// Position, orientation and time of the end-point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Position of the end-point in the device's frame `[m]`.
    pub position: Vector,
    /// Orientation of the end-point: the unit quaternion `[w, x, y, z]` `[1]` that rotates its axes into those of the
    /// device's frame. `None`: not measured.
    pub orientation: Option<[f64; 4]>,
    /// Sampling time on the loop's clock: measured by the device if possible, else the arrival time of the answer. A
    /// repeated time stamp marks a repeated sample. A stamp more than a period ahead of the clock is invalid.
    pub time: Duration,
}

impl Pose {
    /// Creates a pose without orientation.
    #[must_use]
    pub fn at(position: Vector, time: Duration) -> Self {
        Self {
            position,
            orientation: None,
            time,
        }
    }
}

/// A force and a torque on the end-point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wrench {
    /// Force on the end-point, in the device's frame `[N]`.
    pub force: Vector,
    /// Torque on the end-point about its position, in the device's frame `[N m]`.
    pub torque: Vector,
}

impl Wrench {
    /// Zero force and torque. Every device accepts it at any time.
    pub const NONE: Self = Self {
        force: [0.0; 3],
        torque: [0.0; 3],
    };

    /// Creates a force `[N]` without torque.
    #[must_use]
    pub fn of_force(force: Vector) -> Self {
        Self {
            force,
            ..Self::NONE
        }
    }

    /// Returns whether all components are finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        let all = self.force.iter().chain(&self.torque);
        all.copied().all(f64::is_finite)
    }

    /// Applies `change` separately to the force and to the torque.
    #[must_use]
    pub fn each(self, mut change: impl FnMut(Vector) -> Vector) -> Self {
        Self {
            force: change(self.force),
            torque: change(self.torque),
        }
    }
}

impl From<Vector> for Wrench {
    fn from(force: Vector) -> Self {
        Self::of_force(force)
    }
}
