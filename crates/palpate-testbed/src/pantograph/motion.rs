//! Motion under held torques: integration in time, with joints that stick and slide.
//!
//! **Integration.** Dormand and Prince's method of order 5 with its embedded estimate of order 4.
//! A step is kept if the estimated error of every angle `[rad]` and rate `[rad/s]` stays below 1e-12
//! of (1 + its size), and is at most 2 ms long. Free motion then keeps its energy within 1e-9
//! relative over 10 s (`tests/pantograph_dynamics.rs`). Close to a singular pose, where the distal
//! links whirl, it keeps fewer digits.
//!
//! **Coulomb friction** is exact, not smoothed: each joint slides one way or sticks, and that mode is fixed during a
//! step. A step in which a sliding joint would reverse, or a stuck joint would need more than the friction to hold it,
//! is shortened to that instant by bisection, and the modes of the joints at rest are determined again. The consistent
//! mode is selected. For friction that does not depend on the load it is the minimiser of a strictly convex function,
//! hence unique. Friction thus opposes sliding and does no work in sticking. A joint that has come to rest is given the
//! rate 0, a change of at most 1e-9 rad/s.

use super::dynamics::{Dynamics, solved};
use super::kinematics::{ArmPose, dot};

/// Tolerance of a step.
const TOLERANCE: f64 = 1e-12;
/// Longest step `[s]`.
const LONGEST: f64 = 2e-3;
/// A step that must be shorter than this `[s]` has met a singular pose.
const SHORTEST: f64 = 1e-11;
/// Width `[s]` to which an instant of sticking or sliding is found.
const EVENT_WIDTH: f64 = 1e-13;
/// Most steps of one advance per longest step; beyond it the mechanism counts as jammed.
const STEPS_PER_LONGEST: usize = 20_000;

/// Weights of the slopes for each later stage of the method of Dormand and Prince.
const STAGE_WEIGHTS: [[f64; 6]; 6] = [
    [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [
        19372.0 / 6561.0,
        -25360.0 / 2187.0,
        64448.0 / 6561.0,
        -212.0 / 729.0,
        0.0,
        0.0,
    ],
    [
        9017.0 / 3168.0,
        -355.0 / 33.0,
        46732.0 / 5247.0,
        49.0 / 176.0,
        -5103.0 / 18656.0,
        0.0,
    ],
    // The last stage is the result.
    [
        35.0 / 384.0,
        0.0,
        500.0 / 1113.0,
        125.0 / 192.0,
        -2187.0 / 6784.0,
        11.0 / 84.0,
    ],
];

/// Weights of the slopes for the estimated error: order 5 minus order 4.
const ERROR_WEIGHTS: [f64; 7] = [
    71.0 / 57600.0,
    0.0,
    -71.0 / 16695.0,
    71.0 / 1920.0,
    -17253.0 / 339_200.0,
    22.0 / 525.0,
    -1.0 / 40.0,
];

/// Angles `[rad]`, rates `[rad/s]` and the energy lost so far `[J]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct State {
    pub angles: [f64; 2],
    pub rates: [f64; 2],
    pub dissipated: f64,
}

/// Quantities that are constant during an advance.
#[derive(Debug, Clone, Copy)]
pub(super) struct HeldInputs<'a> {
    pub dynamics: &'a Dynamics,
    /// Motor torques `[N m]`.
    pub torques: [f64; 2],
    /// Force on the end-point `[N]`.
    pub force: [f64; 2],
    /// Viscous friction `[N m s/rad]`.
    pub viscous: f64,
    /// Coulomb friction `[N m]`.
    pub coulomb: f64,
}

/// State of a joint's Coulomb friction during a step.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Mode {
    /// Slides with this sign of its rate; 0 means no Coulomb friction.
    Slides(f64),
    Sticks,
}

/// Driving forces of the mechanism, without Coulomb friction.
struct Push {
    /// Mass matrix `[kg m²]` seen by the motors.
    mass: [[f64; 2]; 2],
    /// Torques about the motors `[N m]`.
    torques: [f64; 2],
}

/// Result of one step of the method.
struct Step {
    state: State,
    /// The pose of `state`.
    pose: ArmPose,
    /// Largest error over tolerance; above 1 the step is refused.
    error: f64,
    /// Whether a joint left its mode on the way.
    left_mode: bool,
}

