//! Checks of a fit against what its model leaves out: an amplifier that saturates, a delay that changes.

use crate::fit::{Fit, Problem};
use crate::measure::Declined;
use crate::model::at;

/// Candidate saturation levels of the amplifier, as fractions of the largest command.
const LEVELS: std::ops::Range<i32> = 5..20;
const OF_LEVELS: f64 = 20.0;
/// Gain of log-likelihood that saturation needs; there are fifteen candidate levels.
const SATURATION_MARGIN: f64 = 15.0;
/// Standard deviations by which two halves may differ.
const HALVES: f64 = 4.0;

/// The commanded force from which on the amplifier gives no more `[N]`, if the soft begin and end of the excitation say so.
///
/// A command of constant magnitude moves a clipped device as it moves a heavier one, so only the ramps tell the two apart: clipped,
/// they move it more than the plateau lets expect.
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

/// Widens the deviations of delay and mass by the difference between the halves of the motion.
///
/// # Errors
/// The delay of one half differs from that of the other by more than `most_delay` `[periods]`.
pub fn halves(fit: &mut Fit, problem: &Problem, most_delay: f64) -> Result<(), Declined> {
    let [Some(first), Some(second)] = problem.halves().map(Problem::refitted) else {
        // A half of a short motion may say too little for a fit; the whole has been checked.
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

/// Widens the deviations of delay and mass by what `other`, a fit of another model that is nearly as good, has otherwise.
pub fn widen_by(fit: &mut Fit, other: &Fit) {
    for parameter in [at::DELAY_PLUS_LAG, at::LN_MOBILITY] {
        let difference = fit.point[parameter] - other.point[parameter];
        fit.deviation[parameter] = fit.deviation[parameter].hypot(difference);
    }
}
