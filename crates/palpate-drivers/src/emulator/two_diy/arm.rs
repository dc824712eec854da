//! Arm of an emulated board: the testbed's pantograph with a hand, and the wiring.

use std::time::Duration;

use palpate_scene::Linkage;
use palpate_testbed::actuator::ActuatorParams;
use palpate_testbed::pantograph::{Pantograph, PantographParams};

use super::firmware::{Ports, pins};
use super::motor::Motor;
use crate::two_diy::{Board, Generation, LARGEST_TORQUE, Layout};

/// Longest interval between updates of the hand's force `[s]`.
const LONGEST_STEP: f64 = 5e-4;

/// Force on the handle.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum Hand {
    /// Nothing.
    #[default]
    None,
    /// A constant force `[N]`.
    Push([f64; 2]),
    /// A spring and a damper to a position that may oscillate.
    Holds {
        /// Mean position `[m]`.
        place: [f64; 2],
        /// Amplitude `[m]`.
        sway: [f64; 2],
        /// Period `[s]`.
        period: f64,
        /// Stiffness `[N/m]`.
        stiffness: f64,
        /// Damping `[N s/m]`.
        damping: f64,
    },
}

impl Hand {
    /// Returns a relaxed hand that stays at a position `[m]`.
    #[must_use]
    pub fn at(place: [f64; 2]) -> Self {
        Self::Holds {
            place,
            sway: [0.0; 2],
            period: 1.0,
            stiffness: 200.0,
            damping: 4.0,
        }
    }

    /// Returns the same hand, oscillating about its position with amplitude `to` `[m]` and period `within` `[s]`.
    #[must_use]
    pub fn swaying(self, to: [f64; 2], within: f64) -> Self {
        match self {
            Self::Holds {
                place,
                stiffness,
                damping,
                ..
            } => Self::Holds {
                place,
                sway: to,
                period: within,
                stiffness,
                damping,
            },
            other => other,
        }
    }

    fn force(&self, time: f64, position: [f64; 2], velocity: [f64; 2]) -> [f64; 2] {
        match *self {
            Self::None => [0.0; 2],
            Self::Push(force) => force,
            Self::Holds {
                place,
                sway,
                period,
                stiffness,
                damping,
            } => {
                let phase = std::f64::consts::TAU * time / period;
                [0, 1].map(|k| {
                    let away = place[k] + sway[k] * phase.sin() - position[k];
                    stiffness * away - damping * velocity[k]
                })
            }
        }
    }
}

/// Time at which the hand grips the handle.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Grip {
    /// From the start.
    Always,
    /// After the device is opened; until then the arm rests in its start pose.
    Waits,
    /// From this time on `[s]`; the hand moves the arm from this position `[m]`.
    Since(f64, [f64; 2]),
}

/// Time in which a hand moves the arm from its resting position to the hand's own position `[s]`.
const BRINGS_WITHIN: f64 = 0.6;

/// Wiring faults of the motors, relative to the generation's wiring.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Wiring {
    /// The motor cables are exchanged.
    pub swapped: bool,
    /// A motor's wires are exchanged.
    pub reversed: [bool; 2],
    /// A motor is without effect.
    pub dead: [bool; 2],
}

/// The arm in simulated time.
#[derive(Clone, Debug)]
pub struct Arm {
    layout: Layout,
    board: Board,
    wiring: Wiring,
    pub hand: Hand,
    grip: Grip,
    /// Initial state.
    start: Pantograph,
    pantograph: Pantograph,
    /// Last regular state, from which the arm continues after a singularity.
    regular: Pantograph,
    /// Time since the start up to which the arm has been simulated.
    moved: Duration,
    motors: [Motor; 2],
    /// Lost encoder counts, in revolutions.
    pub slipped: f64,
}

impl Arm {
    /// Creates the arm of a generation, at rest at `angles` `[degrees]`.
    pub fn new(
        generation: Generation,
        board: Board,
        wiring: Wiring,
        hand: Hand,
        amplifier: ActuatorParams,
        angles: [f64; 2],
    ) -> Result<Self, String> {
        let name = format!("2diy-gen{}", generation.number());
        let linkage = Linkage::preset(&name).ok_or_else(|| format!("unknown device {name}"))?;
        let params = PantographParams {
            // The board has its own.
            counts_per_rev: None,
            ..linkage.params
        };
        let pantograph = Pantograph::new(params)
            .and_then(|device| device.starting_at(angles.map(f64::to_radians), [0.0; 2]))
            .map_err(|error| error.to_string())?;
        let motor = Motor::new(amplifier).map_err(|error| error.to_string())?;
        Ok(Self {
            layout: generation.layout(),
            board,
            wiring,
            hand,
            grip: Grip::Always,
            start: pantograph,
            pantograph,
            regular: pantograph,
            moved: Duration::ZERO,
            motors: [motor; 2],
            slipped: 0.0,
        })
    }

