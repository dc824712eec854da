//! Computes the parameters of the loop from positions and commands, or the reason why they are unknown.

use std::fmt;

use crate::calibrate::consistency;
use crate::calibrate::excitation::ExcitationParams;
use crate::calibrate::filter::Samples;
use crate::calibrate::fit::{self, Fit, Fits};
use crate::calibrate::model::{Kind, at};
use crate::calibrate::outcome::Fitted;
use crate::calibrate::quantum::quantum;
use crate::calibrate::start::start;

/// Longest delay plus lag in the search `[s]`, and in periods if that is longer.
const MAX_DELAY: f64 = 0.012;
const MAX_DELAY_PERIODS: f64 = 4.0;
/// Ratio of Coulomb friction to the largest force above which a fit is rejected.
const MAX_FRICTION: f64 = 0.6;
/// Standard deviations above which the fit is rejected: of delay plus lag `[periods]` or `[s]`, whichever is larger,
/// and of ln mass.
const MAX_DELAY_DEVIATION: f64 = 0.3;
const MAX_DELAY_DEVIATION_SECONDS: f64 = 3e-4;
const MAX_MASS_DEVIATION: f64 = 0.1;
/// Damping over mass `[1/s]` above which the device is held and does not move as a mass: hands have 15 to 50.
const MAX_DAMPING: f64 = 120.0;
/// Smallest motion for a fit `[steps of the sensor]`, root mean square.
const MIN_MOTION: f64 = 3.0;
/// Gain in log-likelihood that a resonance requires in addition to the cost of three parameters.
const RESONANCE_MARGIN: f64 = 25.0;
/// The margin for the resonance of a slow spring, below [`SLOW_RESONANCE`] `[Hz]`, where a hand looks like a resonance.
const SLOW_RESONANCE_MARGIN: f64 = 100.0;
const SLOW_RESONANCE: f64 = 60.0;
/// Highest resonance `[cycles per period]`: above it, friction errors look like a resonance.
const HIGHEST_RESONANCE: f64 = 0.33;
/// Smallest fraction of the mass beyond a transmission: below it, friction errors look like a resonance.
const MIN_FRACTION: f64 = 0.12;

/// Smallest fraction of the mean square of the second differences that a first guess attributes to the sensor.
const MIN_OF_MEAN: f64 = 0.1;

/// Reason for declining a calibration.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Declined {
    /// The numbers of positions and commands differ from the length of the whole excitation.
    Length {
        /// Positions.
        positions: usize,
        /// Commands.
        commands: usize,
        /// Samples of the excitation.
        whole: usize,
    },
    /// The device did not move with the commands.
    NotMoved {
        /// Root mean square of its motion `[m]`.
        motion: f64,
    },
    /// Coulomb friction is too close to the largest force.
    Friction {
        /// Coulomb friction `[N]`.
        friction: f64,
        /// Largest force `[N]`.
        force: f64,
    },
    /// The device is held, for example in a cog of its motor: it yields and returns instead of moving as a mass.
    Held {
        /// Fitted damping over mass `[1/s]`.
        damping: f64,
        /// Largest force `[N]`.
        force: f64,
    },
    /// The lag of the motor is at the upper limit of the search.
    LongLag {
        /// Upper limit of the search `[s]`.
        longest: f64,
    },
    /// The uncertainty of the fit is too large.
    Uncertain {
        /// Standard deviation of delay and lag together `[s]`.
        delay: f64,
        /// Standard deviation of the mass over the mass.
        mass: f64,
    },
    /// The delay changed while the device moved.
    Changed {
        /// Delay and lag in the first half `[s]`.
        first: f64,
        /// In the second half `[s]`.
        second: f64,
    },
    /// The amplifier delivers less force than commanded.
    Saturated {
        /// The commanded force above which the amplifier saturates `[N]`.
        level: f64,
        /// Largest force `[N]`.
        force: f64,
    },
    /// No model of a device explains the motion.
    NoFit,
}

