//! The forces of the hand and of the drivetrain on a device, between two of their events.

use std::f64::consts::TAU;

use super::Placed;
use crate::world::hand::WorldHand;
use crate::world::scene::WorldDevice;
use crate::world::vector::Vec3;

/// Relative tolerance on the largest friction of a device that is stuck.
const FRICTION_SLACK: f64 = 1e-9;
/// Tolerance on the direction in which a device slides `[m/s]`.
const SPEED_SLACK: f64 = 1e-13;

/// How a device is held until its hand releases it or a recorded rest bends.
#[derive(Debug, Clone, Copy)]
pub(in crate::world) struct Grasp {
    /// Whether the hand still holds the device.
    pub holds: bool,
    since: f64,
    rest: Vec3,
    rest_velocity: Vec3,
    /// Time of the next event `[s]`; infinite if there is none.
    pub until: f64,
    /// Direction in which the device slides along each of its axes: 1 or -1, or 0 where dry friction holds it.
    slides: [f64; 3],
}

impl Grasp {
    /// How `hand` holds its device from `time` `[s]` on.
    pub fn new(hand: &WorldHand, time: f64) -> Self {
        let release = hand.release.unwrap_or(f64::INFINITY);
        let still = (hand.rest, [0.0; 3], f64::INFINITY);
        let path = hand.path.as_ref();
        let (rest, velocity, bend) = path.map_or(still, |path| path.line_from(time));
        let holds = time < release;
        Self {
            holds,
            since: time,
            rest: Vec3(rest),
            rest_velocity: Vec3(velocity),
            until: if holds {
                bend.min(release)
            } else {
                f64::INFINITY
            },
            slides: [0.0; 3],
        }
    }

    /// Goes on to what holds from `time` `[s]` on.
    pub fn go_on(&mut self, hand: &WorldHand, time: f64) {
        *self = Self {
            slides: self.slides,
            ..Self::new(hand, time)
        };
    }

    /// Mass that moves along an axis of the device `[kg]`.
    pub fn mass(&self, device: &WorldDevice, axis: usize) -> f64 {
        device.mass[axis] + if self.holds { device.hand.mass } else { 0.0 }
    }

    /// Force of the hand on its device `[N]`.
    pub fn hand_force(&self, device: &WorldDevice, time: f64, [x, v]: [Vec3; 2]) -> Vec3 {
        if !self.holds {
            return Vec3::ZERO;
        }
        let hand = &device.hand;
        let tremor = hand.tremor.each_ref();
        let tremor = tremor.map(|sines| sines.iter().map(|sine| sine.value(time)).sum());
        let tremor = device.out(Vec3(tremor));
        let mut rest = self.rest + self.rest_velocity * (time - self.since);
        let mut moving = self.rest_velocity;
        if let Some(swing) = &hand.swing {
            let rate = TAU * swing.frequency_hz;
            let (sine, cosine) = (rate * time).sin_cos();
            rest += Vec3(swing.amplitude) * sine;
            moving += Vec3(swing.amplitude) * (rate * cosine);
        }
        Vec3(std::array::from_fn(|axis| {
            hand.force[axis] + tremor.0[axis]
                - hand.stiffness * (x.0[axis] - rest.0[axis])
                - hand.damping * (v.0[axis] - moving.0[axis])
        }))
    }

    /// Force of hand and friction on a device `[N]` that contacts push with `contact` `[N]`.
    pub fn force(&self, device: &WorldDevice, time: f64, placed: &Placed, contact: Vec3) -> Vec3 {
        let held = self.hand_force(device, time, [placed.position, placed.velocity]);
        if !device.has_friction() {
            return held;
        }
        let push = device.own(held + contact).0;
        let friction = self.friction(device, push, device.own(placed.velocity).0);
        held + device.out(Vec3(friction))
    }

    /// Force of the friction along each axis `[N]` of a device that is pushed with `push` and has a velocity `[m/s]`.
    fn friction(&self, device: &WorldDevice, push: [f64; 3], velocity: [f64; 3]) -> [f64; 3] {
        let coulomb = device.drivetrain.coulomb_friction;
        std::array::from_fn(|axis| {
            if !device.moves_along(axis) {
                0.0
            } else if coulomb > 0.0 && self.slides[axis] == 0.0 {
                -push[axis]
            } else {
                -device.drivetrain.viscous_friction * velocity[axis] - coulomb * self.slides[axis]
            }
        })
    }

    /// Whether the friction of a device that is pushed with `push` `[N]` is still what it was.
    pub fn lasts(&self, device: &WorldDevice, placed: &Placed, push: Vec3) -> bool {
        device.drivetrain.coulomb_friction == 0.0
            || (0..3).all(|axis| {
                let slides = self.slides[axis];
                if !device.moves_along(axis) {
                    true
                } else if slides == 0.0 {
                    let largest = device.drivetrain.coulomb_friction * (1.0 + FRICTION_SLACK);
                    device.own(push).0[axis].abs() <= largest
                } else {
                    device.own(placed.velocity).0[axis] * slides >= -SPEED_SLACK
                }
            })
    }

    /// Finds the directions in which a device slides that is pushed with `push` `[N]`, and returns its velocity
    /// `[m/s]`, which is 0 where it has just come to rest; whether a direction has changed.
    pub fn settle(&mut self, device: &WorldDevice, placed: &Placed, push: Vec3) -> (Vec3, bool) {
        let coulomb = device.drivetrain.coulomb_friction;
        if coulomb == 0.0 {
            return (placed.velocity, false);
        }
        let (push, before) = (device.own(push).0, self.slides);
        let mut velocity = device.own(placed.velocity).0;
        for axis in 0..3 {
            let stopped = velocity[axis] * self.slides[axis] <= 0.0
                && (self.slides[axis] != 0.0 || velocity[axis].abs() <= SPEED_SLACK);
            if !stopped {
                self.slides[axis] = velocity[axis].signum();
                continue;
            }
            velocity[axis] = 0.0;
            self.slides[axis] = if push[axis].abs() > coulomb * (1.0 + FRICTION_SLACK) {
                push[axis].signum()
            } else {
                0.0
            };
        }
        (device.out(Vec3(velocity)), self.slides != before)
    }
}
