//! Virtual devices, which replace a haptic device between two samples.
//!
//! A device is driven through one port. The loop holds a force and the device moves. The device computes the work
//! through the port, independently of the renderer that chose the force.

use crate::InvalidParameter;
use crate::error::{finite, positive};

/// A device with one contact direction.
pub trait DevicePlant {
    /// Position ξ of the end-point `[m]`.
    fn position(&self) -> f64;

    /// Velocity ξ′ of the end-point `[m/s]`.
    fn velocity(&self) -> f64;

    /// Moves on for `duration` `[s]` while `force_on_object` `[N]` is held.
    ///
    /// The device itself receives the opposite force. Returns the work ∫ f ξ′ dt `[J]` that the
    /// device has done on the object through the port; it is negative while the object pushes the
    /// device back.
    fn advance(&mut self, force_on_object: f64, duration: f64) -> f64;

    /// Moves on for `duration` `[s]` while the force on the object is `aim + excess e^(−t/lag)` `[N]`, `lag` in `[s]`.
    ///
    /// Returns the work as [`advance`](DevicePlant::advance) does; `None`, without a motion, from a device that needs a
    /// force in pieces.
    fn advance_settling(
        &mut self,
        _aim: f64,
        _excess: f64,
        _lag: f64,
        _duration: f64,
    ) -> Option<f64> {
        None
    }

    /// A sample instant of a loop with this period `[s]`, before a force is held: where the
    /// device's own controllers run. Most have none.
    fn sample(&mut self, _period: f64) {}

    /// Energy `[J]` stored in the device and in the constant forces that act on it.
    ///
    /// For a device without losses it falls by exactly what [`advance`](DevicePlant::advance) returns.
    fn stored_energy(&self) -> f64;
}

/// A mass without friction, pushed by a constant user force: m ξ″ = f_u − f.
///
/// Under a held force the acceleration is constant, so each advance is exact for any duration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointMass {
    mass: f64,
    user_force: f64,
    position: f64,
    velocity: f64,
}

impl PointMass {
    /// A mass `[kg]` under a constant user force `[N]`, at rest at the origin.
    ///
    /// # Errors
    ///
    /// `mass` is not finite and positive, or `user_force` is not finite.
    pub fn new(mass: f64, user_force: f64) -> Result<Self, InvalidParameter> {
        Ok(Self {
            mass: positive("mass", mass, "finite and above 0 kg")?,
            user_force: finite("user_force", user_force, "finite [N]")?,
            position: 0.0,
            velocity: 0.0,
        })
    }

    /// Returns the same device at another position `[m]` and velocity `[m/s]`.
    ///
    /// # Errors
    ///
    /// `position` or `velocity` is not finite.
    pub fn starting_at(self, position: f64, velocity: f64) -> Result<Self, InvalidParameter> {
        Ok(Self {
            position: finite("position", position, "finite [m]")?,
            velocity: finite("velocity", velocity, "finite [m/s]")?,
            ..self
        })
    }

    /// Mass m `[kg]`.
    #[must_use]
    pub fn mass(&self) -> f64 {
        self.mass
    }

    /// Constant force f_u of the user `[N]`.
    #[must_use]
    pub fn user_force(&self) -> f64 {
        self.user_force
    }
}

impl DevicePlant for PointMass {
    fn position(&self) -> f64 {
        self.position
    }

    fn velocity(&self) -> f64 {
        self.velocity
    }

    fn advance(&mut self, force_on_object: f64, duration: f64) -> f64 {
        let acceleration = (self.user_force - force_on_object) / self.mass;
        let travel = duration * (self.velocity + 0.5 * acceleration * duration);
        self.position += travel;
        self.velocity += acceleration * duration;
        // The force is held, so the integral of power is force times travel.
        force_on_object * travel
    }

    /// m ξ′²/2 − f_u ξ `[J]`.
    fn stored_energy(&self) -> f64 {
        0.5 * self.mass * self.velocity * self.velocity - self.user_force * self.position
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_held_force_gives_the_textbook_parabola() {
        let mut device = PointMass::new(0.25, 1.0)
            .and_then(|device| device.starting_at(0.02, -0.3))
            .unwrap();
        device.advance(3.0, 0.02);
        // acceleration (1 - 3) / 0.25 = -8 m/s²
        assert!((device.position() - (0.02 - 0.3 * 0.02 - 4.0 * 0.0004)).abs() < 1e-16);
        assert!((device.velocity() - (-0.3 - 0.16)).abs() < 1e-16);
    }

    #[test]
    fn one_long_step_equals_many_short_ones() {
        let mut long = PointMass::new(0.1, 0.981).unwrap();
        let mut short = long;
        long.advance(-2.0, 1.0);
        for _ in 0..1000 {
            short.advance(-2.0, 0.001);
        }
        assert!((long.position() - short.position()).abs() < 1e-11);
        assert!((long.velocity() - short.velocity()).abs() < 1e-11);
    }

    #[test]
    fn what_leaves_the_store_went_through_the_port() {
        let mut device = PointMass::new(0.25, 1.0)
            .and_then(|device| device.starting_at(-0.01, 0.4))
            .unwrap();
        for force in [0.0, 5.0, -1.5, 80.0] {
            let before = device.stored_energy();
            let work = device.advance(force, 0.013);
            assert!((before - device.stored_energy() - work).abs() < 1e-13);
        }
    }

    #[test]
    fn a_rejected_parameter_is_named() {
        let error = PointMass::new(-0.1, 0.0).unwrap_err();
        assert_eq!(
            error.to_string(),
            "mass = -0.1 is not allowed; allowed: finite and above 0 kg"
        );
        assert_eq!(
            PointMass::new(0.1, f64::NAN).unwrap_err().name,
            "user_force"
        );
    }
}