impl fmt::Display for Declined {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Length {
                positions,
                commands,
                whole,
            } => write!(
                f,
                "there are {positions} positions and {commands} commands; a whole excitation has {whole} of \
                 each"
            ),
            Self::NotMoved { motion } => write!(
                f,
                "the device did not follow the commands (it moved by {:.3} mm root mean square): check \
                 that the motor is on, that a positive force raises the position, and that the largest \
                 force is well above the friction",
                motion * 1e3
            ),
            Self::Friction { friction, force } => write!(
                f,
                "Coulomb friction of about {friction:.2} N is too close to the largest force of {force} N: \
                 use a --largest-force of {:.2} N or more",
                friction * 2.5
            ),
            Self::Held { damping, force } => write!(
                f,
                "something holds the device: with a force of {force} N it hardly moves (the fit has {damping:.0} 1/s of \
                 damping over mass). Friction and cogging together may be near that force. Use a --largest-force of {:.2} N \
                 or more, or hold the device less firmly",
                force * 2.0
            ),
            Self::LongLag { longest } => write!(
                f,
                "the motor has a lag of {:.0} ms or more, the longest lag that a fit covers",
                longest * 1e3
            ),
            Self::Uncertain { delay, mass } => write!(
                f,
                "the excitation is insufficient: delay and lag are known to {:.3} ms, and the mass to {:.0} %; \
                 allow more force or more seconds",
                delay * 1e3,
                mass * 100.0
            ),
            Self::Changed { first, second } => write!(
                f,
                "the delay changed while the device moved: delay and lag were {:.2} ms in the first half and {:.2} ms in the \
                 second. Find what changes it (a driver's buffer, another program on the machine) and calibrate again",
                first * 1e3,
                second * 1e3
            ),
            Self::Saturated { level, force } => write!(
                f,
                "the amplifier saturates: above about {level:.2} N a larger command has no effect, and the largest \
                 force is {force} N. Use a --largest-force of {:.2} N or less",
                0.8 * level
            ),
            Self::NoFit => write!(f, "no device model fits the motion"),
        }
    }
}

impl std::error::Error for Declined {}

/// A measured loop.
#[derive(Clone, Debug)]
pub struct Measured {
    /// The fitted parameters.
    pub fitted: Fitted,
    /// Positions predicted by the model, each from the samples before it `[m]`.
    pub foreseen: Vec<f64>,
}

/// Estimates the parameters of a loop from the positions `[m]` that followed the commands `[N]` of an excitation.
///
/// # Errors
/// The reason for declining.
pub fn measure(
    params: &ExcitationParams,
    excited: std::ops::Range<usize>,
    positions: &[f64],
    commands: &[f64],
) -> Result<Measured, Declined> {
    if positions.len() != commands.len() || positions.len() < excited.end || excited.len() < 100 {
        return Err(Declined::Length {
            positions: positions.len(),
            commands: commands.len(),
            whole: excited.end,
        });
    }
    let ExcitationParams {
        period,
        largest_force: force,
        ..
    } = *params;
    let during = &positions[excited.clone()];
    let motion = deviation(during);
    let quantum = quantum(positions);
    let sensor = sensor_noise(positions, quantum);
    let not_moved = Declined::NotMoved { motion };
    if motion < MIN_MOTION * quantum.unwrap_or(sensor) {
        return Err(not_moved);
    }
    let samples = Samples::new(positions, commands);
    let most_delay = (MAX_DELAY / period).max(MAX_DELAY_PERIODS);
    let begin = start(&samples, period, most_delay).ok_or(not_moved)?;
    let problem = fit::problem(samples, period, excited, begin, sensor, most_delay);
    let fits = fit::fits(problem, sensor).ok_or(Declined::NoFit)?;
    let mut fit = best(fits, period);
    check(&fit, period, force)?;
    let solved = fit.solved.clone();
    if let Some(level) = consistency::saturation(&solved) {
        return Err(Declined::Saturated { level, force });
    }
    consistency::halves(&mut fit, &solved, most_delay_deviation(period))?;
    check(&fit, period, force)?;
    let foreseen = fit.foreseen.iter().map(|x| x + positions[0]).collect();
    Ok(Measured {
        fitted: Fitted::new(&fit, period, quantum),
        foreseen,
    })
}

