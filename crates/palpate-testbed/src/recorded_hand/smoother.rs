//! Fixed-interval smoother of a recorded motion. It estimates position, velocity and unknown force from all samples at
//! once. A sample may lack its position; the known force of that interval is still used.
//!
//! State: position, velocity, and the acceleration a due to all forces except the known force u, which is held over
//! each interval. The jerk of a is constant over an interval and independent between intervals, with a spectral density
//! S. Positions are measured with a standard deviation σ. Only S/σ² shapes the estimate; expressed as a bandwidth it is
//! that of the quintic smoothing spline, ω⁶ = S/(σ² h). The forward pass is a Kalman filter, the backward pass the
//! recursion of Bryson and Frazier, which needs no matrix inverse.
//!
//! Jerk is the only random quantity, so the estimates form one motion: each interval follows from the previous one by a
//! jerk. The estimated force, held against the same mass, therefore reproduces the motion.
//! before it by a jerk, so the force they give, held against the same mass, gives the motion back.

use std::f64::consts::PI;

/// Variances of the first state, over that of a position and in mean steps: as good as unknown.
const UNKNOWN: f64 = 1e6;

/// Number of samples that determine the first state; they do not contribute to the noise estimate.
const STARTING: usize = 3;

/// Bandwidths that are tried before the best of them is refined.
const TRIED: usize = 17;

/// Refinements of a bandwidth; each narrows it to 0.62.
const REFINED: usize = 20;

type Vector = [f64; 3];
type Matrix = [[f64; 3]; 3];

/// A motion to be smoothed.
pub(super) struct MeasuredTrajectory<'a> {
    /// Times `[s]`, increasing.
    pub times: &'a [f64],
    /// Positions `[m]`, NaN where none was measured; the first was.
    pub positions: &'a [f64],
    /// Acceleration by the known force from each sample to the next `[m/s²]`.
    pub known: &'a [f64],
    /// Least deviation that a position can have `[m]`.
    pub least_noise: f64,
}

/// A smoothed motion.
pub(super) struct Smoothed {
    /// Position `[m]`, velocity `[m/s]` and acceleration due to the unknown force `[m/s²]` at each sample.
    pub states: Vec<Vector>,
    /// Their standard deviations.
    pub deviations: Vec<Vector>,
    /// Standard deviation of a recorded position `[m]`.
    pub noise: f64,
    /// Bandwidth `[Hz]`.
    pub bandwidth: f64,
}

