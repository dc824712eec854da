//! The steady Kalman filter of a model, its innovations over the samples, and the smoothed velocity.

use nalgebra::{DMatrix, DVector};

use crate::calibrate::model::{Kind, LENGTH, Sampled};

/// Maximum number of doublings until the covariance converges; each one doubles the elapsed time.
const MAX_DOUBLINGS: usize = 40;

/// Input of the filter.
#[derive(Clone, Debug)]
pub struct Samples {
    /// Positions relative to the first one `[LENGTH]`.
    pub positions: Vec<f64>,
    /// Command at each sample `[N]`.
    pub commands: Vec<f64>,
    /// Mean sign of the velocity over the period that follows each sample.
    pub signs: Vec<f64>,
    /// Cosine and sine of the cogging phase at the middle of that period.
    pub phases: Vec<[f64; 2]>,
}

impl Samples {
    /// Creates samples from positions `[m]` and commands `[N]`.
    pub fn new(positions: &[f64], commands: &[f64]) -> Self {
        Self {
            positions: positions
                .iter()
                .map(|x| (x - positions[0]) / LENGTH)
                .collect(),
            commands: commands.to_vec(),
            signs: vec![0.0; positions.len()],
            phases: vec![[0.0; 2]; positions.len()],
        }
    }
}

/// Steady-state filter of a model.
#[derive(Clone, Debug)]
pub struct Steady {
    /// Covariance before a sample, over the variance of the sensor.
    before: DMatrix<f64>,
    /// Gain of the innovation for each state.
    gain: DVector<f64>,
}

/// Computes the steady-state covariance by the doubling algorithm (Anderson and Moore, *Optimal Filtering*, section
/// 6.7). Returns `None` if it does not converge.
pub fn steady(model: &Sampled) -> Option<Steady> {
    let n = model.transition.nrows();
    let identity = DMatrix::<f64>::identity(n, n);
    let mut a = model.transition.transpose();
    let mut g = DMatrix::<f64>::zeros(n, n);
    g[(0, 0)] = 1.0;
    let mut before = model.noise.clone();
    for _ in 0..MAX_DOUBLINGS {
        let lu = (&identity + &g * &before).lu();
        let w_a = lu.solve(&a)?;
        let w_g = lu.solve(&g)?;
        let change = a.transpose() * &before * &w_a;
        let next_g = &g + &a * w_g * a.transpose();
        a = &a * w_a;
        g = (&next_g + next_g.transpose()) * 0.5;
        before += (&change + change.transpose()) * 0.5;
        let of_position = before[(0, 0)];
        if !of_position.is_finite() {
            return None;
        }
        if (0..n).all(|i| change[(i, i)].abs() <= 1e-9 * before[(i, i)]) {
            break;
        }
    }
    let gain = before.column(0) / (before[(0, 0)] + 1.0);
    Some(Steady { before, gain })
}

/// Computes the innovations `[LENGTH]` of all samples; the filter starts at rest at the first position.
pub fn innovations(kind: Kind, model: &Sampled, gain: &Steady, samples: &Samples) -> Vec<f64> {
    let mut found = Vec::with_capacity(samples.positions.len());
    let take = |innovation: f64, _: &[f64]| found.push(innovation);
    match kind {
        Kind::Rigid => pass::<6>(model, gain, samples, take),
        Kind::Flexible => pass::<8>(model, gain, samples, take),
    }
    found
}

