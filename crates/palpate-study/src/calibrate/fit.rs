//! The fit: the likelihood of the Kalman filter's innovations, as nonlinear least squares.
//!
//! In the steady state the variance of the innovations is the same at every sample, so the maximum likelihood is the
//! minimum of their sum of squares, over the device parameters as well as the noise levels: only the ratios of noise
//! levels change the innovations. Weak priors determine parameters without information in the data.

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn};

use crate::calibrate::cogging;
use crate::calibrate::filter::{self, Samples};
use crate::calibrate::model::{self, FLEXIBLE, Kind, LENGTH, Point, at};

/// Rounds of fit and velocity signs.
const ROUNDS: usize = 4;
/// Correlation time of the scores `[s]`.
const CORRELATED: f64 = 0.03;
/// Initial values of damping `[1/s]` and stiffness `[1/s^2]` over mass.
const FIRST_DAMPING: f64 = 5.0;
const FIRST_STIFFNESS: f64 = 100.0;
/// Factor on the deviations of the fit, and model errors of delay `[periods]` and of ln mass from cogging and static
/// friction. Chosen on virtual devices so that two deviations cover the error in at least 85 of 100
/// (`examples/plants.rs`).
const WIDER: f64 = 1.25;
const DELAY_MODEL: f64 = 0.002;
const DELAY_MODEL_PERIOD: f64 = 0.004;
const MASS_MODEL: f64 = 0.003;
/// Longest lag in the search `[s]`.
const MAX_LAG: f64 = 0.006;
/// Deviations from the prior mean up to which the prior of a lag is normal. Motors beyond it are rare but exist, so
/// from there the cost grows only with the logarithm of the distance.
const NORMAL_LAG: f64 = 3.0;
/// Fractions of a period at which the sign of the velocity is evaluated.
const PARTS: [f64; 8] = [
    0.0625, 0.1875, 0.3125, 0.4375, 0.5625, 0.6875, 0.8125, 0.9375,
];

/// The least-squares problem of the fit.
#[derive(Clone, Debug)]
pub struct Problem {
    kind: Kind,
    samples: Samples,
    period: f64,
    /// Samples whose innovations count.
    counted: std::ops::Range<usize>,
    /// Mean and standard deviation of the priors.
    prior: [(f64, f64); FLEXIBLE],
    bounds: [(f64, f64); FLEXIBLE],
    point: Point,
    /// Standard deviation of an innovation `[LENGTH]`.
    scale: f64,
}

/// A fit.
#[derive(Clone, Debug)]
pub struct Fit {
    /// Whether the device has a flexible transmission.
    pub kind: Kind,
    /// The parameters.
    pub point: Point,
    /// Their standard deviations.
    pub deviation: Point,
    /// Mean square of the innovations `[LENGTH^2]`.
    pub innovation: f64,
    /// Standard deviation of the sensor's error `[m]`.
    pub sensor_noise: f64,
    /// Number of counted innovations.
    pub count: usize,
    /// Positions predicted by the filter, from the first sample on `[m]`.
    pub foreseen: Vec<f64>,
    /// The problem at its solution.
    pub solved: Problem,
}

impl Fit {
    /// Returns the upper limit of the lag `[s]` if the fit has reached it.
    pub fn longest_lag(&self, period: f64) -> Option<f64> {
        let square = self.point[at::LAG_SQUARED] * period * period;
        (square >= 0.99 * MAX_LAG * MAX_LAG).then_some(MAX_LAG)
    }

    /// Returns the negative log-likelihood without the terms common to all fits of these samples.
    pub fn cost(&self) -> f64 {
        0.5 * self.count as f64 * self.innovation.ln()
    }
}

