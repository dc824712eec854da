//! Initial values of the fit: gain over mass and delay by linear least squares.

use nalgebra::{DMatrix, DVector};

use crate::calibrate::filter::Samples;
use crate::calibrate::model::LENGTH;

/// Time between the three positions of a second difference `[s]`: long relative to the sensor's steps, short relative
/// to the hand's motion.
const SPACING: f64 = 0.012;
/// Maximum number of samples.
const MAX_SAMPLES: usize = 8000;
/// Number of columns: the motion by the command, its derivative by the delay, a constant, the position and the
/// velocity.
const COLUMNS: usize = 5;

/// Returns ln of gain over mass `[ln 1/kg]`, and delay plus lag `[periods]` up to `most_delay`. Returns `None` if the
/// device did not move with the commands.
pub fn start(samples: &Samples, period: f64, most_delay: f64) -> Option<(f64, f64)> {
    let differences = Differences::new(samples, period, most_delay);
    let mut best: Option<(f64, f64)> = None;
    let mut delay = 0.0;
    while delay <= most_delay {
        let left = differences.solve(delay)?.1;
        if best.is_none_or(|(least, _)| left < least) {
            best = Some((left, delay));
        }
        delay += 0.5;
    }
    let (_, mut delay) = best?;
    let mut mobility = 0.0;
    for _ in 0..5 {
        let (solution, _) = differences.solve(delay)?;
        mobility = solution[0];
        let step = solution[1] / solution[0];
        if !step.is_finite() {
            return None;
        }
        delay = (delay + step.clamp(-0.5, 0.5)).clamp(0.02, most_delay);
    }
    let mobility = mobility * LENGTH / (period * period);
    (mobility > 0.0 && mobility.is_finite()).then(|| (mobility.ln(), delay))
}

struct Differences<'a> {
    samples: &'a Samples,
    spacing: usize,
    first: usize,
    stride: usize,
}

impl<'a> Differences<'a> {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "numbers of samples"
    )]
    fn new(samples: &'a Samples, period: f64, most_delay: f64) -> Self {
        let spacing = ((SPACING / period).round() as usize).max(3);
        Self {
            samples,
            spacing,
            first: 2 * spacing + most_delay.ceil() as usize + 2,
            stride: samples.positions.len().div_ceil(MAX_SAMPLES),
        }
    }

    /// Returns the solution for a delay and the residual sum of squares.
    fn solve(&self, delay: f64) -> Option<(DVector<f64>, f64)> {
        let (x, spacing) = (&self.samples.positions, self.spacing);
        let motion = self.kernel(delay);
        let later = self.kernel(delay + 0.1);
        let earlier = self.kernel((delay - 0.1).max(0.0));
        let between = 0.1 + delay.min(0.1);
        let by_delay: Vec<f64> = later
            .iter()
            .zip(&earlier)
            .map(|(later, earlier)| (later - earlier) / between)
            .collect();
        let mut normal = DMatrix::<f64>::zeros(COLUMNS, COLUMNS);
        let mut right = DVector::<f64>::zeros(COLUMNS);
        let mut squares = 0.0;
        for i in (self.first..x.len()).step_by(self.stride) {
            let y = x[i] - 2.0 * x[i - spacing] + x[i - 2 * spacing];
            let row = [
                self.moved(&motion, i),
                self.moved(&by_delay, i),
                1.0,
                x[i - spacing] * 1e-3,
                (x[i] - x[i - 2 * spacing]) * 1e-3,
            ];
            for a in 0..COLUMNS {
                right[a] += row[a] * y;
                for b in 0..COLUMNS {
                    normal[(a, b)] += row[a] * row[b];
                }
            }
            squares += y * y;
        }
        let solution = normal.cholesky()?.solve(&right);
        let left = squares - solution.dot(&right);
        Some((solution, left))
    }

    fn moved(&self, kernel: &[f64], i: usize) -> f64 {
        kernel
            .iter()
            .zip(self.samples.commands[..=i].iter().rev())
            .map(|(weight, command)| weight * command)
            .sum()
    }

    /// Returns the response of the second difference, at each later sample, to a command of 1 held for a period.
    fn kernel(&self, delay: f64) -> Vec<f64> {
        let length = self.first;
        let after_step = |t: f64| if t > 0.0 { 0.5 * t * t } else { 0.0 };
        let spacing = self.spacing as f64;
        let difference =
            |t: f64| after_step(t) - 2.0 * after_step(t - spacing) + after_step(t - 2.0 * spacing);
        (0..length)
            .map(|k| k as f64 - delay)
            .map(|t| difference(t) - difference(t - 1.0))
            .collect()
    }
}
