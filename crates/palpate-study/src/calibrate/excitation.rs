//! The force that moves the device: `+A` or `-A`, held for random times, steered to stay in a box.
//!
//! In each period the speed of the device predicts where it would come to rest under full braking. The further that
//! point is from the middle, the less likely the next hold pushes outwards. A hold that would leave the box ends early.
//! The force ramps up and down, and the first and last part have no force.

use std::collections::VecDeque;
use std::fmt;

/// Shortest and longest hold `[s]`, and the increment per period `[periods]`. Motion below the sensor's steps carries
/// little information; long holds excite cogging.
const HOLD: [f64; 2] = [0.005, 0.015];
const HOLD_PERIODS: [f64; 2] = [0.5, 2.0];
/// Time without force at the beginning, for measuring the tremor of the hand `[s]`.
const LISTEN: f64 = 0.5;
/// Duration of the force ramps at the beginning and at the end `[s]`.
const RAMP: f64 = 0.3;
/// Time without force at the end `[s]`.
const REST: f64 = 0.1;
/// Time constant of the velocity estimate used for steering `[s]`.
const STEERING: f64 = 0.004;
/// Largest device mass for which braking is designed `[kg]`.
const HEAVIEST: f64 = 0.5;
/// Smallest device mass for which braking at the end is stable `[kg]`.
const LIGHTEST: f64 = 0.08;
/// Fraction of the box in which the device is steered; the rest is a margin.
const STEERED: f64 = 0.6;
/// Upper bound of a device's speed under these forces `[m/s]`.
const LARGEST_SPEED: f64 = 1.0;
/// Time over which the speed is averaged `[s]`: a sensor step within one period does not count as a speed.
const SPEED_OVER: f64 = 0.01;

/// Shortest calibration `[s]`.
pub const SHORTEST: f64 = 2.0;
/// Longest calibration `[s]`.
pub const LONGEST: f64 = 120.0;
/// Shortest and longest period `[s]`.
pub const PERIODS: [f64; 2] = [0.000_1, 0.02];

/// Parameters of an excitation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExcitationParams {
    /// Period of the loop `[s]`.
    pub period: f64,
    /// Largest force on the device `[N]`.
    pub largest_force: f64,
    /// Duration, including the parts without force `[s]`.
    pub duration: f64,
    /// Largest distance from the start position `[m]`; beyond it the excitation stops.
    pub excursion: f64,
    /// Largest tremor of the hand, root mean square, before the excitation starts `[m]`.
    pub tremor: f64,
    /// Seed of the random holds.
    pub seed: u64,
}

impl ExcitationParams {
    /// Returns the default parameters: 0.5 N for 8 s, within 10 mm, tremor up to 1 mm.
    #[must_use]
    pub fn new(period: f64) -> Self {
        Self {
            period,
            largest_force: 0.5,
            duration: 8.0,
            excursion: 0.01,
            tremor: 1e-3,
            seed: 1,
        }
    }

    /// Checks the ranges of all parameters.
    ///
    /// # Errors
    /// A value is out of range.
    pub fn check(&self) -> Result<(), ExcitationError> {
        let [shortest, longest] = PERIODS;
        let ranges = [
            ("the period", self.period, shortest, longest, "s"),
            ("the largest force", self.largest_force, 0.01, 20.0, "N"),
            ("the duration", self.duration, SHORTEST, LONGEST, "s"),
            ("the excursion", self.excursion, 5e-4, 0.2, "m"),
            ("the tremor", self.tremor, 1e-6, 0.1, "m"),
        ];
        for (name, value, least, most, unit) in ranges {
            if !(least..=most).contains(&value) {
                return Err(ExcitationError {
                    name,
                    value,
                    least,
                    most,
                    unit,
                });
            }
        }
        Ok(())
    }
}

/// Excitation parameter that is out of range.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{name} is {value} {unit}, but must be {least} to {most} {unit}")]
#[non_exhaustive]
pub struct ExcitationError {
    /// Name of the parameter.
    pub name: &'static str,
    /// Its value.
    pub value: f64,
    /// Smallest allowed value.
    pub least: f64,
    /// Largest allowed value.
    pub most: f64,
    /// The unit.
    pub unit: &'static str,
}