/// Creates the problem at its initial point.
pub fn problem(
    samples: Samples,
    period: f64,
    counted: std::ops::Range<usize>,
    (ln_mobility, delay): (f64, f64),
    sensor: f64,
    most_delay: f64,
) -> Problem {
    let t = period;
    let r = sensor * sensor;
    let ms2 = (1e-3 / t).powi(2);
    let ln_nyquist = (0.45 / t).ln();
    let prior = [
        (ln_mobility, 1.5),
        (delay, 2.0),
        (0.06 * ms2, 0.1 * ms2),
        (0.0, 60.0),
        (0.0, 6000.0),
        (0.0, 3.0),
        (0.0, 2.0),
        (0.0, 2.0),
        ((20.0 * t.powi(5) / r).ln(), 6.0),
        ((1e3 * t.powi(7) / r).ln(), 6.0),
        ((1e-6 * t.powi(3) / r).ln(), 6.0),
        (10.0_f64.ln(), 0.25),
        (0.1_f64.ln(), 0.8),
        (0.0, 2.0),
        (900.0_f64.ln(), 0.7),
        (0.05, 0.1),
    ];
    let free = (f64::NEG_INFINITY, f64::INFINITY);
    let bounds = [
        (ln_mobility - 2.0, ln_mobility + 2.0),
        (0.01, most_delay + 1.0),
        (0.0, (MAX_LAG / t).powi(2)),
        free,
        free,
        free,
        free,
        free,
        (-50.0, 30.0),
        (-50.0, 30.0),
        (-50.0, 30.0),
        (5.0_f64.ln(), 16.0_f64.ln().min(ln_nyquist)),
        (0.01_f64.ln(), 0.4_f64.ln()),
        (-4.0, 4.0),
        (
            MIN_ANTIRESONANCE.ln(),
            (0.4 * std::f64::consts::TAU / t).min(4000.0).ln(),
        ),
        (0.002, 0.5),
    ];
    let mut point = prior.map(|(centre, _)| centre);
    point[at::LAG_SQUARED] = (0.02 * ms2).min(0.5 * delay * delay);
    point[at::DAMPING] = FIRST_DAMPING;
    point[at::STIFFNESS] = FIRST_STIFFNESS;
    point[at::LOGIT_FRACTION] = -0.5;
    point[at::FLEXIBLE_DAMPING] = 0.03;
    Problem {
        kind: Kind::Rigid,
        samples,
        period,
        counted,
        prior,
        bounds,
        point,
        scale: sensor / LENGTH,
    }
}

impl Problem {
    /// Returns the period `[s]`.
    pub fn period(&self) -> f64 {
        self.period
    }

    /// Returns the largest command `[N]`.
    pub fn largest_command(&self) -> f64 {
        let commands = self.samples.commands.iter();
        commands.fold(0.0, |most, force| most.max(force.abs()))
    }

    /// Returns [`Fit::cost`] with commands clipped at `level` `[N]` and ln mobility increased by `more`. Returns `None`
    /// if the filter has no steady state.
    pub fn cost_of(&self, level: f64, more: f64) -> Option<f64> {
        let mut clipped = self.clone();
        for command in &mut clipped.samples.commands {
            *command = command.clamp(-level, level);
        }
        clipped.bounds[at::LN_MOBILITY].1 += more;
        clipped.point[at::LN_MOBILITY] += more;
        clipped.rescale()?;
        let count = self.counted.len() as f64;
        Some(count * clipped.scale.ln())
    }

    /// Returns the problems for the first and the second half of the motion.
    pub fn halves(&self) -> [Self; 2] {
        let middle = self.counted.start + self.counted.len() / 2;
        [self.counted.start..middle, middle..self.counted.end].map(|counted| Self {
            counted,
            ..self.clone()
        })
    }

    /// Refits from this point, with the present velocity signs.
    pub fn refitted(self) -> Option<Fit> {
        let mut found = self.minimised(2)?;
        found.rescale()?;
        found.finish()
    }

    fn free(&self) -> usize {
        self.kind.parameters()
    }

    fn inside(&self, point: &Point) -> Point {
        std::array::from_fn(|i| point[i].clamp(self.bounds[i].0, self.bounds[i].1))
    }

    /// Returns the counted innovations `[LENGTH]`, or `None` if the filter has no steady state.
    fn innovations(&self, point: &Point) -> Option<Vec<f64>> {
        let model = model::sampled(self.kind, &self.inside(point), self.period);
        let steady = filter::steady(&model)?;
        let mut all = filter::innovations(self.kind, &model, &steady, &self.samples);
        all.truncate(self.counted.end);
        all.drain(..self.counted.start);
        all.iter().all(|e| e.is_finite()).then_some(all)
    }

