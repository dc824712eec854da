//! Where the end-point is for given angles, and which torques make a force there.
//!
//! Motor 1 stands at the origin, motor 2 at (d, 0); x points to the right, y away from the base,
//! angles count counter-clockwise from +x:
//!
//! ```text
//! A = l (cos a1, sin a1)      B = (d, 0) + l (cos a2, sin a2)      |P - A| = |P - B| = L
//! ```
//!
//! and P lies to the left of the way from A to B. Directions of the distal links come from an
//! `atan2`; an arccosine, as in the vendor's example, has the wrong sign where P is not above both
//! elbows (it errs in 70 of 468 poses of a grid over the third generation's workspace).

/// Below this sine of the angle between the distal links no force is made: there the motors hardly
/// say where the end-point goes, and a small torque is a large force.
pub const LEAST_SINE: f64 = 0.05;
/// From this sine on a force is made as it was asked for; between the two it fades.
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

/// Why there is no pose, and hence no force.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NoPose {
    /// An angle is NaN or infinite.
    #[error("an angle is not a number")]
    NotANumber,
    /// The elbows are farther apart than the distal links can bridge.
    #[error("the angles are outside the workspace: the links do not reach")]
    OutOfReach,
    /// The elbows meet, or the distal links are in line.
    #[error("the angles are outside the workspace: the pose is singular")]
    Singular,
}

/// A pose in which forces can be made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmPose {
    /// End-point (x, y) `[m]`.
    pub position: [f64; 2],
    /// Columns of the Jacobian: how the end-point moves with joints 1 and 2 `[m/rad]`.
    pub columns: [[f64; 2]; 2],
    /// Sine of the angle between the distal links, above [`LEAST_SINE`].
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

    /// The pose for the angles of joints 1 and 2 `[rad]`.
    ///
    /// # Errors
    /// The angles are no numbers, out of reach, or singular within [`LEAST_SINE`].
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
        // sin of the whole angle between the links, from its half.
        let sine = 2.0 * (0.5 * apart / distal) * (height / distal);
        if sine < LEAST_SINE {
            return Err(NoPose::Singular);
        }
        let across = [-between[1] / apart, between[0] / apart];
        let position = [
            0.5 * (a[0] + b[0]) + height * across[0],
            0.5 * (a[1] + b[1]) + height * across[1],
        ];
        let direction = |from: [f64; 2]| (position[1] - from[1]).atan2(position[0] - from[0]);
        let (along_first, along_second) = (direction(a), direction(b));
        // The end-point turns about the other elbow while one joint moves: it goes across the
        // other distal link, as fast as its own link carries what the joint's elbow does along it.
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
    /// Torques of joints 1 and 2 `[N m]` that make `force` `[N]` on the end-point: the transpose of
    /// the Jacobian times it.
    #[must_use]
    pub fn torques(&self, force: [f64; 2]) -> [f64; 2] {
        self.columns
            .map(|column| column[0] * force[0] + column[1] * force[1])
    }

    /// The force on the end-point `[N]` that `torques` make `[N m]`; not finite where the links of
    /// a joint are in line, since they hold any force along themselves.
    #[must_use]
    pub fn force(&self, torques: [f64; 2]) -> [f64; 2] {
        let [[a, b], [c, d]] = self.columns;
        let determinant = a * d - b * c;
        [
            (d * torques[0] - b * torques[1]) / determinant,
            (a * torques[1] - c * torques[0]) / determinant,
        ]
    }

    /// How much of a force is made here, 0 to 1: it fades towards a singular pose.
    #[must_use]
    pub fn fading(&self) -> f64 {
        ((self.sine - LEAST_SINE) / (FULL_SINE - LEAST_SINE)).clamp(0.0, 1.0)
    }

    /// The largest force along the unit vector `direction` with torques up to `largest` `[N m]`, as
    /// the driver gives it `[N]`.
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
        // Here the vendor's arccosine has it wrong.
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
                        // Near a singular pose the difference quotient itself is no better.
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
        // Elbows on each other.
        let second = Generation::Two.layout().geometry;
        assert_eq!(second.pose([1.0, 1.0]), Err(NoPose::Singular));
        // It fades on the way there, and never grows again.
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
