//! Rotation of a device in its hand, under a held torque.

use super::dormand_prince::Step;
use super::scene::Vector;
use super::turning::{Turning, TurningHand, rotation_vector, turned_by};
use super::vector::{Rotation, Vec3, quaternion_rate};
use crate::InvalidParameter;
use crate::actuator::{Actuator, ActuatorParams};

/// Longest step of the integration `[s]`: a device turns by a small part of a turn in it.
const LONGEST_STEP: f64 = 6.25e-5;
/// Longest step in units of the time in which a device gives way in its hand. The method of order 5 is stable up to 3.3
/// against a damper,
const STEP_IN_RATES: f64 = 2.0;
/// and up to 1 against a spring alone, which counts as so much faster.
const SPRING: f64 = 2.2;
/// Longest step in lags of the actuator.
const STEP_IN_LAGS: f64 = 0.125;

/// A device that turns, between measuring and actuating: quaternion and angular momentum, integrated in steps of
/// order 5.
#[derive(Debug, Clone)]
pub struct HeldTurning {
    turning: Turning,
    actuator: ActuatorParams,
    state: [f64; 7],
    /// Torque that the actuator gives now `[N m]`.
    torque: Vec3,
    time: f64,
    step: Step,
    /// Stiffness of the hand while it holds the device `[N m/rad]`.
    stiffness: f64,
    /// Longest step of the integration `[s]`.
    longest: f64,
}

/// Bound of the rates of a device in its hand `[rad/s]`.
fn rate(turning: &Turning) -> f64 {
    let least = turning.inertia.iter().fold(f64::INFINITY, |a, b| a.min(*b));
    turning.hand.damping / least + SPRING * (turning.hand.stiffness / least).sqrt()
}

impl HeldTurning {
    /// Fastest rate of a device in its hand that a loop can follow in the time of a tick `[rad/s]`: the hand's damping
    /// over the least moment of inertia, and 2.2 times the root of its stiffness over that.
    pub const FASTEST: f64 = STEP_IN_RATES / LONGEST_STEP;

    /// Creates a device in its initial state, with an actuator about each axis that gives no torque yet.
    ///
    /// # Errors
    ///
    /// A quantity of the device or of the actuator is out of range, with its value and the allowed range; or the hand
    /// is faster than [`FASTEST`](Self::FASTEST).
    pub fn checked(turning: &Turning, actuator: ActuatorParams) -> Result<Self, InvalidParameter> {
        turning.check("turning").map_err(|wrong| InvalidParameter {
            name: "turning",
            value: wrong.value,
            allowed: wrong.allowed,
        })?;
        let rate = rate(turning);
        if rate > Self::FASTEST {
            return Err(InvalidParameter {
                name: "turning",
                value: rate,
                allowed: "at most 32000 rad/s: hand.damping / I + 2.2 sqrt(hand.stiffness / I), with the least moment \
                          of inertia I; increase the inertia or soften the hand",
            });
        }
        Actuator::new(actuator)?;
        Ok(Self::new(turning, actuator))
    }

    /// Creates the rotation of a checked device with a checked actuator, without torque.
    pub(super) fn new(turning: &Turning, actuator: ActuatorParams) -> Self {
        let rotation = Rotation::of_quaternion(turning.orientation);
        let momentum = turning.angular_momentum(&rotation, Vec3(turning.angular_velocity));
        let mut state = [0.0; 7];
        state[..4].copy_from_slice(&turning.orientation);
        momentum.write(&mut state[4..]);
        Self {
            turning: turning.clone(),
            actuator,
            state,
            torque: Vec3::ZERO,
            time: 0.0,
            step: Step::of_size(7),
            stiffness: turning.hand.stiffness,
            longest: LONGEST_STEP.min(STEP_IN_RATES / rate(turning)),
        }
    }

    /// Moves the rest orientation of the hand's spring to `rest`, a unit quaternion `[w, x, y, z]`. Other values are
    /// ignored. Does not allocate, so it may be called in a loop's tick.
    pub fn aim_at(&mut self, rest: [f64; 4]) {
        let length = rest.iter().map(|part| part * part).sum::<f64>();
        if (length - 1.0).abs() < 1e-6 {
            self.turning.hand.rest = rest;
        }
    }

    /// The hand's spring acts from now on, or does not; its damping stays.
    pub fn hold(&mut self, is_held: bool) {
        self.turning.hand.stiffness = if is_held { self.stiffness } else { 0.0 };
    }

    /// Releases the device permanently.
    pub fn release(&mut self) {
        self.turning.hand = TurningHand::none();
    }

    /// Unit quaternion `[w, x, y, z]`.
    #[must_use]
    pub fn orientation(&self) -> [f64; 4] {
        let q = [0, 1, 2, 3].map(|i: usize| self.state[i]);
        let length = q.iter().map(|part| part * part).sum::<f64>().sqrt();
        q.map(|part| part / length)
    }

    /// Returns the measured orientation: the rotation vector from the start, rounded to the quantum.
    #[must_use]
    pub fn measured(&self) -> [f64; 4] {
        let quantum = self.turning.quantum;
        if quantum == 0.0 {
            return self.orientation();
        }
        let start = self.turning.orientation;
        let vector = rotation_vector(start, self.orientation());
        let rounded = vector.0.map(|angle| (angle / quantum).round() * quantum);
        turned_by(Vec3(rounded), start)
    }

    /// Returns the angular velocity in world axes `[rad/s]`.
    #[must_use]
    pub fn angular_velocity(&self) -> Vector {
        let rotation = Rotation::of_quaternion(self.orientation());
        let momentum = Vec3::new(&self.state[4..]);
        self.turning.angular_velocity(&rotation, momentum).0
    }

    /// Moves on for `duration` `[s]` while a torque on the tool is commanded `[N m]`; the delivered angular impulse
    /// `[N m s]`, 0 of a device that gives no torque.
    pub fn advance(&mut self, command: Vector, duration: f64) -> Vector {
        let ActuatorParams { gain, lag } = self.actuator;
        let aim = self.turning.of_contacts(Vec3(command)) * gain;
        let (mut excess, mut longest) = (Vec3::ZERO, self.longest);
        if lag > 0.0 {
            excess = self.torque - aim;
            longest = longest.min(STEP_IN_LAGS * lag);
        }
        let left = |time: f64| {
            if lag > 0.0 { (-time / lag).exp() } else { 0.0 }
        };
        let steps = (duration / longest).ceil().max(1.0);
        let length = duration / steps;
        let begin = self.time;
        let mut done = 0.0;
        while done < duration - 0.5 * length {
            let turning = &self.turning;
            let start = self.state;
            self.step
                .take(done, &start, length, false, |time, state, rates| {
                    let q = [state[0], state[1], state[2], state[3]];
                    let rotation = Rotation::of_quaternion(q);
                    let omega = turning.angular_velocity(&rotation, Vec3::new(&state[4..]));
                    let by_hand = turning.hand_torque(begin + time, q, omega);
                    rates[..4].copy_from_slice(&quaternion_rate(q, omega));
                    (aim + excess * left(time) + by_hand).write(&mut rates[4..]);
                });
            self.state.copy_from_slice(self.step.end());
            done += length;
        }
        self.time += duration;
        self.torque = aim + excess * left(duration);
        (aim * duration + excess * (lag * (1.0 - left(duration)))).0
    }
}