    /// Returns the innovations, then the distances from the priors and from the bounds, each over its deviation.
    fn weighted(&self, point: &Point) -> Option<DVector<f64>> {
        let found = self.innovations(point)?;
        let free = self.free();
        let inside = self.inside(point);
        let innovations = found.into_iter().map(|e| e / self.scale);
        let unlikely = (0..free).map(|i| {
            let distance = (point[i] - self.prior[i].0) / self.prior[i].1;
            if i == at::LAG_SQUARED && distance > NORMAL_LAG {
                // The slope is continuous where the two branches meet.
                NORMAL_LAG * (1.0 + 2.0 * (distance / NORMAL_LAG).ln()).sqrt()
            } else {
                distance
            }
        });
        let outside = (0..free).map(|i| 30.0 * (point[i] - inside[i]) / self.prior[i].1);
        let count = self.counted.len() + 2 * free;
        Some(DVector::from_iterator(
            count,
            innovations.chain(unlikely).chain(outside),
        ))
    }

    /// Returns the parameter step for a derivative.
    fn step(&self, parameter: usize) -> f64 {
        match parameter {
            at::LN_MOBILITY | at::DELAY_PLUS_LAG => 1e-3,
            at::LAG_SQUARED => 0.05 * self.prior[parameter].1,
            at::DAMPING => 0.05,
            at::STIFFNESS => 2.0,
            at::FRICTION | at::FLEXIBLE_DAMPING | at::LN_ANTIRESONANCE => 5e-3,
            cogging if at::COGGING.contains(&cogging) => 5e-3,
            at::LN_TREMOR_FREQUENCY => 1e-2,
            _ => 2e-2,
        }
    }

    fn slopes(&self) -> Option<DMatrix<f64>> {
        let here = self.weighted(&self.point)?;
        let mut slopes = DMatrix::<f64>::zeros(here.len(), self.free());
        for parameter in 0..self.free() {
            let mut point = self.point;
            // Step away from the upper bound, where the model no longer changes.
            let step = self.step(parameter);
            let step = if point[parameter] + step > self.bounds[parameter].1 {
                -step
            } else {
                step
            };
            point[parameter] += step;
            let there = self.weighted(&point)?;
            slopes.set_column(parameter, &((there - &here) / step));
        }
        Some(slopes)
    }

    /// Sets the scale to that of the innovations.
    fn rescale(&mut self) -> Option<()> {
        let found = self.innovations(&self.point)?;
        let mean = found.iter().map(|e| e * e).sum::<f64>() / found.len() as f64;
        self.scale = mean.sqrt().max(1e-9);
        Some(())
    }

    fn minimised(mut self, patience: usize) -> Option<Self> {
        self.rescale()?;
        let (mut found, _) = LevenbergMarquardt::new()
            .with_ftol(2e-8)
            .with_xtol(1e-8)
            .with_gtol(0.0)
            .with_patience(patience)
            .minimize(self);
        found.point = found.inside(&found.point);
        Some(found)
    }

