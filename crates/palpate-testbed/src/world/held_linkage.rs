//! A device with a table of masses in its hand, under a force that is held.

use super::dormand_prince::Step;
use super::mass_table::MassTable;
use super::motion::Grasp;
use super::scene::{Vector, WorldDevice};
use super::vector::Vec3;
use crate::actuator::ActuatorParams;

/// Longest step of the integration `[s]`. Its error is of order 5; rates of a hand and of a linkage are below 1 kHz.
const LONGEST_STEP: f64 = 6.25e-5;
/// A step is at most this part of the lag.
const STEP_IN_LAGS: f64 = 0.125;

/// Position and velocity of such a device.
#[derive(Debug, Clone)]
pub(super) struct HeldLinkage {
    actuator: ActuatorParams,
    /// Position and velocity in the world.
    state: [f64; 6],
    /// The force that acts, for a lag.
    force: Vec3,
    time: f64,
    step: Step,
}

impl HeldLinkage {
    pub fn new(device: &WorldDevice, actuator: ActuatorParams) -> Self {
        let mut state = [0.0; 6];
        state[..3].copy_from_slice(&device.position);
        state[3..].copy_from_slice(&device.velocity);
        Self {
            actuator,
            state,
            force: Vec3::ZERO,
            time: 0.0,
            step: Step::of_size(6),
        }
    }

    pub fn position(&self) -> Vec3 {
        Vec3::new(&self.state)
    }

    pub fn velocity(&self) -> Vec3 {
        Vec3::new(&self.state[3..])
    }

    /// Advances under a commanded force on the tool. Returns the delivered impulse along the device's axes.
    pub fn advance(
        &mut self,
        (device, table, grasp): (&WorldDevice, &MassTable, &Grasp),
        command: Vector,
        duration: f64,
    ) -> Vector {
        let ActuatorParams { gain, lag } = self.actuator;
        let aim = Vec3(command) * gain;
        let (mut excess, mut longest) = (Vec3::ZERO, LONGEST_STEP);
        if lag > 0.0 {
            excess = self.force - aim;
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
            let start = self.state;
            self.step
                .take(done, &start, length, false, |time, state, rates| {
                    let (position, velocity) = (Vec3::new(state), Vec3::new(&state[3..]));
                    let by_hand = grasp.hand_force(device, begin + time, [position, velocity]);
                    let push = aim + excess * left(time) + by_hand
                        - velocity * device.drivetrain.viscous_friction;
                    velocity.write(rates);
                    table
                        .acceleration(device, [position, velocity, push])
                        .write(&mut rates[3..]);
                });
            self.state.copy_from_slice(self.step.end());
            done += length;
        }
        self.time += duration;
        self.force = aim + excess * left(duration);
        let impulse = aim * duration + excess * (lag * (1.0 - left(duration)));
        device.along_its_axes(impulse).0
    }
}