/// Reason why an excitation stopped early.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stop {
    /// A position was not a finite number.
    NotANumber,
    /// The device left its box.
    Excursion {
        /// Distance from the start position `[m]`.
        reached: f64,
        /// Allowed distance `[m]`.
        allowed: f64,
    },
    /// The tremor of the hand before the excitation exceeded its limit.
    Tremor {
        /// Root mean square of the motion without force, after removing mean and drift `[m]`.
        found: f64,
        /// Allowed value `[m]`.
        allowed: f64,
    },
    /// The position did not change under forces that move any device.
    NoAnswer {
        /// Duration `[s]`.
        time: f64,
        /// Largest force in that time `[N]`.
        force: f64,
    },
    /// The speed exceeded the bound of any device under these forces: the sensor jumps, or the hand pulls.
    Speed {
        /// The speed `[m/s]`.
        found: f64,
        /// Allowed speed `[m/s]`.
        allowed: f64,
    },
}

impl fmt::Display for Stop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mm = |metres: f64| metres * 1e3;
        match *self {
            Self::NotANumber => write!(f, "a position is not a finite number"),
            Self::Excursion { reached, allowed } => write!(
                f,
                "the device went {:.1} mm from where it started, and {:.1} mm are allowed: hold it more \
                 firmly, or command less force",
                mm(reached),
                mm(allowed)
            ),
            Self::Tremor { found, allowed } => write!(
                f,
                "the hand moves too much: {:.2} mm (root mean square) without any force, and {:.2} mm \
                 are allowed",
                mm(found),
                mm(allowed)
            ),
            Self::NoAnswer { time, force } => write!(
                f,
                "the device did not follow the commands: the position did not change for {time:.2} s under forces of up to {force:.2} N: check the encoder and its cable, \
                 that the motor is on, and that the largest force is well above the friction"
            ),
            Self::Speed { found, allowed } => write!(
                f,
                "the device moved at {found:.2} m/s, and {allowed} m/s is allowed: the sensor jumps, or \
                 the hand pulls"
            ),
        }
    }
}

/// Phase of an excitation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Phase {
    /// The excitation is running.
    Running,
    /// It is complete; the force is 0.
    Done,
    /// The excitation stopped early; the force is 0.
    Stopped(Stop),
}

/// An excitation, with positions as input and forces as output.
#[derive(Clone, Debug)]
pub struct Excitation {
    params: ExcitationParams,
    random: fastrand::Rng,
    phase: Phase,
    /// Samples taken.
    count: usize,
    /// Samples of the whole excitation.
    length: usize,
    start: f64,
    last: f64,
    velocity: f64,
    sign: f64,
    /// Samples until the hold ends.
    left: f64,
    /// Positions of the last [`SPEED_OVER`].
    recent: VecDeque<f64>,
    listened: Listened,
    answer: Answer,
    /// Whether a sample has arrived.
    is_begun: bool,
    /// Whether the tremor has been checked.
    is_heard: bool,
}

impl Excitation {
    /// Creates an excitation in its initial state.
    ///
    /// # Errors
    /// A parameter is out of range.
    pub fn new(params: ExcitationParams) -> Result<Self, ExcitationError> {
        params.check()?;
        Ok(Self {
            params,
            random: fastrand::Rng::with_seed(params.seed),
            phase: Phase::Running,
            count: 0,
            length: samples(params.duration, params.period),
            start: 0.0,
            last: 0.0,
            velocity: 0.0,
            sign: 1.0,
            left: 0.0,
            recent: VecDeque::new(),
            listened: Listened::default(),
            answer: Answer::default(),
            is_begun: false,
            is_heard: false,
        })
    }

    /// Returns the parameters of this excitation.
    #[must_use]
    pub fn params(&self) -> &ExcitationParams {
        &self.params
    }

    /// Returns the number of samples of the whole excitation; the force for the last one is 0.
    #[must_use]
    pub fn length(&self) -> usize {
        self.length
    }

