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

/// A wrench whose force follows a straight line over a period: `force + slope (t - duration/2)`, with t the time since
/// the line began. After `duration` it keeps its last value until the next command. A constant has no slope.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Line {
    /// Mean of the wrench over `duration`.
    pub wrench: Wrench,
    /// Slope of the force, in the device's frame `[N/s]`.
    pub slope: Vector,
    /// Time over which the force changes: the loop's period.
    pub duration: Duration,
}

impl Line {
    /// Zero force and torque.
    pub const NONE: Self = Self {
        wrench: Wrench::NONE,
        slope: [0.0; 3],
        duration: Duration::ZERO,
    };

    /// Returns whether the force is a constant.
    #[must_use]
    pub fn is_constant(&self) -> bool {
        self.slope == [0.0; 3]
    }

    /// Returns the wrench `age` after the line began.
    #[must_use]
    pub fn at(&self, age: Duration) -> Wrench {
        let since_middle = age.min(self.duration).as_secs_f64() - 0.5 * self.duration.as_secs_f64();
        self.plus(since_middle)
    }

    /// Returns the wrench that is held after `duration`.
    #[must_use]
    pub fn end(&self) -> Wrench {
        self.plus(0.5 * self.duration.as_secs_f64())
    }

    /// Returns the impulse of the force `[N s]` and of the torque `[N m s]` between two ages of the line.
    #[must_use]
    pub fn impulse(&self, from: Duration, until: Duration) -> Wrench {
        let times = |wrench: Wrench, span: Duration| {
            let span = span.as_secs_f64();
            wrench.each(|vector| vector.map(|part| part * span))
        };
        if self.is_constant() {
            return times(self.wrench, until.saturating_sub(from));
        }
        let [begins, ends] = [from, until].map(|age| age.min(self.duration));
        let rises = times(self.at((begins + ends) / 2), ends.saturating_sub(begins));
        let stays = times(self.end(), until.saturating_sub(self.duration.max(from)));
        Wrench {
            force: sum(rises.force, stays.force),
            torque: sum(rises.torque, stays.torque),
        }
    }

    /// Returns the wrench `since_middle` `[s]` after the middle of the line.
    fn plus(&self, since_middle: f64) -> Wrench {
        Wrench {
            force: sum(
                self.wrench.force,
                self.slope.map(|slope| slope * since_middle),
            ),
            torque: self.wrench.torque,
        }
    }
}

fn sum([ax, ay, az]: Vector, [bx, by, bz]: Vector) -> Vector {
    [ax + bx, ay + by, az + bz]
}

impl From<Wrench> for Line {
    fn from(wrench: Wrench) -> Self {
        Self {
            wrench,
            ..Self::NONE
        }
    }
}

impl From<Vector> for Wrench {
    fn from(force: Vector) -> Self {
        Self::of_force(force)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_ends_with_its_duration_and_has_the_impulse_of_its_course() {
        let line = Line {
            wrench: Wrench {
                force: [2.0, -1.0, 0.0],
                torque: [0.0, 0.5, 0.0],
            },
            slope: [300.0, 50.0, 0.0],
            duration: Duration::from_millis(10),
        };
        let ms = Duration::from_millis;
        assert!(!line.is_constant() && Line::from(line.wrench).is_constant());
        let close = |found: f64, expected: f64| {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}")
        };
        close(line.at(ms(0)).force[0], 0.5);
        close(line.at(ms(5)).force[0], 2.0);
        for age in [10, 11, 500] {
            assert_eq!(line.at(ms(age)), line.end());
        }
        close(line.end().force[0], 3.5);
        close(line.impulse(ms(0), ms(10)).force[0], 0.02);
        // A rise of 4 ms to 3.5 N, then 6 ms of it.
        close(
            line.impulse(ms(6), ms(16)).force[0],
            0.004 * 2.9 + 0.006 * 3.5,
        );
        close(line.impulse(ms(20), ms(30)).force[0], 0.035);
        close(line.impulse(ms(20), ms(30)).torque[1], 0.005);
        close(line.impulse(ms(3), ms(3)).force[0], 0.0);
        close(
            Line::from(line.wrench).impulse(ms(1), ms(4)).force[1],
            -0.003,
        );
    }
}
