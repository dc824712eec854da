//! The model of a loop: a device on a hand, moved by a motor with delay and lag, seen by a sensor.
//!
//! Continuous states, in units of the period and of [`LENGTH`]: position and velocity at the sensor, the
//! motor's force, a slow disturbance, tremor as a damped oscillator (2), and where the device is flexible
//! position and velocity beyond the transmission.
//!
//! ```text
//! x'' = -k x - b x' + theta y + a + o - phi s(t) + c(x)      y' = (u(t - delay) - y) / lag
//! a'  = -a / 2 s + noise                              o'' = -w_t^2 o - 2 z_t w_t o' + noise
//! ```
//!
//! `theta` is gain over mass, `s` the sign of the velocity, `phi` Coulomb friction and `c` cogging
//! over mass. A flexible
//! device has the motor, the sensor and the friction on the first mass, hand and disturbances on the second.

use nalgebra::{DMatrix, DVector};

use crate::calibrate::exponential::exponential;

/// Unit of length inside the fit `[m]`: well-scaled matrices.
pub const LENGTH: f64 = 1e-6;
/// Decay of the slow disturbance `[1/s]`.
const DISTURBANCE_DECAY: f64 = 0.5;
/// Tremor of hands `[Hz]`.
const TREMOR: [f64; 2] = [4.0, 20.0];
/// Shortest lag that is computed `[periods]`; below it the force steps.
const MIN_LAG: f64 = 0.004;

/// Indices of the fit's parameters in [`Point`].
pub mod at {
    /// ln of gain over mass `[ln 1/kg]`.
    pub const LN_MOBILITY: usize = 0;
    /// Delay and lag `[periods]`.
    pub const DELAY_PLUS_LAG: usize = 1;
    /// Square of the lag `[periods^2]`.
    pub const LAG_SQUARED: usize = 2;
    /// Damping over mass `[1/s]`.
    pub const DAMPING: usize = 3;
    /// Stiffness over mass `[1/s^2]`.
    pub const STIFFNESS: usize = 4;
    /// Coulomb friction over mass `[m/s^2]`.
    pub const FRICTION: usize = 5;
    /// Cogging over mass, proportional to the cosine and to the sine of the position `[m/s^2]`.
    pub const COGGING: [usize; 2] = [6, 7];
    /// ln of the power of the slow disturbance over that of the sensor.
    pub const LN_DISTURBANCE: usize = 8;
    /// ln of the power of the tremor over that of the sensor.
    pub const LN_TREMOR: usize = 9;
    /// ln of the power of white acceleration over that of the sensor.
    pub const LN_ACCELERATION: usize = 10;
    /// ln of the frequency of the tremor `[ln Hz]`.
    pub const LN_TREMOR_FREQUENCY: usize = 11;
    /// ln of the damping ratio of the tremor.
    pub const LN_TREMOR_DAMPING: usize = 12;
    /// Logit of the part of the mass beyond the transmission.
    pub const LOGIT_FRACTION: usize = 13;
    /// ln of the frequency of the second mass alone on its spring `[ln rad/s]`.
    pub const LN_ANTIRESONANCE: usize = 14;
    /// Damping ratio of the second mass alone on its spring.
    pub const FLEXIBLE_DAMPING: usize = 15;
}

/// Number of parameters of a rigid device.
pub const RIGID: usize = 13;
/// Number of parameters of a flexible device.
pub const FLEXIBLE: usize = 16;

/// A point in the parameter space; a rigid model ignores the last three.
pub type Point = [f64; FLEXIBLE];

/// Whether a model has a flexible transmission.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// One mass.
    Rigid,
    /// Two masses.
    Flexible,
}

impl Kind {
    /// Number of states.
    pub fn states(self) -> usize {
        match self {
            Self::Rigid => 6,
            Self::Flexible => 8,
        }
    }

    /// Number of parameters.
    pub fn parameters(self) -> usize {
        match self {
            Self::Rigid => RIGID,
            Self::Flexible => FLEXIBLE,
        }
    }
}

/// Time constant of the lag `[periods]`.
pub fn lag(point: &Point) -> f64 {
    point[at::LAG_SQUARED]
        .max(0.0)
        .sqrt()
        .min(point[at::DELAY_PLUS_LAG].max(0.0))
}

/// The model over one period: `s <- transition s + late u_n+1 + early u_n + push (cogging - friction s_mean) + noise`.
#[derive(Clone, Debug)]
pub struct Sampled {
    /// Transition over a period.
    pub transition: DMatrix<f64>,
    /// Input of the command that begins within the period `[length / N]`.
    pub new_command: DVector<f64>,
    /// Input of the command before it.
    pub old_command: DVector<f64>,
    /// Whole periods from a sample to the period in which its command begins.
    pub whole_delay: usize,
    /// Input of friction and cogging, forces on the first mass over the mass of the whole.
    pub push: DVector<f64>,
    /// Coulomb friction over mass `[m/s^2]`.
    pub friction: f64,
    /// Cogging over mass, with the cosine and with the sine `[m/s^2]`.
    pub cogging: [f64; 2],
    /// Covariance of the noise of a period, over the variance of the sensor.
    pub noise: DMatrix<f64>,
}

const X: usize = 0;
const V: usize = 1;
const Y: usize = 2;
const A: usize = 3;
const O: usize = 4;
const X2: usize = 6;
const V2: usize = 7;