    /// Returns the current phase.
    #[must_use]
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// Returns the range of samples with a force.
    #[must_use]
    pub fn excited(&self) -> std::ops::Range<usize> {
        let period = self.params.period;
        samples(LISTEN, period)..self.length - samples(REST, period)
    }

    /// Returns the force on the device `[N]` from the sample of `position` `[m]` until the next one.
    pub fn next(&mut self, position: f64) -> f64 {
        if self.phase != Phase::Running {
            return 0.0;
        }
        if let Some(stop) = self.take(position) {
            self.phase = Phase::Stopped(stop);
            return 0.0;
        }
        let index = self.count;
        self.count += 1;
        if self.count >= self.length {
            self.phase = Phase::Done;
            return 0.0;
        }
        let part = if index + samples(RAMP, self.params.period) < self.excited().end {
            self.held(position - self.start)
        } else {
            self.braking()
        };
        // Adding 0.0 normalises -0.0, which occurs while there is no force.
        let force = part * self.amplitude(index) + 0.0;
        self.answer.push(&self.params, force);
        force
    }

    /// Advances by a period without a sample, in which the device holds the last force.
    pub fn miss(&mut self) {
        if self.phase == Phase::Running {
            self.count += 1;
            self.left -= 1.0;
            if self.count >= self.length {
                self.phase = Phase::Done;
            }
        }
    }

    /// Processes a position. Returns a reason to stop, if there is one.
    fn take(&mut self, position: f64) -> Option<Stop> {
        let ExcitationParams {
            period,
            excursion,
            tremor,
            ..
        } = self.params;
        if !position.is_finite() {
            return Some(Stop::NotANumber);
        }
        if !self.is_begun {
            self.is_begun = true;
            self.start = position;
            self.last = position;
        }
        let reached = (position - self.start).abs();
        if reached > excursion {
            return Some(Stop::Excursion {
                reached,
                allowed: excursion,
            });
        }
        self.recent.push_back(position);
        if self.recent.len() > samples(SPEED_OVER, period).max(2) {
            let earlier = self.recent.pop_front().unwrap_or(position);
            let found = (position - earlier).abs() / (self.recent.len() as f64 * period);
            if found > LARGEST_SPEED {
                return Some(Stop::Speed {
                    found,
                    allowed: LARGEST_SPEED,
                });
            }
        }
        let new = period / (period + STEERING);
        self.velocity += new * ((position - self.last) / period - self.velocity);
        self.last = position;
        let begins = self.excited().start;
        if self.count < begins {
            self.listened
                .add(self.count as f64 * period, position - self.start);
            self.answer.listen(position);
            return None;
        }
        if let Some(stop) = self.answer.take(position) {
            return Some(stop);
        }
        if !self.is_heard {
            self.is_heard = true;
            let found = self.listened.deviation();
            if found > tremor {
                return Some(Stop::Tremor {
                    found,
                    allowed: tremor,
                });
            }
        }
        None
    }

    /// Magnitude of the force at a sample: the largest force times the ramp.
    fn amplitude(&self, index: usize) -> f64 {
        let excited = self.excited();
        if !excited.contains(&index) {
            return 0.0;
        }
        let ramp = samples(RAMP, self.params.period) as f64;
        let from_start = (index + 1 - excited.start) as f64 / ramp;
        let to_end = (excited.end - index) as f64 / ramp;
        self.params.largest_force * from_start.min(to_end).min(1.0)
    }

    /// Returns the normalised braking force: a damper that delays do not destabilise.
    fn braking(&self) -> f64 {
        let ExcitationParams {
            period,
            largest_force,
            ..
        } = self.params;
        let full = largest_force / LIGHTEST * (STEERING + 3.0 * period);
        (-self.velocity / full).clamp(-1.0, 1.0)
    }

    /// Returns the sign of the force at a `position` relative to the start `[m]`.
    fn held(&mut self, position: f64) -> f64 {
        let ExcitationParams {
            period,
            largest_force,
            excursion,
            ..
        } = self.params;
        let v = self.velocity;
        let braking = 0.5 * v * v.abs() * HEAVIEST / largest_force;
        let rest = (position + v * (STEERING + 2.0 * period) + braking) / (STEERED * excursion);
        if self.left <= 0.0 || rest * self.sign > 1.0 {
            let [shortest, longest] = [0, 1].map(|end| HOLD[end] + HOLD_PERIODS[end] * period);
            let held = shortest + (longest - shortest) * self.random.f64();
            self.left = (held / period).round().max(1.0);
            self.sign = if self.random.f64() < 0.5 - 0.6 * rest {
                1.0
            } else {
                -1.0
            };
        }
        self.left -= 1.0;
        self.sign
    }
}