/// The mechanism ran into a singular pose or came to no end; how far it got.
pub(super) struct Jammed;

impl HeldInputs<'_> {
    /// Moves `state` and its pose on for `duration` `[s]`. On an error they are where the mechanism jammed.
    pub fn advance(
        &self,
        state: &mut State,
        pose: &mut ArmPose,
        duration: f64,
    ) -> Result<(), Jammed> {
        let mut remaining = duration;
        let mut length = remaining.min(LONGEST);
        let mut budget = STEPS_PER_LONGEST;
        let mut refill = duration;
        while remaining > 0.0 {
            budget -= 1;
            if budget == 0 {
                if refill - remaining < LONGEST {
                    return Err(Jammed);
                }
                (budget, refill) = (STEPS_PER_LONGEST, remaining);
            }
            length = length.min(remaining).min(LONGEST);
            let modes = self.modes(state, pose);
            let step = self.step(state, pose, modes, length);
            let error = step.as_ref().map_or(f64::INFINITY, |step| step.error);
            let Some(step) = step.filter(|step| step.error <= 1.0) else {
                if length < SHORTEST {
                    return Err(Jammed);
                }
                length *= (0.9 * error.powf(-0.2)).clamp(0.1, 0.5);
                continue;
            };
            let taken;
            (taken, *state, *pose) = if step.left_mode {
                self.until_left(state, pose, modes, length, step)
            } else {
                (length, step.state, step.pose)
            };
            // What remains after the last step is exactly zero.
            remaining -= taken;
            if remaining > 0.0 {
                length *= (0.9 * error.max(1e-10).powf(-0.2)).clamp(0.5, 4.0);
            }
        }
        Ok(())
    }

    /// The first instant, from the start of a step, at which a joint leaves its mode.
    fn until_left(
        &self,
        start: &State,
        first: &ArmPose,
        modes: [Mode; 2],
        length: f64,
        end: Step,
    ) -> (f64, State, ArmPose) {
        let (mut before, mut after) = (0.0, length);
        let (mut state, mut pose) = (end.state, end.pose);
        while after - before > EVENT_WIDTH {
            let middle = 0.5 * (before + after);
            match self.step(start, first, modes, middle) {
                Some(step) if step.left_mode => {
                    (after, state, pose) = (middle, step.state, step.pose);
                }
                Some(_) => before = middle,
                None => break,
            }
        }
        for (rate, mode) in state.rates.iter_mut().zip(modes) {
            if matches!(mode, Mode::Slides(sign) if sign * *rate < 0.0) {
                *rate = 0.0;
            }
        }
        (after, state, pose)
    }

    /// The modes that are consistent with the present rates and torques.
    fn modes(&self, state: &State, pose: &ArmPose) -> [Mode; 2] {
        if self.coulomb == 0.0 {
            return [Mode::Slides(0.0); 2];
        }
        let sliding = state.rates.map(|rate| Mode::Slides(rate.signum()));
        if state.rates.iter().all(|&rate| rate != 0.0) {
            return sliding;
        }
        let choices = [0, 1].map(|i| {
            if state.rates[i] == 0.0 {
                [Mode::Sticks, Mode::Slides(1.0), Mode::Slides(-1.0)]
            } else {
                [sliding[i]; 3]
            }
        });
        let push = self.push(pose, state.rates);
        let mut best = ([choices[0][0], choices[1][0]], f64::INFINITY);
        for first in choices[0] {
            for second in choices[1] {
                let modes = [first, second];
                let (accelerations, hold) = self.accelerations(&push, modes);
                let violation: f64 = (0..2)
                    .filter(|&i| state.rates[i] == 0.0)
                    .map(|i| match modes[i] {
                        Mode::Sticks => (hold[i].abs() - self.coulomb).max(0.0),
                        Mode::Slides(sign) => (-sign * accelerations[i]).max(0.0),
                    })
                    .sum();
                if violation < best.1 {
                    best = (modes, violation);
                }
            }
        }
        best.0
    }

    /// Returns the driving forces of the mechanism at a pose and rates.
    fn push(&self, pose: &ArmPose, rates: [f64; 2]) -> Push {
        let coriolis = self.dynamics.coriolis(pose, rates);
        let gravity = self.dynamics.gravity_torques(pose);
        let external = pose.torques(self.force);
        Push {
            mass: self.dynamics.mass_matrix(pose),
            torques: [0, 1].map(|i| {
                self.torques[i] + external[i] + gravity[i] - coriolis[i] - self.viscous * rates[i]
            }),
        }
    }

    /// Accelerations `[rad/s²]`, and the torques `[N m]` that hold the stuck joints.
    fn accelerations(&self, push: &Push, modes: [Mode; 2]) -> ([f64; 2], [f64; 2]) {
        let mass = push.mass;
        let net = [0, 1].map(|i| match modes[i] {
            Mode::Slides(sign) => push.torques[i] - sign * self.coulomb,
            Mode::Sticks => push.torques[i],
        });
        let sticks = modes.map(|mode| mode == Mode::Sticks);
        let accelerations = match sticks {
            [false, false] => solved(mass, net),
            [true, false] => [0.0, net[1] / mass[1][1]],
            [false, true] => [net[0] / mass[0][0], 0.0],
            [true, true] => [0.0, 0.0],
        };
        let hold = [0, 1].map(|i| {
            if sticks[i] {
                dot(mass[i], accelerations) - net[i]
            } else {
                0.0
            }
        });
        (accelerations, hold)
    }

    /// One step of Dormand–Prince 5(4) from a state and its pose; `None` if it leads through a pose that does not
    /// exist.
    fn step(&self, start: &State, first: &ArmPose, modes: [Mode; 2], length: f64) -> Option<Step> {
        let origin = [
            start.angles[0],
            start.angles[1],
            start.rates[0],
            start.rates[1],
            start.dissipated,
        ];
        let mut slopes = [[0.0; 5]; 7];
        (slopes[0], _) = self.slope(first, origin, modes);
        let mut y = origin;
        let mut left_mode = false;
        let mut pose = *first;
        for (stage, row) in STAGE_WEIGHTS.iter().enumerate() {
            for (k, value) in y.iter_mut().enumerate() {
                let sum: f64 = (0..=stage).map(|j| row[j] * slopes[j][k]).sum();
                *value = origin[k] + length * sum;
            }
            pose = self.dynamics.geometry().forward([y[0], y[1]]).ok()?;
            // A distal link that jumps has been carried across a singular pose.
            if (0..2).any(|i| dot(pose.distal[i], first.distal[i]) < 0.5) {
                return None;
            }
            let left;
            (slopes[stage + 1], left) = self.slope(&pose, y, modes);
            left_mode |= left;
        }
        let error = (0..4)
            .map(|k| {
                let sum: f64 = (0..7).map(|j| ERROR_WEIGHTS[j] * slopes[j][k]).sum();
                let scale = 1.0 + y[k].abs().max(origin[k].abs());
                (length * sum).abs() / (TOLERANCE * scale)
            })
            // `f64::max` would drop a NaN; it has to refuse the step.
            .map(|e| if e.is_nan() { f64::INFINITY } else { e })
            .fold(0.0, f64::max);
        Some(Step {
            state: State {
                angles: [y[0], y[1]],
                rates: [y[2], y[3]],
                dissipated: y[4],
            },
            pose,
            error,
            left_mode,
        })
    }

    /// Derivative of (θ, θ′, dissipated), and whether a joint is outside its mode here.
    fn slope(&self, pose: &ArmPose, y: [f64; 5], modes: [Mode; 2]) -> ([f64; 5], bool) {
        let rates = [y[2], y[3]];
        let (accelerations, hold) = self.accelerations(&self.push(pose, rates), modes);
        let mut lost = 0.0;
        let mut left = false;
        for i in 0..2 {
            lost += self.viscous * rates[i] * rates[i];
            match modes[i] {
                Mode::Slides(sign) => {
                    lost += sign * self.coulomb * rates[i];
                    left |= sign * rates[i] < 0.0;
                }
                Mode::Sticks => left |= hold[i].abs() > self.coulomb,
            }
        }
        let slope = [rates[0], rates[1], accelerations[0], accelerations[1], lost];
        (slope, left)
    }
}
