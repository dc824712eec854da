//! Conversion from a force to the torques on the wire, and back to the force that they produce.

use super::board::{Board, LARGEST_TORQUE};
use super::kinematics::ArmPose;

/// Torques of joints 1 and 2 `[N m]`.
pub type Torques = [f32; 2];

/// Smaller torques are set to zero `[N m]`: the finest step of any board is 30 thousand times as large.
const MIN_TORQUE: f64 = 1e-9;

/// Returns the torques to command for `force` `[N]`, and the force that the board produces with them.
///
/// If a motor saturates, both torques are reduced so that the **direction** of the force is kept. The force fades near
/// a singular pose. A non-finite force gives zero torque.
#[must_use]
pub fn torques(pose: &ArmPose, board: Board, force: [f64; 2]) -> (Torques, [f64; 2]) {
    const NONE: (Torques, [f64; 2]) = ([0.0; 2], [0.0; 2]);
    let wanted = pose.torques(force);
    let most = wanted[0].abs().max(wanted[1].abs());
    let is_force =
        most > MIN_TORQUE && most.is_finite() && force.iter().all(|part| part.is_finite());
    if !is_force {
        return NONE;
    }
    let largest = f64::from(LARGEST_TORQUE);
    let scale = pose.fading() * (largest / most).min(1.0);
    #[expect(
        clippy::cast_possible_truncation,
        reason = "a torque on the wire is an f32"
    )]
    let torques = wanted
        .map(|torque| (torque * scale) as f32)
        .map(|torque| torque.clamp(-LARGEST_TORQUE, LARGEST_TORQUE));
    let given = torques.map(|torque| board.given_torque(torque));
    // Each duty loses at most one step. If the resulting force is larger than the loss along the force direction, the
    // links hold it and not the motors, so only the component along that direction is known.
    let along = (given[0] * wanted[0] + given[1] * wanted[1])
        / (wanted[0] * wanted[0] + wanted[1] * wanted[1]);
    let straight = force.map(|part| part * along);
    let solved = pose.force(given);
    let off = [0, 1].map(|k| solved[k] - straight[k]);
    let is_known = off[0].hypot(off[1]) <= 0.1 * straight[0].hypot(straight[1]).max(0.1);
    (torques, if is_known { solved } else { straight })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::two_diy::Generation;

    #[test]
    fn a_force_is_shortened_and_keeps_its_direction() {
        let step = f64::from(LARGEST_TORQUE) / 1023.0;
        for generation in Generation::ALL {
            let geometry = generation.layout().geometry;
            for degrees in [
                [130.0, 50.0],
                [150.0, 40.0],
                [110.0, 20.0],
                [168.0, 12.0_f64],
            ] {
                let pose = geometry.pose(degrees.map(f64::to_radians)).unwrap();
                for force in [[0.5, 0.2], [-1.0, 0.9], [30.0, -40.0], [0.0, 1e9]] {
                    let (torques, given) = torques(&pose, Board::M0, force);
                    assert!(torques.iter().all(|torque| torque.abs() <= LARGEST_TORQUE));
                    let wanted = pose.torques(force);
                    let largest = wanted[0].abs().max(wanted[1].abs());
                    let scale = pose.fading() * (0.123 / largest).min(1.0);
                    for joint in 0..2 {
                        let short = (wanted[joint] * scale).abs() - f64::from(torques[joint]).abs();
                        assert!(short.abs() < 1e-7, "{generation:?} {degrees:?} {force:?}");
                    }
                    // The given torques produce this force, within one duty step.
                    let made = pose.torques(given);
                    for joint in 0..2 {
                        let off = made[joint] - f64::from(torques[joint]);
                        assert!(off.abs() <= 1.01 * step, "{made:?} {torques:?}");
                    }
                    if largest > 0.123 {
                        let given = pose.torques(given);
                        assert!(given[0].abs().max(given[1].abs()) > 0.98 * pose.fading() * 0.123);
                    }
                }
            }
        }
    }

    #[test]
    fn what_is_no_force_commands_none() {
        let geometry = Generation::Three.layout().geometry;
        let pose = geometry.pose([2.3, 0.8]).unwrap();
        for force in [[0.0, 0.0], [f64::NAN, 1.0], [1.0, f64::INFINITY]] {
            assert_eq!(torques(&pose, Board::M3, force), ([0.0; 2], [0.0; 2]));
        }
    }
}