/// Detector for a position that does not respond to the force.
///
/// The smallest motion of a working device is that of the heaviest device under the largest friction. If the positions
/// stay within the force-free range while that device would have moved far, the sensor is dead.
#[derive(Clone, Copy, Debug, Default)]
struct Answer {
    /// Range of the positions without force `[m]`.
    still: Option<[f64; 2]>,
    /// Range since the last response `[m]`.
    seen: Option<[f64; 2]>,
    /// Path of the heaviest device since then `[m]`.
    expected: f64,
    /// Time since then `[s]`.
    time: f64,
    /// Largest force since then `[N]`.
    force: f64,
}

/// Path of the heaviest device without a response `[m]`: twenty times the step of the coarsest sensor.
const LONGEST_WAY: f64 = 2e-3;
/// Largest ratio of Coulomb friction to the largest force: calibration declines above it.
const MAX_FRICTION: f64 = 0.6;
/// Largest force-free range that counts as sensor noise `[m]`. A larger range comes from the hand, and the response
/// need not exceed it.
const STILL: f64 = 5e-5;

impl Answer {
    fn listen(&mut self, position: f64) {
        widen(&mut self.still, position);
    }

    /// Processes a position under force. Returns a reason to stop, if there is one.
    fn take(&mut self, position: f64) -> Option<Stop> {
        widen(&mut self.seen, position);
        let range = |range: Option<[f64; 2]>| range.map_or(0.0, |[low, high]| high - low);
        let still = Some(range(self.still)).filter(|still| *still <= STILL);
        if range(self.seen) > still.unwrap_or(0.0) {
            *self = Self {
                still: self.still,
                seen: Some([position; 2]),
                ..Self::default()
            };
        }
        (self.expected > LONGEST_WAY).then_some(Stop::NoAnswer {
            time: self.time,
            force: self.force,
        })
    }

    /// Records the force commanded for a period.
    fn push(&mut self, params: &ExcitationParams, force: f64) {
        let ExcitationParams {
            period,
            largest_force,
            ..
        } = *params;
        let force = force.abs();
        let moving = (force - MAX_FRICTION * largest_force).max(0.0);
        let [shortest, longest] = [0, 1].map(|end| HOLD[end] + HOLD_PERIODS[end] * period);
        // a t^2 / 2 in each hold of t.
        self.expected += 0.5 * moving / HEAVIEST * 0.5 * (shortest + longest) * period;
        self.time += if force > 0.0 { period } else { 0.0 };
        self.force = self.force.max(force);
    }
}

fn widen(range: &mut Option<[f64; 2]>, position: f64) {
    let [low, high] = range.unwrap_or([position; 2]);
    *range = Some([low.min(position), high.max(position)]);
}

/// Line fit of positions over time, with the residual.
#[derive(Clone, Copy, Debug, Default)]
struct Listened {
    count: f64,
    t: f64,
    x: f64,
    tt: f64,
    tx: f64,
    xx: f64,
}

impl Listened {
    fn add(&mut self, t: f64, x: f64) {
        self.count += 1.0;
        self.t += t;
        self.x += x;
        self.tt += t * t;
        self.tx += t * x;
        self.xx += x * x;
    }

    /// Returns the root mean square distance from the line.
    fn deviation(&self) -> f64 {
        let n = self.count;
        let tt = self.tt - self.t * self.t / n;
        let tx = self.tx - self.t * self.x / n;
        let xx = self.xx - self.x * self.x / n;
        let left = if tt > 0.0 { xx - tx * tx / tt } else { xx };
        (left.max(0.0) / n).sqrt()
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "durations and periods are within their ranges"
)]
fn samples(duration: f64, period: f64) -> usize {
    (duration / period).round() as usize
}
