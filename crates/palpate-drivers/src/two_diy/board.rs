//! The three boards of Haply's kits.

use std::f64::consts::TAU;

use super::layout::Layout;

/// Maximum torque of a motor `[N m]`; every firmware clamps to it.
pub const LARGEST_TORQUE: f32 = 0.123;

/// A board, identified by its firmware's handling of torques and encoders.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Board {
    /// Haply M0 (SAMD21), firmware 0.3: two motors. It counts **half** the encoders' edges.
    M0,
    /// Haply M3 (SAM3X), firmware 1.5: four motors.
    M3,
    /// The modular development kit, firmware 0.4: four motors, the even ports wired the other way.
    DevKit,
}

impl Board {
    /// Every board.
    pub const ALL: [Self; 3] = [Self::M0, Self::M3, Self::DevKit];

    /// Returns the short name used in arguments.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::M0 => "m0",
            Self::M3 => "m3",
            Self::DevKit => "dev",
        }
    }

    /// Returns the number of ports for motors and encoders.
    #[must_use]
    pub fn ports(self) -> u8 {
        match self {
            Self::M0 => 2,
            Self::M3 | Self::DevKit => 4,
        }
    }

    /// Returns the true counts per revolution for the value `messages` of SETUP.
    #[must_use]
    pub fn counts_per_rev(self, messages: f32) -> f64 {
        match self {
            Self::M0 => f64::from(messages) / 2.0,
            Self::M3 | Self::DevKit => messages.into(),
        }
    }

    /// Returns the number of duty steps between zero and maximum torque.
    #[must_use]
    pub fn duty_steps(self) -> f64 {
        match self {
            Self::M0 => 1023.0,
            Self::M3 | Self::DevKit => 4095.0,
        }
    }

    /// Returns the torque that a motor produces for the command `torque` `[N m]`: clamped, and rounded towards zero to
    /// a duty step.
    #[must_use]
    pub fn given_torque(self, torque: f32) -> f64 {
        if torque.is_nan() {
            return 0.0;
        }
        let largest = f64::from(LARGEST_TORQUE);
        let part = (f64::from(torque).abs() / largest).min(1.0);
        let steps = (part * self.duty_steps()).floor();
        (largest * steps / self.duty_steps()).copysign(torque.into())
    }

    /// Returns the angle that an encoder reports right after a SETUP with start angle `start` `[degrees]`: the firmware
    /// starts at a whole count.
    #[must_use]
    pub fn first_angle(self, start: f32, messages: f32) -> f64 {
        let counts = self.counts_per_rev(messages);
        (f64::from(start) * counts / 360.0).trunc() * 360.0 / counts
    }

    /// Returns the encoder quantum of joint `joint` `[degrees]`.
    #[must_use]
    pub fn quantum(self, layout: &Layout, joint: usize) -> f64 {
        360.0 / self.counts_per_rev(layout.joints[joint].counts_per_rev)
    }

    /// Returns the quantum of the coarser encoder `[rad]`.
    #[must_use]
    pub fn coarsest_quantum(self, layout: &Layout) -> f64 {
        [0, 1]
            .map(|joint| self.quantum(layout, joint))
            .into_iter()
            .fold(0.0, f64::max)
            * TAU
            / 360.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::two_diy::Generation;

    #[test]
    fn quanta_and_first_angles_are_those_of_the_firmware() {
        let quantum = |generation: Generation, board: Board| board.quantum(&generation.layout(), 0);
        let close = |a: f64, b: f64, digits: f64| assert!((a - b).abs() < digits, "{a} {b}");
        close(quantum(Generation::Three, Board::M0), 0.14754, 5e-6);
        close(quantum(Generation::Two, Board::M3), 0.03348, 5e-6);
        close(quantum(Generation::Two, Board::M0), 0.06696, 5e-6);
        close(quantum(Generation::One, Board::M3), 0.02604, 5e-6);
        close(Board::M0.first_angle(168.0, 4880.0), 167.9016, 5e-5);
        close(Board::M0.first_angle(12.0, 4880.0), 11.9508, 5e-5);
        close(Board::M3.first_angle(241.0, 10752.0), 240.9710, 5e-5);
        close(Board::DevKit.first_angle(-61.0, 10752.0), -60.97098, 5e-5);
    }

    #[test]
    fn torques_are_clamped_and_cut_to_the_duty() {
        for board in Board::ALL {
            let step = f64::from(LARGEST_TORQUE) / board.duty_steps();
            assert_eq!(board.given_torque(1.0), f64::from(LARGEST_TORQUE));
            assert_eq!(
                board.given_torque(f32::NEG_INFINITY),
                -f64::from(LARGEST_TORQUE)
            );
            assert_eq!(board.given_torque(f32::NAN), 0.0);
            #[expect(
                clippy::cast_possible_truncation,
                reason = "a torque on the wire is an f32"
            )]
            let half_a_step = (0.5 * step) as f32;
            assert_eq!(board.given_torque(half_a_step), 0.0);
            for torque in [0.05_f32, -0.0121, 0.12] {
                let given = board.given_torque(torque);
                let short = f64::from(torque).abs() - given.abs();
                assert!((0.0..step).contains(&short), "{board:?} {torque}");
                assert!(given * f64::from(torque) > 0.0);
            }
        }
    }
}
