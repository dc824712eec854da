//! Consistency checks for effects outside the model: amplifier saturation and a changing delay.

use crate::calibrate::fit::{Fit, Problem};
use crate::calibrate::measure::Declined;
use crate::calibrate::model::at;

/// Candidate saturation levels of the amplifier, as fractions of the largest command.
const LEVELS: std::ops::Range<i32> = 5..20;
const OF_LEVELS: f64 = 20.0;
/// Gain of log-likelihood that saturation needs; there are fifteen candidate levels.
const SATURATION_MARGIN: f64 = 15.0;
/// Standard deviations by which the two halves may differ.
const HALVES: f64 = 4.0;

/// Returns the commanded force above which the amplifier saturates `[N]`, if the ramps of the excitation show it.
///
/// A clipped device responds to a command of constant magnitude like a heavier device, so only the ramps distinguish
/// them: there a clipped device moves more than the plateau predicts.
pub fn saturation(problem: &Problem) -> Option<f64> {
    let largest = problem.largest_command();
    let cost = problem.cost_of(f64::INFINITY, 0.0)?;
    let tried = LEVELS.filter_map(|level| {
        let part = f64::from(level) / OF_LEVELS;
        let cost = problem.cost_of(part * largest, -part.ln())?;
        Some((part * largest, cost))
    });
    let (level, least) = tried.min_by(|(_, a), (_, b)| a.total_cmp(b))?;
    (cost - least > SATURATION_MARGIN).then_some(level)
}

/// Widens the standard deviations of delay and mass by the difference between the halves of the motion.
///
/// # Errors
/// The delays of the two halves differ by more than `most_delay` `[periods]`.
pub fn halves(fit: &mut Fit, problem: &Problem, most_delay: f64) -> Result<(), Declined> {
    let [Some(first), Some(second)] = problem.halves().map(Problem::refitted) else {
        // Half of a short motion may not determine a fit. The whole motion has been checked.
        return Ok(());
    };
    for parameter in [at::DELAY_PLUS_LAG, at::LN_MOBILITY] {
        let difference = (first.point[parameter] - second.point[parameter]).abs();
        let deviation = first.deviation[parameter].hypot(second.deviation[parameter]);
        if difference.is_nan() || difference <= HALVES * deviation {
            continue;
        }
        if parameter == at::DELAY_PLUS_LAG && difference > most_delay {
            let period = problem.period();
            let [first, second] = [&first, &second].map(|fit| fit.point[parameter] * period);
            return Err(Declined::Changed { first, second });
        }
        fit.deviation[parameter] = fit.deviation[parameter].hypot(difference);
    }
    Ok(())
}

/// Widens the standard deviations of delay and mass by their difference from `other`, a fit of another model with
/// nearly the same likelihood.
pub fn widen_by(fit: &mut Fit, other: &Fit) {
    for parameter in [at::DELAY_PLUS_LAG, at::LN_MOBILITY] {
        let difference = fit.point[parameter] - other.point[parameter];
        fit.deviation[parameter] = fit.deviation[parameter].hypot(difference);
    }
}
