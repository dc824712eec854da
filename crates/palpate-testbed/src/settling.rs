//! Response of a linear device to a force that settles exponentially, computed once per duration.

use crate::actuator::{LONGEST_PIECE, in_pieces};
use crate::device::DevicePlant;

/// Values of the last two keys: with a fractional delay, the two parts of a period alternate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Recent<K, T> {
    entries: [(K, T); 2],
    oldest: usize,
}

impl<K: Copy + PartialEq, T: Copy> Recent<K, T> {
    pub fn new(key: K, value: T) -> Self {
        Self {
            entries: [(key, value); 2],
            oldest: 0,
        }
    }

    /// Returns the value of `key`, which `make` computes if neither entry has it.
    pub fn get(&mut self, key: K, make: impl FnOnce() -> T) -> T {
        for (known, value) in &self.entries {
            if *known == key {
                return *value;
            }
        }
        let value = make();
        self.entries[self.oldest] = (key, value);
        self.oldest = 1 - self.oldest;
        value
    }
}

/// A linear device, m ξ″ = f_u − k ξ − b ξ′ − f, whose state and user force can be replaced.
pub(crate) trait LinearPlant: DevicePlant + Sized {
    /// Returns the same device in another state, under a user force that gives `acceleration` `[m/s²]`.
    fn placed(&self, position: f64, velocity: f64, acceleration: f64) -> Self;

    /// Adds to the position `[m]` and the velocity `[m/s]`.
    fn kick(&mut self, position: f64, velocity: f64);

    /// Returns the acceleration by the user force and a force on the object `[m/s²]`.
    fn acceleration(&self, force_on_object: f64) -> f64;
}

/// Effect of the force e^(−t/τ) `[N]` on a linear device over a duration, in addition to that of the constant forces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Settling {
    /// Change of the position `[m/N]`.
    position: f64,
    /// Change of the velocity `[m/(N s)]`.
    velocity: f64,
    /// Integral of e^(−t/τ) ξ′ per position, velocity and acceleration at the start, and per newton of the force
    /// itself.
    work: [f64; 4],
}

impl Settling {
    pub const NONE: Self = Self {
        position: 0.0,
        velocity: 0.0,
        work: [0.0; 4],
    };

    /// Computes the response of `device` for a `lag` τ `[s]` and a `duration` `[s]`.
    pub fn of(device: &impl LinearPlant, lag: f64, duration: f64) -> Self {
        let moved = |position, velocity, acceleration| {
            let mut device = device.placed(position, velocity, acceleration);
            let work = in_pieces(&mut device, (0.0, 1.0), lag, duration, LONGEST_PIECE);
            (device, work)
        };
        let (end, alone) = moved(0.0, 0.0, 0.0);
        let beside =
            |position, velocity, acceleration| moved(position, velocity, acceleration).1 - alone;
        Self {
            position: end.position(),
            velocity: end.velocity(),
            work: [
                beside(1.0, 0.0, 0.0),
                beside(0.0, 1.0, 0.0),
                beside(0.0, 0.0, 1.0),
                alone,
            ],
        }
    }

    /// Moves `device` on while the force on the object is `aim + excess e^(−t/τ)` `[N]`; returns the work.
    pub fn advance(
        &self,
        device: &mut impl LinearPlant,
        aim: f64,
        excess: f64,
        duration: f64,
    ) -> f64 {
        let [by_position, by_velocity, by_acceleration, by_force] = self.work;
        let before = device.position();
        let weighted_travel = by_position * before
            + by_velocity * device.velocity()
            + by_acceleration * device.acceleration(aim)
            + by_force * excess;
        device.advance(aim, duration);
        device.kick(self.position * excess, self.velocity * excess);
        aim * (device.position() - before) + excess * weighted_travel
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sprung_mass::SprungMass;
    use crate::viscous_mass::ViscousMass;

    fn moves_as_in_pieces(device: impl LinearPlant + Copy) {
        for lag in [1e-5, 2e-4, 3e-3, 0.5] {
            let (mut at_once, mut pieces) = (device, device);
            let durations = [0.0007, 0.0013, 0.004].into_iter().cycle();
            for (i, duration) in (0..40_u32).zip(durations) {
                let (aim, excess) = (f64::from(i % 7) - 2.0, 3.0 - f64::from(i % 5));
                let work = at_once
                    .advance_settling(aim, excess, lag, duration)
                    .unwrap();
                let expected = in_pieces(&mut pieces, (aim, excess), lag, duration, LONGEST_PIECE);
                assert!((work - expected).abs() < 1e-13, "{work} {expected}");
            }
            let off = [
                at_once.position() - pieces.position(),
                at_once.velocity() - pieces.velocity(),
            ];
            assert!(pieces.position().abs() > 1e-3);
            assert!(off[0].abs() < 1e-13 && off[1].abs() < 1e-12, "{off:?}");
        }
    }

    #[test]
    fn a_settling_force_moves_a_linear_device_as_its_pieces_do() {
        for friction in [0.0, 0.5, 30.0] {
            let device = ViscousMass::new(0.2, friction, 0.7);
            moves_as_in_pieces(device.and_then(|it| it.starting_at(0.01, -0.3)).unwrap());
        }
        for (stiffness, damping) in [(30.0, 1.0), (3000.0, 40.0)] {
            let device = SprungMass::new(0.2, stiffness, damping, 8.0);
            moves_as_in_pieces(device.and_then(|it| it.starting_at(0.01, -0.3)).unwrap());
        }
    }

    #[test]
    fn values_of_two_keys_are_kept() {
        let mut made = 0;
        let mut recent = Recent::new(0, 0);
        for key in [1, 2, 1, 2, 3, 2, 1] {
            let value = recent.get(key, || {
                made += 1;
                10 * key
            });
            assert_eq!(value, 10 * key);
        }
        assert_eq!(made, 4, "1, 2, 3 in place of 1, and 1 in place of 2");
    }
}