/// Runs the filter; `take` receives each innovation and the state before its correction.
fn pass<const N: usize>(
    model: &Sampled,
    steady: &Steady,
    samples: &Samples,
    mut take: impl FnMut(f64, &[f64]),
) {
    // Column order: the sum over columns has no dependent chain of additions within a row.
    let columns: [[f64; N]; N] =
        std::array::from_fn(|j| std::array::from_fn(|i| model.transition[(i, j)]));
    let new: [f64; N] = std::array::from_fn(|i| model.new_command[i]);
    let old: [f64; N] = std::array::from_fn(|i| model.old_command[i]);
    let push: [f64; N] = std::array::from_fn(|i| model.push[i]);
    let [cosine, sine] = model.cogging;
    let gain: [f64; N] = std::array::from_fn(|i| steady.gain[i]);
    let commands = &samples.commands;
    let command = |index: Option<usize>| index.map_or(0.0, |index| commands[index]);
    let mut state = [0.0; N];
    for (index, &position) in samples.positions.iter().enumerate() {
        if index > 0 {
            let begins = (index - 1).checked_sub(model.whole_delay);
            let u_new = command(begins);
            let u_old = command(begins.and_then(|begins| begins.checked_sub(1)));
            let [cos, sin] = samples.phases[index - 1];
            let pushed = cosine * cos + sine * sin - model.friction * samples.signs[index - 1];
            let mut next: [f64; N] =
                std::array::from_fn(|i| new[i] * u_new + old[i] * u_old + push[i] * pushed);
            for (column, value) in columns.iter().zip(state) {
                for (sum, entry) in next.iter_mut().zip(column) {
                    *sum += entry * value;
                }
            }
            state = next;
        }
        let innovation = position - state[0];
        take(innovation, &state);
        for (value, gain) in state.iter_mut().zip(gain) {
            *value += gain * innovation;
        }
    }
}

/// Smoothed velocity with its uncertainty.
pub struct Velocity {
    /// Velocity at each sample `[LENGTH / period]`.
    pub values: Vec<f64>,
    /// Standard deviation for a sensor deviation of `1` `[periods^-1]`.
    pub deviation: f64,
}

/// Computes the velocity from all samples by the steady fixed-interval smoother (Bierman, *Fixed interval smoothing
/// with discrete measurements*, 1973), which inverts no covariance.
pub fn smoothed_velocity(
    kind: Kind,
    model: &Sampled,
    steady: &Steady,
    samples: &Samples,
) -> Velocity {
    match kind {
        Kind::Rigid => smooth::<6>(model, steady, samples),
        Kind::Flexible => smooth::<8>(model, steady, samples),
    }
}

fn smooth<const N: usize>(model: &Sampled, steady: &Steady, samples: &Samples) -> Velocity {
    let mut velocities = Vec::with_capacity(samples.positions.len());
    let mut innovations = Vec::with_capacity(samples.positions.len());
    pass::<N>(model, steady, samples, |innovation, state| {
        innovations.push(innovation);
        velocities.push(state[1]);
    });
    let before = &steady.before;
    let variance = steady.innovation_variance();
    // Transition from the state before one sample to the state before the next one.
    let mut corrected = DMatrix::<f64>::identity(N, N);
    let mut first = corrected.column_mut(0);
    first -= &steady.gain;
    let over = &model.transition * corrected;
    let rows: [[f64; N]; N] = std::array::from_fn(|j| std::array::from_fn(|i| over[(j, i)]));
    let of_velocity: [f64; N] = std::array::from_fn(|i| before[(1, i)]);
    // Information about the state from this sample and all later ones.
    let mut later = [0.0; N];
    for (velocity, innovation) in velocities.iter_mut().zip(&innovations).rev() {
        let mut here = [0.0; N];
        for (row, value) in rows.iter().zip(later) {
            for (sum, entry) in here.iter_mut().zip(row) {
                *sum += entry * value;
            }
        }
        here[0] += innovation / variance;
        later = here;
        let change: f64 = of_velocity.iter().zip(later).map(|(p, l)| p * l).sum();
        *velocity += change;
    }
    let mut information = DMatrix::<f64>::zeros(N, N);
    let row = before.row(1);
    let mut left = before[(1, 1)];
    for _ in 0..1000 {
        information = over.transpose() * &information * &over;
        information[(0, 0)] += 1.0 / variance;
        let now = before[(1, 1)] - (row * &information * row.transpose())[(0, 0)];
        let is_settled = (now - left).abs() <= 1e-4 * now.abs();
        left = now;
        if is_settled {
            break;
        }
    }
    Velocity {
        values: velocities,
        deviation: left.max(0.0).sqrt(),
    }
}

impl Steady {
    /// Returns the variance of an innovation over that of the sensor.
    pub fn innovation_variance(&self) -> f64 {
        self.before[(0, 0)] + 1.0
    }
}