/// The model of `point` over a period of `period` `[s]`.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a delay is 0 up to some hundred periods"
)]
pub fn sampled(kind: Kind, point: &Point, period: f64) -> Sampled {
    let t = period;
    let states = kind.states();
    let tau = lag(point);
    let delay = (point[at::DELAY_PLUS_LAG] - tau).max(0.0);
    let tau = tau.max(MIN_LAG);
    let Continuous { a, noise, push } = Continuous::of(kind, point, period, tau);

    let mut inputs = DMatrix::<f64>::zeros(states + 2, states + 2);
    inputs.view_mut((0, 0), (states, states)).copy_from(&a);
    inputs[(Y, states)] = 1.0 / tau;
    inputs[(V, states + 1)] = push * t * t / LENGTH;
    let whole = delay.floor();
    let whole_period = exponential(&inputs);
    let after_start = exponential(&(&inputs * (1.0 - (delay - whole))));
    let new_command = after_start
        .view((0, states), (states, 1))
        .column(0)
        .into_owned();
    let held = whole_period
        .view((0, states), (states, 1))
        .column(0)
        .into_owned();
    Sampled {
        transition: whole_period.view((0, 0), (states, states)).into_owned(),
        old_command: held - &new_command,
        new_command,
        whole_delay: whole as usize,
        push: whole_period
            .view((0, states + 1), (states, 1))
            .column(0)
            .into_owned(),
        friction: point[at::FRICTION],
        cogging: at::COGGING.map(|at| point[at]),
        noise: noise_of_period(&a, &noise),
    }
}

/// The model as differential equations.
struct Continuous {
    /// Rates of the states, per period.
    a: DMatrix<f64>,
    /// Density of the noise, over the variance of the sensor.
    noise: DMatrix<f64>,
    /// Mass of the whole over the first mass.
    push: f64,
}

impl Continuous {
    /// Returns the equations of `point` for a period of `period` `[s]` and a lag of `tau` `[periods]`.
    fn of(kind: Kind, point: &Point, period: f64, tau: f64) -> Self {
        let t = period;
        let states = kind.states();
        let mobility = point[at::LN_MOBILITY].exp() * t * t / LENGTH;
        let damping = point[at::DAMPING] * t;
        let stiffness = point[at::STIFFNESS] * t * t;
        let level = |at: usize| point[at].clamp(-60.0, 40.0).exp();

        let mut a = DMatrix::<f64>::zeros(states, states);
        let mut noise = DMatrix::<f64>::zeros(states, states);
        a[(X, V)] = 1.0;
        a[(Y, Y)] = -1.0 / tau;
        a[(A, A)] = -DISTURBANCE_DECAY * t;
        let [low, high] = TREMOR.map(f64::ln);
        let w = std::f64::consts::TAU * point[at::LN_TREMOR_FREQUENCY].clamp(low, high).exp() * t;
        let z = point[at::LN_TREMOR_DAMPING].exp().clamp(0.01, 0.5);
        a[(O, O + 1)] = 1.0;
        a[(O + 1, O)] = -w * w;
        a[(O + 1, O + 1)] = -2.0 * z * w;
        noise[(A, A)] = level(at::LN_DISTURBANCE);
        noise[(O + 1, O + 1)] = level(at::LN_TREMOR);
        let push = match kind {
            Kind::Rigid => {
                a[(V, X)] = -stiffness;
                a[(V, V)] = -damping;
                a[(V, Y)] = mobility;
                a[(V, A)] = 1.0;
                a[(V, O)] = 1.0;
                noise[(V, V)] = level(at::LN_ACCELERATION);
                1.0
            }
            Kind::Flexible => {
                let second = 1.0 / (1.0 + (-point[at::LOGIT_FRACTION]).exp());
                let first = 1.0 - second;
                let w = point[at::LN_ANTIRESONANCE].exp() * t;
                let spring = second * w * w;
                let damper = 2.0 * point[at::FLEXIBLE_DAMPING].max(0.0) * w * second;
                a[(X2, V2)] = 1.0;
                a[(V, X)] = -spring / first;
                a[(V, X2)] = spring / first;
                a[(V, V)] = -damper / first;
                a[(V, V2)] = damper / first;
                a[(V, Y)] = mobility / first;
                a[(V2, X)] = spring / second;
                a[(V2, X2)] = -(spring + stiffness) / second;
                a[(V2, V)] = damper / second;
                a[(V2, V2)] = -(damper + damping) / second;
                a[(V2, A)] = 1.0 / second;
                a[(V2, O)] = 1.0 / second;
                noise[(V, V)] = level(at::LN_ACCELERATION) / (first * first);
                1.0 / first
            }
        };
        Self { a, noise, push }
    }
}

/// Computes the covariance of white noise of density `noise` after a period (Van Loan, *Computing integrals involving
/// the matrix exponential*, 1978). The motor's force has no noise and is left out: a short lag would overflow.
fn noise_of_period(a: &DMatrix<f64>, noise: &DMatrix<f64>) -> DMatrix<f64> {
    let kept: Vec<usize> = (0..a.nrows()).filter(|&state| state != Y).collect();
    let n = kept.len();
    let mut block = DMatrix::<f64>::zeros(2 * n, 2 * n);
    for (i, &from_i) in kept.iter().enumerate() {
        for (j, &from_j) in kept.iter().enumerate() {
            block[(i, j)] = -a[(from_i, from_j)];
            block[(n + j, n + i)] = a[(from_i, from_j)];
            block[(i, n + j)] = noise[(from_i, from_j)];
        }
    }
    let block = exponential(&block);
    let of_kept = block.view((n, n), (n, n)).transpose() * block.view((0, n), (n, n));
    let mut covariance = DMatrix::<f64>::zeros(a.nrows(), a.nrows());
    for (i, &to_i) in kept.iter().enumerate() {
        for (j, &to_j) in kept.iter().enumerate() {
            covariance[(to_i, to_j)] = 0.5 * (of_kept[(i, j)] + of_kept[(j, i)]);
        }
    }
    covariance
}
