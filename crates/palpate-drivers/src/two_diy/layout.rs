//! Port assignment of motors and encoders, and link lengths.

use super::kinematics::{ArmPose, Geometry, NoPose};

/// Positive direction of a motor or an encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Clockwise; 0 on the wire.
    Clockwise,
    /// Counter-clockwise; 1 on the wire.
    CounterClockwise,
}

impl Direction {
    /// Returns the byte on the wire.
    #[must_use]
    pub fn byte(self) -> u8 {
        match self {
            Self::Clockwise => 0,
            Self::CounterClockwise => 1,
        }
    }
}

/// A joint with its motor and encoder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joint {
    /// Port of the motor, counted from 1.
    pub motor_port: u8,
    /// Positive direction of the motor.
    pub motor_direction: Direction,
    /// Port of the encoder, counted from 1.
    pub encoder_port: u8,
    /// Positive direction of the encoder.
    pub encoder_direction: Direction,
    /// Angle of the joint while SETUP is sent `[degrees]`.
    pub start: f32,
    /// Counts per revolution sent to the board in SETUP.
    pub counts_per_rev: f32,
}

/// Contents of a SETUP packet, and the mechanism. [`Generation::layout`] returns the presets; the fields are public for
/// kits with another assembly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout {
    /// Device id; 0 is reserved for RESET.
    pub device_id: u8,
    /// Joints 1 and 2.
    pub joints: [Joint; 2],
    /// Lengths of the links.
    pub geometry: Geometry,
}

/// Generations sold by Haply, with the configuration of its examples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Generation {
    /// Kit of 2018 and 2019. Device id 3, as in the wall example; the C++ example has 5.
    One,
    /// Both motors on one axis.
    Two,
    /// Also 3.1. Other published settings, possible with other fields of [`Layout`]: motors clockwise with the start at
    /// 180 and 0 degrees; 2048 * 2.5 * 1.0194 counts per revolution.
    Three,
}

impl Generation {
    /// Every generation.
    pub const ALL: [Self; 3] = [Self::One, Self::Two, Self::Three];

    /// Returns the generation number.
    #[must_use]
    pub fn number(self) -> u8 {
        match self {
            Self::One => 1,
            Self::Two => 2,
            Self::Three => 3,
        }
    }

    /// Returns the board sold with this generation; for the second generation it is not documented.
    #[must_use]
    pub fn usual_board(self) -> super::Board {
        match self {
            Self::One | Self::Two => super::Board::M3,
            Self::Three => super::Board::M0,
        }
    }

    /// Returns wiring, start pose (fully retracted) and links of Haply's own examples.
    #[must_use]
    pub fn layout(self) -> Layout {
        use Direction::{Clockwise, CounterClockwise};
        let joint = |port, motor_direction, encoder_direction, start, counts_per_rev| Joint {
            motor_port: port,
            motor_direction,
            encoder_port: port,
            encoder_direction,
            start,
            counts_per_rev,
        };
        match self {
            Self::One => Layout {
                device_id: 3,
                joints: [
                    joint(1, Clockwise, Clockwise, 180.0, 13824.0),
                    joint(2, Clockwise, Clockwise, 0.0, 13824.0),
                ],
                geometry: Geometry::new(0.05, 0.07, 0.02),
            },
            Self::Two => Layout {
                device_id: 5,
                joints: [
                    joint(2, CounterClockwise, CounterClockwise, 241.0, 10752.0),
                    joint(1, Clockwise, Clockwise, -61.0, 10752.0),
                ],
                geometry: Geometry::new(0.07, 0.09, 0.0),
            },
            Self::Three => Layout {
                device_id: 5,
                joints: [
                    joint(2, CounterClockwise, CounterClockwise, 168.0, 4880.0),
                    joint(1, CounterClockwise, CounterClockwise, 12.0, 4880.0),
                ],
                geometry: Geometry::new(0.07, 0.09, 0.038),
            },
        }
    }

    /// Returns the angles of the fully extended arm `[degrees]`, if they are published.
    #[must_use]
    pub fn extended(self) -> Option<[f32; 2]> {
        match self {
            Self::One | Self::Two => None,
            Self::Three => Some([97.3, 82.7]),
        }
    }

    /// Returns a position on the centre line from which 0.1 m away from the base and 10 mm towards it are within reach
    /// `[m]`. It is the default origin of a scene coordinate.
    #[must_use]
    pub fn usual_origin(self) -> [f64; 2] {
        match self {
            Self::One => [0.01, 0.05],
            Self::Two => [0.0, 0.04],
            Self::Three => [0.019, 0.05],
        }
    }
}

impl Layout {
    /// Returns the same layout with another start pose `[degrees]`.
    #[must_use]
    pub fn starting_at(mut self, angles: [f32; 2]) -> Self {
        for (joint, angle) in self.joints.iter_mut().zip(angles) {
            joint.start = angle;
        }
        self
    }

    /// Returns the start pose that SETUP asserts.
    ///
    /// # Errors
    /// The links do not reach the pose, or it is singular.
    pub fn start_pose(&self) -> Result<ArmPose, NoPose> {
        let angles = self.joints.map(|joint| f64::from(joint.start).to_radians());
        self.geometry.pose(angles)
    }

    /// Returns the values of the joints in the order of their motor ports, as on the wire.
    #[must_use]
    pub fn by_motor_port<T: Copy>(&self, [first, second]: [T; 2]) -> [T; 2] {
        if self.joints[0].motor_port <= self.joints[1].motor_port {
            [first, second]
        } else {
            [second, first]
        }
    }

    /// Returns the values of the joints in the order of their encoder ports. The function is its own inverse.
    #[must_use]
    pub fn by_encoder_port<T: Copy>(&self, [first, second]: [T; 2]) -> [T; 2] {
        if self.joints[0].encoder_port <= self.joints[1].encoder_port {
            [first, second]
        } else {
            [second, first]
        }
    }
}
