//! The right-hand side of the equations of motion.

use super::{Condition, Instant, Mode, Rigid, System, TURNED_WITHIN, quaternion, slip_direction};
use crate::world::vector::{Vec3, quaternion_rate};

impl System {
    /// The right-hand side.
    pub fn rates(
        &self,
        time: f64,
        state: &[f64],
        conditions: &[Condition],
        now: &mut Instant,
        rates: &mut [f64],
    ) {
        self.evaluate(time, state, conditions, now);
        self.device_rates(time, state, now, rates);
        self.body_rates(state, now, rates);
        self.contact_rates(state, conditions, now, rates);
        for (number, hold) in now.holds.iter().enumerate() {
            rates[self.layout.joint_sum(number)] = hold.power;
        }
    }

    /// Writes the rates of the devices and of their sums at a time `[s]`.
    fn device_rates(&self, time: f64, state: &[f64], now: &Instant, rates: &mut [f64]) {
        let layout = &self.layout;
        for (number, device) in self.devices.iter().enumerate() {
            let place = layout.device(number);
            let (placed, force) = (&now.placed[number], now.forces[number]);
            placed.velocity.write(&mut rates[place..]);
            now.accelerations[number]
                .linear
                .write(&mut rates[place + 3..]);
            let sums = layout.device_sums(number);
            let by_hand = now.grasps[number].force(device, time, placed, force);
            let force = device.along_its_axes(force);
            force.write(&mut rates[sums..]);
            Vec3(force.0.map(|f| f * f)).write(&mut rates[sums + 3..]);
            rates[sums + 6] = by_hand.dot(placed.velocity);
            Vec3(force.0.map(|f| f * time)).write(&mut rates[layout.moment_sums(number)..]);
            if let Some(turning) = &device.turning {
                let q = quaternion(&state[place + 6..]);
                let by_hand = now.hand_torque(number, turning, (time, q));
                let torque = turning.of_contacts(now.torques[number]);
                // The hand takes up the remaining torque.
                let taken_up = torque - now.torques[number];
                rates[place + 6..place + 10].copy_from_slice(&quaternion_rate(q, placed.turning));
                (torque + by_hand).write(&mut rates[place + 10..]);
                rates[sums + 6] += (by_hand + taken_up).dot(placed.turning);
                let sums = layout.torque_sums(number);
                torque.write(&mut rates[sums..]);
                Vec3(torque.0.map(|t| t * t)).write(&mut rates[sums + 3..]);
            }
        }
    }

    /// Writes the rates of the free bodies.
    fn body_rates(&self, state: &[f64], now: &Instant, rates: &mut [f64]) {
        let layout = &self.layout;
        for (number, rigid) in self.bodies.iter().enumerate() {
            let Some(Rigid { free, .. }) = rigid else {
                continue;
            };
            let member = self.devices.len() + number;
            let (place, placed) = (layout.body(*free), &now.placed[member]);
            placed.velocity.write(&mut rates[place..]);
            now.accelerations[member]
                .linear
                .write(&mut rates[place + 3..]);
            let turning = quaternion_rate(quaternion(&state[place + 6..]), placed.turning);
            rates[place + 6..place + 10].copy_from_slice(&turning);
            now.torques[member].write(&mut rates[place + 10..]);
        }
    }

    /// Writes the rates of the bristles and of the contacts' sums.
    fn contact_rates(
        &self,
        state: &[f64],
        conditions: &[Condition],
        now: &Instant,
        rates: &mut [f64],
    ) {
        let layout = &self.layout;
        for (number, (contact, condition)) in self.contacts.iter().zip(conditions).enumerate() {
            let touch = &now.touches[number];
            let law = &contact.law;
            let normal_force = now.normal_forces[number];
            let place = layout.bristle(number);
            let bristle = Vec3::new(&state[place..]);
            let bristle_rate = match condition.mode {
                Mode::Stick => touch.tangential() + touch.carried(bristle),
                Mode::Slip => {
                    let direction = slip_direction(bristle, touch);
                    let back = direction * now.slips[number];
                    let rate = touch.tangential() + touch.carried(bristle) - back;
                    let held = (1.0 - bristle.norm() / TURNED_WITHIN).max(0.0);
                    rate - touch.tangential().across(direction) * held
                }
                Mode::Free | Mode::Clipped | Mode::Smooth => Vec3::ZERO,
            };
            bristle_rate.write(&mut rates[place..]);
            let sums = layout.contact_sums(number);
            rates[sums] = normal_force;
            let damper = now.bristle_dampers[number];
            let force = touch.normal * normal_force - now.bristles[number] * law.friction_stiffness
                + damper;
            force.write(&mut rates[sums + 1..]);
            rates[sums + 4] = match condition.mode {
                Mode::Free => 0.0,
                mode => {
                    let push = if mode == Mode::Clipped {
                        0.0
                    } else {
                        self.raw_normal_force(number, touch).max(0.0)
                    };
                    let in_normal = (push - law.stiffness * touch.penetration) * touch.rate;
                    let in_bristle = -damper.dot(touch.tangential());
                    in_normal + law.friction * normal_force * now.slips[number] + in_bristle
                }
            };
        }
    }
}