    /// Estimates the mean sign of the velocity over each period from the slope over a few samples, for the friction
    /// term before a model exists.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a number of samples"
    )]
    fn first_signs(&mut self, sensor: f64) {
        let half = ((0.004 / self.period).round() as usize).clamp(2, 40);
        let x = &self.samples.positions;
        let squares: f64 = (1..=half).map(|k| 2.0 * (k * k) as f64).sum();
        let slope = |i: usize| {
            let at = |k: usize| x[k.min(x.len() - 1)];
            let sum: f64 = (1..=half)
                .map(|k| k as f64 * (at(i + k) - at(i.saturating_sub(k))))
                .sum();
            sum / squares
        };
        let slopes: Vec<f64> = (0..x.len()).map(slope).collect();
        let known = (1.5 * sensor / LENGTH / squares.sqrt()).max(2e-3 * self.period / LENGTH);
        let after = |i: usize| slopes[(i + 1).min(slopes.len() - 1)];
        self.samples.signs = (0..slopes.len())
            .map(|i| (0.5 * (slopes[i] + after(i)) / known).tanh())
            .collect();
    }

    /// Computes the mean sign of the velocity over each period from the smoothed velocity and its standard deviation.
    fn smoothed_signs(&mut self) -> Option<()> {
        let model = model::sampled(self.kind, &self.point, self.period);
        let steady = filter::steady(&model)?;
        let velocity = filter::smoothed_velocity(self.kind, &model, &steady, &self.samples);
        let r = self.sensor_deviation(&steady);
        let metres_per_second = LENGTH / self.period;
        let known =
            (velocity.deviation * r).clamp(2e-4 / metres_per_second, 0.02 / metres_per_second);
        let values = &velocity.values;
        if values.iter().any(|v| !v.is_finite()) {
            return None;
        }
        let sign = |v: f64| libm::erf(v / (std::f64::consts::SQRT_2 * known));
        let kinks = self.kinks();
        self.samples.signs = (0..values.len())
            .map(|i| {
                let (v, next) = (values[i], values[(i + 1).min(values.len() - 1)]);
                let (at, change) = kinks.of(i);
                // Two slopes between the velocities; they differ by the effect of the new force.
                let before = next - v - (1.0 - at) * change;
                PARTS
                    .map(|part| sign(v + before * part + change * (part - at).max(0.0)))
                    .iter()
                    .sum::<f64>()
                    / PARTS.len() as f64
            })
            .collect();
        Some(())
    }

    /// Searches for cogging; if there is none, its parameters stay at 0.
    fn find_cogging(&mut self) -> Option<()> {
        let model = model::sampled(self.kind, &self.point, self.period);
        let steady = filter::steady(&model)?;
        match cogging::pitch(self.kind, &model, &steady, &self.samples, &self.counted) {
            Some(pitch) => self.samples.phases = cogging::phases(&self.samples, pitch),
            None => {
                self.samples.phases.fill([0.0; 2]);
                for at in at::COGGING {
                    self.point[at] = 0.0;
                }
            }
        }
        Some(())
    }

    /// Returns the instants within a period at which the force changes.
    fn kinks(&self) -> Kinks<'_> {
        let mobility = self.point[at::LN_MOBILITY].exp() * self.period * self.period / LENGTH;
        Kinks {
            commands: &self.samples.commands,
            delay: self.point[at::DELAY_PLUS_LAG],
            mobility,
        }
    }

    /// Returns the sensor deviation `[LENGTH]` implied by the scale of the innovations.
    fn sensor_deviation(&self, steady: &filter::Steady) -> f64 {
        self.scale / steady.innovation_variance().sqrt()
    }

    /// Fits from this point and recomputes the velocity signs in each round.
    fn fitted(mut self, rounds: usize) -> Option<Self> {
        for round in 0..rounds {
            self = self.minimised(4)?;
            if round + 1 < rounds {
                self.smoothed_signs()?;
                // Once with a rough model and once with a good one.
                if round % 2 == 0 {
                    self.find_cogging()?;
                }
            }
        }
        self.rescale()?;
        Some(self)
    }

    /// Returns the fit at this point with its deviations.
    fn finish(self) -> Option<Fit> {
        let slopes = self.slopes()?;
        let count = self.counted.len();
        let free = self.free();
        // The rows of the bounds carry no information about the data.
        let information = slopes.rows(0, count + free);
        let covariance = (information.transpose() * information)
            .cholesky()?
            .inverse();
        let residuals = self.weighted(&self.point)?;
        let between = self.between_blocks(&slopes, &residuals);
        let sandwich = &covariance * between * &covariance;
        let mut deviation = [f64::NAN; FLEXIBLE];
        for i in 0..free {
            deviation[i] = WIDER * covariance[(i, i)].max(sandwich[(i, i)]).sqrt();
        }
        let of_model = DELAY_MODEL * (1.0 + self.period / DELAY_MODEL_PERIOD);
        deviation[at::DELAY_PLUS_LAG] = deviation[at::DELAY_PLUS_LAG].hypot(of_model);
        deviation[at::LN_MOBILITY] = deviation[at::LN_MOBILITY].hypot(MASS_MODEL);
        let model = model::sampled(self.kind, &self.point, self.period);
        let steady = filter::steady(&model)?;
        let all = filter::innovations(self.kind, &model, &steady, &self.samples);
        let foreseen = self
            .samples
            .positions
            .iter()
            .zip(&all)
            .map(|(x, e)| (x - e) * LENGTH)
            .collect();
        Some(Fit {
            kind: self.kind,
            point: self.point,
            deviation,
            innovation: self.scale * self.scale,
            sensor_noise: self.sensor_deviation(&steady) * LENGTH,
            count,
            foreseen,
            solved: self,
        })
    }

    /// Computes the covariance of the sum of the scores, with their correlation over [`CORRELATED`] (Newey and West,
    /// 1987), by blocks of samples.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "numbers of samples"
    )]
    fn between_blocks(&self, slopes: &DMatrix<f64>, residuals: &DVector<f64>) -> DMatrix<f64> {
        let block = ((0.002 / self.period).round() as usize).max(1);
        let lags = (CORRELATED / (block as f64 * self.period)).round() as usize;
        let count = self.counted.len();
        let blocks = count.div_ceil(block);
        let mut scores = DMatrix::<f64>::zeros(blocks, slopes.ncols());
        for column in 0..slopes.ncols() {
            for row in 0..count {
                scores[(row / block, column)] += slopes[(row, column)] * residuals[row];
            }
        }
        let mut sum = scores.transpose() * &scores;
        for lag in 1..=lags.min(blocks - 1) {
            let weight = 1.0 - lag as f64 / (lags + 1) as f64;
            let product = scores.rows(lag, blocks - lag).transpose() * scores.rows(0, blocks - lag);
            sum += (&product + product.transpose()) * weight;
        }
        sum
    }
}

