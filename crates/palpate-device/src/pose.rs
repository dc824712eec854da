//! What passes between a loop and its device: a pose one way, a wrench the other way.

use std::time::Duration;

/// Three numbers along the axes of the device's frame, for instance a position `[m]`, a force `[N]` or a
/// torque `[N m]`. A device with fewer than three axes uses the first ones and leaves the others at 0.
pub type Vector = [f64; 3];

/// Where the end-point is, how it is turned, and when.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Position of the end-point in the device's frame `[m]`.
    pub position: Vector,
    /// How the end-point is turned: the unit quaternion `[w, x, y, z]` `[1]` that turns its own axes into
    /// those of the device's frame. `None`: the device does not measure that.
    pub orientation: Option<[f64; 4]>,
    /// When it was there, on the loop's clock: measured by the device if it can, else when the
    /// answer came. A device that repeats a time stamp has nothing new to say, and a stamp more than
    /// a period ahead of the clock is none.
    pub time: Duration,
}

impl Pose {
    /// A pose of a device that measures no orientation.
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
    /// No force and no torque: always taken by a device, and on any doubt.
    pub const NONE: Self = Self {
        force: [0.0; 3],
        torque: [0.0; 3],
    };

    /// A force `[N]` without a torque.
    #[must_use]
    pub fn of_force(force: Vector) -> Self {
        Self {
            force,
            ..Self::NONE
        }
    }

    /// Whether all its components are numbers and finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        let all = self.force.iter().chain(&self.torque);
        all.copied().all(f64::is_finite)
    }

    /// What a function makes of the force and of the torque, each for itself.
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
