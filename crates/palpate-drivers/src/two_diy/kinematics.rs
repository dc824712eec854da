//! Forward kinematics, and the torques that produce a force at the end-point.
//!
//! Motor 1 is at the origin, motor 2 at (d, 0); x points to the right, y away from the base, angles are
//! counter-clockwise from +x:
//!
//! ```text
//! A = l (cos a1, sin a1)      B = (d, 0) + l (cos a2, sin a2)      |P - A| = |P - B| = L
//! ```
//!
//! P is to the left of the line from A to B. Directions of the distal links are computed with `atan2`; an arccosine, as
//! in the vendor's example, has the wrong sign if P is not above both elbows (in 70 of 468 poses of a grid over the
//! third generation's workspace).

/// No force is produced if the sine of the angle between the distal links is smaller than this: the motor angles hardly
/// determine the end-point, and a small torque is a large force.
pub const MIN_SINE: f64 = 0.05;
/// From this sine upwards the full force is produced; between the two limits it fades.
pub const FULL_SINE: f64 = 0.15;

/// Lengths of a symmetric five-bar linkage `[m]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geometry {
    /// Links on the motors, l.
    pub proximal: f64,
    /// Links that meet in the end-point, L.
    pub distal: f64,
    /// From motor 1 to motor 2, d.
    pub base: f64,
}

/// Reason why there is no pose, and hence no force.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NoPose {
    /// An angle is NaN or infinite.
    #[error("an angle is not a number")]
    NotANumber,
    /// The elbows are farther apart than the distal links can bridge.
    #[error("the angles are outside the workspace: the links do not reach")]
    OutOfReach,
    /// The elbows coincide, or the distal links are collinear.
    #[error("the angles are outside the workspace: the pose is singular")]
    Singular,
}

/// A pose in which forces can be produced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmPose {
    /// End-point (x, y) `[m]`.
    pub position: [f64; 2],
    /// Columns of the Jacobian: derivatives of the end-point by joints 1 and 2 `[m/rad]`.
    pub columns: [[f64; 2]; 2],
    /// Sine of the angle between the distal links, above [`MIN_SINE`].
    pub sine: f64,
}

impl Geometry {
    /// Links l and L, and base d `[m]`.
    #[must_use]
    pub const fn new(proximal: f64, distal: f64, base: f64) -> Self {
        Self {
            proximal,
            distal,
            base,
        }
    }

    /// Returns the pose for the angles of joints 1 and 2 `[rad]`.
    ///
    /// # Errors
    /// The angles are not finite, out of reach, or singular within [`MIN_SINE`].
    pub fn pose(&self, [first, second]: [f64; 2]) -> Result<ArmPose, NoPose> {
        if !(first.is_finite() && second.is_finite()) {
            return Err(NoPose::NotANumber);
        }
        let (l, distal) = (self.proximal, self.distal);
        let a = [l * first.cos(), l * first.sin()];
        let b = [self.base + l * second.cos(), l * second.sin()];
        let between = [b[0] - a[0], b[1] - a[1]];
        let apart = between[0].hypot(between[1]);
        let square = distal * distal - 0.25 * apart * apart;
        if square < 0.0 {
            return Err(NoPose::OutOfReach);
        }
        let height = square.sqrt();
        // Sine of the full angle between the links, from the half angle.
        let sine = 2.0 * (0.5 * apart / distal) * (height / distal);
        if sine < MIN_SINE {
            return Err(NoPose::Singular);
        }
        let across = [-between[1] / apart, between[0] / apart];
        let position = [
            0.5 * (a[0] + b[0]) + height * across[0],
            0.5 * (a[1] + b[1]) + height * across[1],
        ];
        let direction = |from: [f64; 2]| (position[1] - from[1]).atan2(position[0] - from[0]);
        let (along_first, along_second) = (direction(a), direction(b));
        // If one joint moves, the end-point rotates about the other elbow, perpendicular to the other distal link. Its
        // speed follows from the velocity of the moving elbow along its own distal link.
        let column = |angle: f64, own: f64, other: f64| {
            let rate = l * (angle - own).sin() / (own - other).sin();
            [rate * other.sin(), -rate * other.cos()]
        };
        Ok(ArmPose {
            position,
            columns: [
                column(first, along_first, along_second),
                column(second, along_second, along_first),
            ],
            sine,
        })
    }
}

impl ArmPose {
    /// Returns the torques of joints 1 and 2 `[N m]` that produce `force` `[N]` at the end-point: the transposed
    /// Jacobian times the force.
    #[must_use]
    pub fn torques(&self, force: [f64; 2]) -> [f64; 2] {
        self.columns
            .map(|column| column[0] * force[0] + column[1] * force[1])
    }

    /// Returns the force at the end-point `[N]` produced by `torques` `[N m]`. It is not finite if the links of a joint
    /// are collinear, because they hold any force along themselves.
    #[must_use]
    pub fn force(&self, torques: [f64; 2]) -> [f64; 2] {
        let [[a, b], [c, d]] = self.columns;
        let determinant = a * d - b * c;
        [
            (d * torques[0] - b * torques[1]) / determinant,
            (a * torques[1] - c * torques[0]) / determinant,
        ]
    }