/// Force changes, each as if it acted completely after delay and lag.
struct Kinks<'a> {
    commands: &'a [f64],
    delay: f64,
    mobility: f64,
}

impl Kinks<'_> {
    /// Returns the instant within the period after sample `index` at which the force changes `[periods]`, and the
    /// change of the velocity's slope `[LENGTH / period^2]`.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a delay is 0 up to some hundred periods"
    )]
    fn of(&self, index: usize) -> (f64, f64) {
        let whole = self.delay.floor();
        let command = |back: usize| {
            let at = index.checked_sub(whole as usize + back);
            at.map_or(0.0, |at| self.commands[at])
        };
        (
            self.delay - whole,
            self.mobility * (command(0) - command(1)),
        )
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Problem {
    type ParameterStorage = Owned<f64, Dyn>;
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;

    fn set_params(&mut self, x: &DVector<f64>) {
        self.point[..x.len()].copy_from_slice(x.as_slice());
    }

    fn params(&self) -> DVector<f64> {
        DVector::from_column_slice(&self.point[..self.free()])
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let count = self.counted.len() + 2 * self.free();
        // A filter that does not converge is worse than any that does.
        Some(
            self.weighted(&self.point)
                .unwrap_or_else(|| DVector::repeat(count, 1e6)),
        )
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        self.slopes()
    }
}

/// Fits to the same samples.
#[derive(Clone, Debug)]
pub struct Fits {
    /// With one mass.
    pub rigid: Fit,
    /// With two masses, if the data support a resonance.
    pub flexible: Option<Fit>,
    /// With two masses and a slow spring between them.
    pub slow: Option<Fit>,
}

/// Lowest frequency of the second mass alone on its spring `[rad/s]`, and the lowest one for a slow spring.
const MIN_ANTIRESONANCE: f64 = 250.0;
const MIN_SLOW_ANTIRESONANCE: f64 = 60.0;

/// Fits one mass and two masses.
pub fn fits(mut problem: Problem, sensor: f64) -> Option<Fits> {
    problem.first_signs(sensor);
    let rigid = problem.fitted(ROUNDS)?;
    let starts = [70.0, 105.0, 160.0, 240.0, 360.0];
    let fit = |starts: &[f64], least| flexible(&rigid, starts, least).and_then(Problem::finish);
    Some(Fits {
        flexible: fit(&starts, MIN_ANTIRESONANCE),
        slow: fit(&[15.0, 37.0], MIN_SLOW_ANTIRESONANCE),
        rigid: rigid.finish()?,
    })
}

/// Fits two masses from the best of the start frequencies `[Hz]`; the frequency of the second mass alone on its spring
/// is at least `least` `[rad/s]`.
fn flexible(rigid: &Problem, starts: &[f64], least: f64) -> Option<Problem> {
    let highest = 0.38 / rigid.period;
    let mut best: Option<Problem> = None;
    for &hertz in starts {
        if hertz > highest {
            continue;
        }
        let mut problem = rigid.clone();
        problem.kind = Kind::Flexible;
        problem.bounds[at::LN_ANTIRESONANCE].0 = least.ln();
        // The one-mass fit attributes a resonance to noise.
        for level in at::LN_DISTURBANCE..=at::LN_TREMOR_DAMPING {
            problem.point[level] = problem.prior[level].0;
        }
        problem.point[at::DAMPING] = FIRST_DAMPING;
        problem.point[at::STIFFNESS] = FIRST_STIFFNESS;
        problem.point[at::LN_ANTIRESONANCE] = (std::f64::consts::TAU * hertz).ln();
        let Some(mut problem) = problem.minimised(1) else {
            continue;
        };
        if problem.rescale().is_none() {
            continue;
        }
        if best.as_ref().is_none_or(|best| problem.scale < best.scale) {
            best = Some(problem);
        }
    }
    best?.fitted(ROUNDS)
}
