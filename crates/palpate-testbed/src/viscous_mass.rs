//! A mass with viscous friction under a constant force, as fast as one without.
//!
//! A [`HeldMass`](crate::held_mass::HeldMass) moves the same way, among much else. This one is for
//! maps of thousands of scenes: the response to one duration is computed once and kept.

use crate::InvalidParameter;
use crate::device::DevicePlant;
use crate::error::{finite, positive};
use crate::settling::{LinearPlant, Recent, Settling};

/// m ξ″ = f_u − b ξ′ − f, exact under a held force for any duration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViscousMass {
    mass: f64,
    friction: f64,
    user_force: f64,
    position: f64,
    velocity: f64,
    responses: Recent<f64, Response>,
    /// Responses to a settling force, by lag and duration `[s]`.
    settling: Recent<(f64, f64), Settling>,
}

/// Effect of a duration on the velocity and on a constant acceleration.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Response {
    /// e^(−λh)
    kept: f64,
    /// (1 − e^(−λh))/λ `[s]`
    once: f64,
    /// (h − (1 − e^(−λh))/λ)/λ `[s²]`
    twice: f64,
}

/// Below this λh the closed form of the response loses more digits than its series.
const SMALL: f64 = 0.5;

impl Response {
    fn after(duration: f64, rate: f64) -> Self {
        let x = rate * duration;
        let kept = (-x).exp();
        if x > SMALL {
            let once = -(-x).exp_m1() / rate;
            return Self {
                kept,
                once,
                twice: (duration - once) / rate,
            };
        }
        // twice = h² (1/2! − x/3! + x²/4! − …), and once = h − λ twice.
        let (mut term, mut sum, mut n) = (0.5, 0.0, 2.0);
        while sum + term != sum {
            sum += term;
            n += 1.0;
            term *= -x / n;
        }
        let twice = duration * duration * sum;
        Self {
            kept,
            once: duration - rate * twice,
            twice,
        }
    }
}

impl ViscousMass {
    /// A mass `[kg]` with viscous friction b `[N s/m]` under a constant user force `[N]`, at rest at
    /// the origin.
    ///
    /// # Errors
    ///
    /// `mass` is not finite and positive, `friction` is not finite and at least 0, their ratio is
    /// not finite, or `user_force` is not finite.
    pub fn new(mass: f64, friction: f64, user_force: f64) -> Result<Self, InvalidParameter> {
        positive("mass", mass, "finite and above 0 kg")?;
        InvalidParameter::unless(
            friction >= 0.0 && (friction / mass).is_finite(),
            "friction",
            friction,
            "at least 0 N s/m, and finite when divided by the mass",
        )?;
        Ok(Self {
            mass,
            friction,
            user_force: finite("user_force", user_force, "finite [N]")?,
            position: 0.0,
            velocity: 0.0,
            responses: Recent::new(0.0, Response::after(0.0, friction / mass)),
            settling: Recent::new((0.0, 0.0), Settling::NONE),
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
}

impl DevicePlant for ViscousMass {
    fn position(&self) -> f64 {
        self.position
    }

    fn velocity(&self) -> f64 {
        self.velocity
    }

    fn advance(&mut self, force_on_object: f64, duration: f64) -> f64 {
        let rate = self.friction / self.mass;
        let make = || Response::after(duration, rate);
        let Response { kept, once, twice } = self.responses.get(duration, make);
        let acceleration = (self.user_force - force_on_object) / self.mass;
        let travel = self.velocity * once + acceleration * twice;
        self.position += travel;
        self.velocity = self.velocity * kept + acceleration * once;
        force_on_object * travel
    }

    fn advance_settling(&mut self, aim: f64, excess: f64, lag: f64, duration: f64) -> Option<f64> {
        let device = *self;
        let make = || Settling::of(&device, lag, duration);
        let settling = self.settling.get((lag, duration), make);
        Some(settling.advance(self, aim, excess, duration))
    }

    /// m ξ′²/2 − f_u ξ `[J]`; friction takes its share of it, too.
    fn stored_energy(&self) -> f64 {
        0.5 * self.mass * self.velocity * self.velocity - self.user_force * self.position
    }
}

impl LinearPlant for ViscousMass {
    fn placed(&self, position: f64, velocity: f64, acceleration: f64) -> Self {
        Self {
            position,
            velocity,
            user_force: self.mass * acceleration,
            ..*self
        }
    }

    fn kick(&mut self, position: f64, velocity: f64) {
        self.position += position;
        self.velocity += velocity;
    }

    fn acceleration(&self, force_on_object: f64) -> f64 {
        (self.user_force - force_on_object) / self.mass
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::PointMass;
    use crate::hand::Hand;
    use crate::held_mass::HeldMass;

    const FORCES: [f64; 6] = [0.0, 3.0, -1.5, 80.0, 0.2, 1.0];

    #[test]
    fn it_moves_like_a_held_mass_with_the_same_friction() {
        for friction in [1e-9, 0.04, 3.0, 30.0, 4000.0] {
            let hand = Hand::ConstantForce {
                force: 1.0,
                tremor: None,
            };
            let mut held = HeldMass::new(0.25, hand)
                .and_then(|held| held.with_friction(friction, 0.0))
                .and_then(|held| held.starting_at(0.01, -0.7))
                .unwrap();
            let mut viscous = ViscousMass::new(0.25, friction, 1.0)
                .and_then(|device| device.starting_at(0.01, -0.7))
                .unwrap();
            for force in FORCES {
                let (a, b) = (held.advance(force, 0.02), viscous.advance(force, 0.02));
                assert!((a - b).abs() <= 1e-12 * (1.0 + a.abs()), "{friction}");
                assert!((held.position() - viscous.position()).abs() < 1e-12);
                assert!((held.velocity() - viscous.velocity()).abs() < 1e-11);
            }
        }
    }

    #[test]
    fn without_friction_it_is_a_point_mass() {
        let mut point = PointMass::new(0.25, 1.0).unwrap();
        let mut viscous = ViscousMass::new(0.25, 0.0, 1.0).unwrap();
        for force in FORCES {
            point.advance(force, 0.013);
            viscous.advance(force, 0.013);
            assert!((point.position() - viscous.position()).abs() < 1e-15);
            assert!((point.velocity() - viscous.velocity()).abs() < 1e-14);
        }
    }

    #[test]
    fn pieces_of_any_length_add_up() {
        let mut long = ViscousMass::new(0.25, 5.0, 1.0).unwrap();
        let mut short = long;
        long.advance(-2.0, 0.3);
        for duration in [0.1, 0.05, 0.05, 0.1] {
            short.advance(-2.0, duration);
        }
        assert!((long.position() - short.position()).abs() < 1e-14);
    }

    #[test]
    fn a_rejected_parameter_is_named() {
        assert_eq!(
            ViscousMass::new(0.25, -1.0, 0.0).unwrap_err().name,
            "friction"
        );
        assert_eq!(ViscousMass::new(0.0, 1.0, 0.0).unwrap_err().name, "mass");
    }
}