    /// Simulates up to `now`, a time since the start.
    pub fn move_to(&mut self, now: Duration) {
        // After a stall of the machine, simulate at most 200 ms.
        let from = self
            .moved
            .max(now.saturating_sub(Duration::from_millis(200)));
        let longest = self.motors[0].longest_step().min(LONGEST_STEP);
        let mut time = from.as_secs_f64();
        let mut left = now.as_secs_f64() - time;
        while left > 0.0 {
            let step = left.min(longest);
            let (position, velocity) = (
                self.pantograph.end_point(),
                self.pantograph.end_point_velocity(),
            );
            let force = self.grip_force(time, position, velocity);
            if let Ok(pushed) = self.pantograph.with_user_force(force) {
                self.pantograph = pushed;
            }
            let [first, second] = &mut self.motors;
            let torques = [first.mean_over(step), second.mean_over(step)];
            self.pantograph.turn(torques, step);
            if self.pantograph.is_jammed() {
                // The stops of the real arm end the motion there, and a hand returns the arm.
                let angles = self.regular.pose().angles;
                if let Ok(freed) = self.regular.starting_at(angles, [0.0; 2]) {
                    self.pantograph = freed;
                }
            } else if self.pantograph.pose().sine.abs() > 0.2 {
                self.regular = self.pantograph;
            }
            time += step;
            left -= step;
        }
        self.moved = self.moved.max(now);
    }

    fn grip_force(&self, time: f64, position: [f64; 2], velocity: [f64; 2]) -> [f64; 2] {
        match self.grip {
            Grip::Always => self.hand.force(time, position, velocity),
            Grip::Waits => [0.0; 2],
            Grip::Since(since, from) => {
                let part = ((time - since) / BRINGS_WITHIN).clamp(0.0, 1.0);
                let smooth = part * part * (3.0 - 2.0 * part);
                // The hand's target starts at the resting position.
                let seen = match self.hand {
                    Hand::Holds { place, .. } => {
                        [0, 1].map(|k| position[k] + (1.0 - smooth) * (place[k] - from[k]))
                    }
                    Hand::None | Hand::Push(_) => position,
                };
                // The oscillation starts at the hand's position.
                let swaying = (time - since - BRINGS_WITHIN).max(0.0);
                self.hand.force(swaying, seen, velocity)
            }
        }
    }

    /// Releases the arm in its start pose until the device is opened.
    pub fn wait(&mut self) {
        self.pantograph = self.start;
        self.grip = Grip::Waits;
    }

    /// Notifies the arm that the device has been opened.
    pub fn opened(&mut self) {
        if self.grip == Grip::Waits {
            // Delay the grip, so that the first angles are those of the start pose.
            let soon = self.moved.as_secs_f64() + 0.2;
            self.grip = Grip::Since(soon, self.position());
        }
    }

    /// Returns the angles of joints 1 and 2 `[degrees]`.
    pub fn angles(&self) -> [f64; 2] {
        self.pantograph.pose().angles.map(f64::to_degrees)
    }

    /// Returns the end-point `[m]`.
    pub fn position(&self) -> [f64; 2] {
        self.pantograph.end_point()
    }

    /// Returns the effective mass at the end-point along the unit vector `direction` in the current pose `[kg]`: 1 /
    /// (dᵀ J M⁻¹ Jᵀ d).
    pub fn effective_mass(&self, direction: [f64; 2]) -> f64 {
        let pose = self.pantograph.pose();
        let [x, y] = pose.jacobian();
        let row = [0, 1].map(|joint| direction[0] * x[joint] + direction[1] * y[joint]);
        let [[a, b], [_, d]] = self.pantograph.dynamics().mass_matrix(pose);
        let [p, q] = row;
        (a * d - b * b) / (p * p * d - 2.0 * p * q * b + q * q * a)
    }

    /// Returns the commanded torques of the motors, by joint `[N m]`.
    pub fn torques(&self) -> [f64; 2] {
        self.motors.map(|motor| motor.messages)
    }

    /// Sets the motors to zero torque.
    pub fn lose_power(&mut self) {
        for motor in &mut self.motors {
            motor.messages = 0.0;
        }
    }
}

impl Ports for Arm {
    fn drive(&mut self, port: u8, level: bool, duty: f64) {
        let Some(sold) = (0..2).find(|joint| self.layout.joints[*joint].motor_port == port) else {
            return;
        };
        let joint = if self.wiring.swapped { 1 - sold } else { sold };
        if self.wiring.dead[joint] {
            return;
        }
        // In the original wiring, the level of a positive torque turns the joint in the positive direction of its
        // angle.
        let direction = self.layout.joints[sold].motor_direction.byte();
        let (positive, _) = pins(self.board, port, direction, 1.0);
        let sign = if (level == positive) ^ self.wiring.reversed[joint] {
            1.0
        } else {
            -1.0
        };
        // Adding 0.0 normalises -0.0.
        self.motors[joint].messages = sign * duty * f64::from(LARGEST_TORQUE) + 0.0;
    }

    fn revolutions(&mut self, port: u8) -> f64 {
        let Some(joint) = (0..2).find(|joint| self.layout.joints[*joint].encoder_port == port)
        else {
            return 0.0;
        };
        let turned = self.pantograph.pose().angles[joint] / std::f64::consts::TAU + self.slipped;
        // In the original wiring, the direction set by SETUP is that of the angle.
        if self.layout.joints[joint].encoder_direction.byte() == 0 {
            -turned
        } else {
            turned
        }
    }
}