impl MeasuredTrajectory<'_> {
    /// Between positions that were measured `[s]`.
    fn mean_step(&self) -> f64 {
        let measured = self.positions.iter().filter(|position| !position.is_nan());
        (self.times[self.times.len() - 1] - self.times[0]) / (measured.count() - 1) as f64
    }

    /// Returns the range of distinguishable bandwidths `[Hz]`: from one cycle over the recording to half of the
    /// sampling rate.
    fn bandwidths(&self) -> [f64; 2] {
        let step = self.mean_step();
        let duration = self.times[self.times.len() - 1] - self.times[0];
        [1.0 / duration, 0.5 / step]
    }

    /// S/σ² over the fifth power of the mean step, for a bandwidth `[Hz]`.
    fn roughness(&self, bandwidth: f64) -> f64 {
        (2.0 * PI * bandwidth * self.mean_step()).powi(6)
    }

    /// The bandwidth under which the recording is most likely `[Hz]`.
    pub fn likeliest_bandwidth(&self) -> f64 {
        let [low, high] = self.bandwidths().map(f64::ln);
        let unlikelihood = |log: f64| self.filter(self.roughness(log.exp()), None).unlikelihood;
        let spacing = (high - low) / (TRIED - 1) as f64;
        let tried = (0..TRIED).map(|i| low + spacing * i as f64);
        let best = tried
            .map(|log| (unlikelihood(log), log))
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map_or(high, |(_, log)| log);
        let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
        let (mut from, mut to) = ((best - spacing).max(low), (best + spacing).min(high));
        for _ in 0..REFINED {
            let (a, b) = (to - golden * (to - from), from + golden * (to - from));
            if unlikelihood(a) < unlikelihood(b) {
                to = b;
            } else {
                from = a;
            }
        }
        (0.5 * (from + to)).exp()
    }

    /// The motion smoothed with a bandwidth `[Hz]`.
    pub fn smoothed(&self, bandwidth: f64) -> Smoothed {
        let step = self.mean_step();
        let mut kept = Vec::with_capacity(self.times.len());
        let noise = self
            .filter(self.roughness(bandwidth), Some(&mut kept))
            .noise;
        // Of mean steps, and of the state before the last sample.
        let scales = [1.0, 1.0 / step, 1.0 / (step * step)];
        let (mut states, mut deviations) = (Vec::new(), Vec::new());
        let (mut gradient, mut information) = ([0.0; 3], [[0.0; 3]; 3]);
        for (index, at) in kept.iter().enumerate().rev() {
            // Behind the sample's own measurement.
            let gain: Vector = std::array::from_fn(|i| at.covariance[i][0] / at.variance);
            let mut kept_back = identity();
            for (row, gain) in kept_back.iter_mut().zip(gain) {
                row[0] -= gain;
            }
            gradient = times_vector(&transposed(&kept_back), &gradient);
            gradient[0] -= at.innovation / at.variance;
            information = times(&times(&transposed(&kept_back), &information), &kept_back);
            information[0][0] += 1.0 / at.variance;
            let correction = times_vector(&at.covariance, &gradient);
            let known = times(&times(&at.covariance, &information), &at.covariance);
            states.push(std::array::from_fn(|i| {
                let origin = if i == 0 { self.positions[0] } else { 0.0 };
                origin + (at.state[i] - correction[i]) * scales[i]
            }));
            deviations.push(std::array::from_fn(|i| {
                let variance = at.covariance[i][i] - known[i][i];
                noise * variance.max(0.0).sqrt() * scales[i]
            }));
            if index > 0 {
                let transition = transition((self.times[index] - self.times[index - 1]) / step);
                gradient = times_vector(&transposed(&transition), &gradient);
                information = times(&times(&transposed(&transition), &information), &transition);
            }
        }
        states.reverse();
        deviations.reverse();
        Smoothed {
            states,
            deviations,
            noise,
            bandwidth,
        }
    }

    /// The filter for one roughness, in mean steps and with a unit variance of positions.
    fn filter(&self, roughness: f64, mut kept: Option<&mut Vec<Predicted>>) -> Filtered {
        let step = self.mean_step();
        let mut state = [0.0; 3];
        let mut covariance = [[0.0; 3]; 3];
        for (i, row) in covariance.iter_mut().enumerate() {
            row[i] = UNKNOWN;
        }
        let (mut squares, mut logarithms, mut counted, mut measured) = (0.0, 0.0, 0, 0);
        for (index, position) in self.positions.iter().enumerate() {
            if index > 0 {
                let h = (self.times[index] - self.times[index - 1]) / step;
                let known = self.known[index - 1] * step * step;
                let forward = transition(h);
                state = times_vector(&forward, &state);
                state[0] += 0.5 * h * h * known;
                state[1] += h * known;
                covariance = times(&times(&forward, &covariance), &transposed(&forward));
                // A jerk of variance roughness/h, constant over the interval.
                let by_jerk = [h * h * h / 6.0, 0.5 * h * h, h];
                for (row, a) in covariance.iter_mut().zip(by_jerk) {
                    for (entry, b) in row.iter_mut().zip(by_jerk) {
                        *entry += roughness / h * a * b;
                    }
                }
            }
            // A position that was not measured may be any.
            let (innovation, variance) = if position.is_nan() {
                (0.0, f64::INFINITY)
            } else {
                let innovation = position - self.positions[0] - state[0];
                (innovation, covariance[0][0] + 1.0)
            };
            if let Some(kept) = &mut kept {
                kept.push(Predicted {
                    state,
                    covariance,
                    innovation,
                    variance,
                });
            }
            measured += usize::from(variance.is_finite());
            if measured > STARTING && variance.is_finite() {
                squares += innovation * innovation / variance;
                logarithms += variance.ln();
                counted += 1;
            }
            let column: Vector = std::array::from_fn(|i| covariance[i][0]);
            for i in 0..3 {
                state[i] += column[i] / variance * innovation;
                for j in 0..3 {
                    covariance[i][j] -= column[i] * column[j] / variance;
                }
            }
        }
        let counted = f64::from(counted.max(1));
        let likeliest = squares / counted;
        let noise = likeliest
            .max(self.least_noise * self.least_noise)
            .max(f64::MIN_POSITIVE);
        Filtered {
            unlikelihood: counted * noise.ln() + squares / noise + logarithms,
            noise: noise.sqrt(),
        }
    }
}

/// Result of a filter over the whole recording.
struct Filtered {
    /// Twice the negative logarithm of its likelihood, but for a constant.
    unlikelihood: f64,
    /// Standard deviation of a position `[m]`.
    noise: f64,
}

/// Prediction of a sample before its measurement.
struct Predicted {
    state: Vector,
    covariance: Matrix,
    innovation: f64,
    variance: f64,
}

fn transition(h: f64) -> Matrix {
    [[1.0, h, 0.5 * h * h], [0.0, 1.0, h], [0.0, 0.0, 1.0]]
}

fn identity() -> Matrix {
    transition(0.0)
}

fn transposed(a: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| a[j][i]))
}

fn times(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

fn times_vector(a: &Matrix, b: &Vector) -> Vector {
    std::array::from_fn(|i| (0..3).map(|k| a[i][k] * b[k]).sum())
}
