//! The part of a motion shown in reports and figures.

use crate::calibrate::Measured;

use super::MotionCard;
use super::motion::ExcitedMotion;

/// Duration of the drawn part `[s]`, short enough to show steps of the force.
const SHOWN: f64 = 0.25;

/// Returns positions, forces and the fit's predictions of the positions, over a part in the middle.
#[must_use]
pub fn shown(motion: &ExcitedMotion, measured: &Measured, period: f64) -> MotionCard {
    let excited = motion.excited();
    let middle = usize::midpoint(excited.start, excited.end);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a number of samples"
    )]
    let half = (0.5 * SHOWN / period).ceil() as usize;
    let shown = middle.saturating_sub(half).max(excited.start)..(middle + half).min(excited.end);
    let start = motion.positions[0];
    let moved = |of: &[f64]| of[shown.clone()].iter().map(|x| x - start).collect();
    MotionCard {
        t_s: shown.clone().map(|i| i as f64 * period).collect(),
        measured_m: moved(&motion.positions),
        fitted_m: moved(&measured.foreseen),
        command_n: motion.forces[shown.clone()].to_vec(),
    }
}
