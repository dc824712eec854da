//! The figure of a calibration: measured against fitted, and what is left.

use palpate_calibrate::{Calibration, Measured, Quantity};
use palpate_figure::Figure;

use super::motion::Motion;
use crate::plots::calibration;
use palpate_study::card::MotionCard;
use palpate_study::text::digits;

/// How much of the motion is drawn `[s]`: steps of the force have to be seen.
const SHOWN: f64 = 0.25;

/// Positions, forces and what the fit foresees of the positions, over a part in the middle.
pub fn shown(motion: &Motion, measured: &Measured, period: f64) -> MotionCard {
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

/// Positions, forces and what the fit left of the positions.
pub fn figure(shown: &MotionCard, calibration: &Calibration) -> Figure {
    Figure {
        title: finding(calibration),
        subtitle:
            "Positions under random force steps, and each as the fit foresees it from those before"
                .into(),
        ..calibration::figure(shown)
    }
}

/// What was found, in a line.
fn finding(calibration: &Calibration) -> String {
    let said = |quantity, unit: f64, name: &str, symbol: &str| {
        let value = calibration.value(quantity)? * unit;
        let deviation = calibration.standard_deviation(quantity)? * unit;
        Some(format!(
            "{name} {} ± {} {symbol}",
            digits(value),
            digits(deviation)
        ))
    };
    let found = [
        said(Quantity::DeviceMass, 1e3, "mass", "g"),
        said(Quantity::DelayPlusLag, 1e3, "delay and lag", "ms"),
        said(Quantity::Resonance, 1.0, "resonance", "Hz"),
    ];
    let found: Vec<String> = found.into_iter().flatten().collect();
    found.join(", ")
}