/// Selects a fit with a resonance if its likelihood justifies the additional parameters (Schwarz, 1978).
fn best(fits: Fits, period: f64) -> Fit {
    let Fits {
        rigid,
        flexible,
        slow,
    } = fits;
    let price = 1.5 * (rigid.count as f64).ln();
    let is_worth = |fit: &Fit, margin: f64| {
        rigid.cost() - fit.cost() > price + margin && fit.fraction() > MIN_FRACTION
    };
    let flexible = flexible.filter(|fit| fit.resonance() * period < HIGHEST_RESONANCE);
    let flexible = flexible.filter(|fit| is_worth(fit, RESONANCE_MARGIN));
    let slow = slow.filter(|fit| fit.resonance() < SLOW_RESONANCE);
    // A slow spring is likely, but cannot be distinguished from a hand.
    let doubtful = slow.clone().filter(|fit| is_worth(fit, RESONANCE_MARGIN));
    let slow = slow.filter(|fit| is_worth(fit, SLOW_RESONANCE_MARGIN));
    match (flexible, slow) {
        (Some(one), Some(other)) if other.cost() < one.cost() => other,
        (Some(fit), _) | (None, Some(fit)) => fit,
        (None, None) => {
            let mut fit = rigid;
            if let Some(other) = doubtful {
                consistency::widen_by(&mut fit, &other);
            }
            fit
        }
    }
}

fn check(fit: &Fit, period: f64, force: f64) -> Result<(), Declined> {
    let mass = (-fit.point[at::LN_MOBILITY]).exp();
    let friction = fit.point[at::FRICTION] * mass;
    if friction > MAX_FRICTION * force {
        return Err(Declined::Friction { friction, force });
    }
    if let Some(longest) = fit.longest_lag(period) {
        return Err(Declined::LongLag { longest });
    }
    let damping = fit.point[at::DAMPING];
    if damping > MAX_DAMPING {
        return Err(Declined::Held { damping, force });
    }
    let delay = fit.deviation[at::DELAY_PLUS_LAG];
    let of_mass = fit.deviation[at::LN_MOBILITY];
    let most_delay = most_delay_deviation(period);
    let is_known = delay <= most_delay && of_mass <= MAX_MASS_DEVIATION;
    if !is_known {
        return Err(Declined::Uncertain {
            delay: delay * period,
            mass: of_mass,
        });
    }
    Ok(())
}

/// Standard deviation of delay and lag above which neither is reported `[periods]`.
fn most_delay_deviation(period: f64) -> f64 {
    MAX_DELAY_DEVIATION.max(MAX_DELAY_DEVIATION_SECONDS / period)
}

fn deviation(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / n).sqrt()
}

/// Returns a first guess of the sensor's standard deviation `[m]`, from its steps or from second differences.
///
/// A linkage with an encoder on each joint has steps of varying size. While no joint makes a step, a second difference
/// is 0, so the median alone can be uninformative.
fn sensor_noise(positions: &[f64], quantum: Option<f64>) -> f64 {
    if let Some(quantum) = quantum {
        return quantum / 12.0_f64.sqrt();
    }
    let mut squares: Vec<f64> = positions
        .windows(3)
        .map(|x| (x[2] - 2.0 * x[1] + x[0]).powi(2))
        .collect();
    squares.sort_by(f64::total_cmp);
    let median = squares.get(squares.len() / 2).copied().unwrap_or(0.0);
    let mean = squares.iter().sum::<f64>() / squares.len().max(1) as f64;
    let square = (0.3 * median / 0.455).max(MIN_OF_MEAN * mean);
    (square / 6.0).sqrt().max(1e-9)
}

impl Fit {
    /// Whether the fit has a resonance.
    pub fn is_flexible(&self) -> bool {
        self.kind == Kind::Flexible
    }

    /// Returns the resonance of two free masses `[Hz]`.
    pub fn resonance(&self) -> f64 {
        let alone = self.point[at::LN_ANTIRESONANCE].exp() / std::f64::consts::TAU;
        alone / (1.0 - self.fraction()).sqrt()
    }

    /// Returns the fraction of the mass beyond the transmission.
    pub fn fraction(&self) -> f64 {
        1.0 / (1.0 + (-self.point[at::LOGIT_FRACTION]).exp())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_guess_of_a_sensor_with_steps_of_several_sizes_is_near_to_them() {
        let steps = [8.3e-5, 5.7e-5];
        // Fast: most second differences have a step. Slow: most have none, and their median is 0.
        for rate in [0.02, 0.001] {
            let position = |i: usize| {
                let x = 0.003 * (i as f64 * rate).sin() + 0.0004 * (i as f64 * 0.25 * rate).sin();
                let joint = |step: f64| (0.5 * x / step).floor() * step;
                joint(steps[0]) + joint(steps[1])
            };
            let positions: Vec<f64> = (0..4000).map(position).collect();
            assert_eq!(quantum(&positions), None, "{rate}");
            let guess = sensor_noise(&positions, None);
            assert!((1e-6..3e-5).contains(&guess), "{rate}: {guess}");
        }
    }
}