    /// Returns the fraction of a force that is produced in this pose, 0 to 1; it fades towards a singular pose.
    #[must_use]
    pub fn fading(&self) -> f64 {
        ((self.sine - MIN_SINE) / (FULL_SINE - MIN_SINE)).clamp(0.0, 1.0)
    }

    /// Returns the largest force along the unit vector `direction` with torques up to `largest` `[N m]`, as the driver
    /// produces it `[N]`.
    #[must_use]
    pub fn largest_force(&self, direction: [f64; 2], largest: f64) -> f64 {
        let torques = self.torques(direction).map(f64::abs);
        self.fading() * largest / torques[0].max(torques[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::two_diy::Generation;

    fn pose(generation: Generation, degrees: [f64; 2]) -> ArmPose {
        let angles = degrees.map(f64::to_radians);
        generation.layout().geometry.pose(angles).unwrap()
    }

    fn close(a: [f64; 2], b: [f64; 2], within: f64) {
        assert!(
            (a[0] - b[0]).abs() < within && (a[1] - b[1]).abs() < within,
            "{a:?} {b:?}"
        );
    }

    #[test]
    fn end_points_and_jacobians_are_those_worked_out_beforehand() {
        use Generation::{One, Three, Two};
        for (generation, degrees, place) in [
            (Three, [168.0, 12.0], [0.019, 0.03574]),
            (Three, [130.0, 50.0], [0.019, 0.11691]),
            (Three, [97.3, 82.7], [0.019, 0.155]),
            (Two, [241.0, -61.0], [0.0, 0.02213]),
            (One, [180.0, 0.0], [0.01, 0.03606]),
        ] {
            close(pose(generation, degrees).position, place, 5e-6);
        }
        let middle = pose(Three, [130.0, 50.0]).columns;
        close(middle[0], [-0.04906, -0.04961], 5e-6);
        close(middle[1], [-0.04906, 0.04961], 5e-6);
        // The vendor's arccosine is wrong here.
        close(
            pose(Three, [90.0, -20.0]).columns[1],
            [0.0035, 0.0626],
            5e-5,
        );
    }

    #[test]
    fn the_jacobian_is_the_derivative_in_every_pose() {
        let mut poses = 0;
        for generation in Generation::ALL {
            let geometry = generation.layout().geometry;
            for first in (-90..=360).step_by(6) {
                for second in (-180..=180).step_by(6) {
                    let angles = [first, second].map(|angle| f64::from(angle).to_radians());
                    let Ok(here) = geometry.pose(angles) else {
                        continue;
                    };
                    poses += 1;
                    for joint in 0..2 {
                        let moved = |by: f64| {
                            let mut angles = angles;
                            angles[joint] += by;
                            geometry.pose(angles).map(|pose| pose.position)
                        };
                        let step = 1e-5;
                        let (Ok(after), Ok(before)) = (moved(step), moved(-step)) else {
                            continue;
                        };
                        let slope = [0, 1].map(|k| (after[k] - before[k]) / (2.0 * step));
                        // The difference quotient itself is less accurate near a singular pose.
                        close(here.columns[joint], slope, 1e-7 / here.sine.powi(2));
                    }
                }
            }
        }
        assert!(poses > 5000, "{poses}");
    }

    #[test]
    fn torques_and_forces_belong_together() {
        let here = pose(Generation::Three, [140.0, 35.0]);
        for force in [[1.0, 0.0], [0.0, -2.0], [0.3, 0.7]] {
            close(here.force(here.torques(force)), force, 1e-12);
        }
    }

    #[test]
    fn the_published_torque_gives_the_published_forces() {
        for (degrees, along_x, along_y) in [
            ([168.0, 12.0], 7.9, 1.9),
            ([130.0, 50.0], 2.5, 2.5),
            ([97.3, 82.7], 2.5, 7.8),
        ] {
            let here = pose(Generation::Three, degrees);
            let largest = |direction| here.largest_force(direction, 0.123);
            assert!((largest([1.0, 0.0]) - along_x).abs() < 0.06, "{degrees:?}");
            assert!((largest([0.0, 1.0]) - along_y).abs() < 0.06, "{degrees:?}");
        }
    }

    #[test]
    fn what_is_no_pose_is_named_and_makes_no_force() {
        let geometry = Generation::Three.layout().geometry;
        let of = |degrees: [f64; 2]| geometry.pose(degrees.map(f64::to_radians));
        assert_eq!(of([f64::NAN, 0.0]), Err(NoPose::NotANumber));
        assert_eq!(of([0.0, f64::INFINITY]), Err(NoPose::NotANumber));
        // Elbows 0.198 m apart, and 2 L = 0.18 m.
        let apart = Geometry::new(0.08, 0.09, 0.038);
        assert_eq!(
            apart.pose([std::f64::consts::PI, 0.0]),
            Err(NoPose::OutOfReach)
        );
        // Coincident elbows.
        let second = Generation::Two.layout().geometry;
        assert_eq!(second.pose([1.0, 1.0]), Err(NoPose::Singular));
        // The fading factor decreases monotonically on the way.
        let mut last = 1.0;
        for step in 0..400 {
            let second_angle = 2.0 + f64::from(step) * 1e-3;
            let fading = second
                .pose([2.4, second_angle])
                .map_or(0.0, |pose| pose.fading());
            assert!(fading <= last && last - fading < 0.02, "{step}");
            last = fading;
        }
        assert_eq!(last, 0.0);
    }
}
