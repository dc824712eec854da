//! A mass with viscous friction in the hand's spring and damper, as fast as one without.
//!
//! A [`HeldMass`](crate::held_mass::HeldMass) moves the same way, among much else. This one is for
//! maps of thousands of scenes: the response to one duration is computed once and kept.

use crate::InvalidParameter;
use crate::device::DevicePlant;
use crate::error::{finite, positive};
use crate::settling::{LinearPlant, Recent, Settling};

/// M ξ″ = f_u − k ξ − b ξ′ − f, exact under a held force for any duration. M is the mass of device and
/// hand together, b the damping of both.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SprungMass {
    mass: f64,
    stiffness: f64,
    damping: f64,
    user_force: f64,
    position: f64,
    velocity: f64,
    responses: Recent<f64, Response>,
    /// Responses to a settling force, by lag and duration `[s]`.
    settling: Recent<(f64, f64), Settling>,
}

/// Effect of a duration on position, velocity and a constant acceleration a `[m/s²]`:
///
/// ```text
/// ξ  → pp ξ + pv ξ′ + pa a
/// ξ′ → vp ξ + vv ξ′ + va a
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
struct Response {
    pp: f64,
    pv: f64,
    pa: f64,
    vp: f64,
    vv: f64,
    va: f64,
}

/// The power series is summed over a part of the duration in which the fastest rate turns by less
/// than this `[rad]`; doubling makes the duration of it.
const SERIES_UP_TO: f64 = 0.5;

impl Response {
    /// Returns the response of ξ″ = a − s ξ − d ξ′.
    fn after(duration: f64, stiffness: f64, damping: f64) -> Self {
        let rate = stiffness.sqrt() + damping;
        let (mut part, mut doublings) = (duration, 0);
        while rate * part > SERIES_UP_TO {
            part *= 0.5;
            doublings += 1;
        }
        let mut response = Self::of_series(part, stiffness, damping);
        for _ in 0..doublings {
            response = response.twice();
        }
        response
    }

    fn of_series(duration: f64, stiffness: f64, damping: f64) -> Self {
        // ξ(h) from ξ = 1, from ξ′ = 1 and from a = 1, each by the terms of its own Taylor series:
        // velocity term n+1 = (a of n = 0 − s position term n − d velocity term n) h/(n+1).
        let column = |position: f64, velocity: f64, acceleration: f64| {
            let (mut p, mut v) = (position, velocity);
            let (mut sum_p, mut sum_v) = (p, v);
            let mut push = acceleration;
            let mut n = 0.0;
            loop {
                n += 1.0;
                let next_v = (push - stiffness * p - damping * v) * duration / n;
                p = v * duration / n;
                v = next_v;
                push = 0.0;
                if sum_p + p == sum_p && sum_v + v == sum_v && n > 2.0 {
                    return (sum_p, sum_v);
                }
                sum_p += p;
                sum_v += v;
            }
        };
        let (pp, vp) = column(1.0, 0.0, 0.0);
        let (pv, vv) = column(0.0, 1.0, 0.0);
        let (pa, va) = column(0.0, 0.0, 1.0);
        Self {
            pp,
            pv,
            pa,
            vp,
            vv,
            va,
        }
    }

    /// The response to twice the duration.
    fn twice(self) -> Self {
        let Self {
            pp,
            pv,
            pa,
            vp,
            vv,
            va,
        } = self;
        Self {
            pp: pp * pp + pv * vp,
            pv: pp * pv + pv * vv,
            pa: pp * pa + pv * va + pa,
            vp: vp * pp + vv * vp,
            vv: vp * pv + vv * vv,
            va: vp * pa + vv * va + va,
        }
    }
}

impl SprungMass {
    /// A moved mass `[kg]` on a spring `[N/m]`, relaxed at the origin, with a damping `[N s/m]` and under a
    /// constant user force `[N]`, at rest at the origin.
    ///
    /// # Errors
    ///
    /// `mass` is not finite and positive, `stiffness` or `damping` is not finite and at least 0 or not
    /// so when divided by the mass, or `user_force` is not finite.
    pub fn new(
        mass: f64,
        stiffness: f64,
        damping: f64,
        user_force: f64,
    ) -> Result<Self, InvalidParameter> {
        positive("mass", mass, "finite and above 0 kg")?;
        for (name, value, allowed) in [
            (
                "stiffness",
                stiffness,
                "at least 0 N/m, and finite when divided by the mass",
            ),
            (
                "damping",
                damping,
                "at least 0 N s/m, and finite when divided by the mass",
            ),
        ] {
            let is_allowed = value >= 0.0 && (value / mass).is_finite();
            InvalidParameter::unless(is_allowed, name, value, allowed)?;
        }
        Ok(Self {
            mass,
            stiffness,
            damping,
            user_force: finite("user_force", user_force, "finite [N]")?,
            position: 0.0,
            velocity: 0.0,
            responses: Recent::new(0.0, Response::after(0.0, stiffness / mass, damping / mass)),
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

impl DevicePlant for SprungMass {
    fn position(&self) -> f64 {
        self.position
    }

    fn velocity(&self) -> f64 {
        self.velocity
    }

    fn advance(&mut self, force_on_object: f64, duration: f64) -> f64 {
        let (stiffness, damping) = (self.stiffness / self.mass, self.damping / self.mass);
        let make = || Response::after(duration, stiffness, damping);
        let Response {
            pp,
            pv,
            pa,
            vp,
            vv,
            va,
        } = self.responses.get(duration, make);
        let acceleration = (self.user_force - force_on_object) / self.mass;
        let (before, velocity) = (self.position, self.velocity);
        self.position = pp * before + pv * velocity + pa * acceleration;
        self.velocity = vp * before + vv * velocity + va * acceleration;
        force_on_object * (self.position - before)
    }

    fn advance_settling(&mut self, aim: f64, excess: f64, lag: f64, duration: f64) -> Option<f64> {
        let device = *self;
        let make = || Settling::of(&device, lag, duration);
        let settling = self.settling.get((lag, duration), make);
        Some(settling.advance(self, aim, excess, duration))
    }

    /// M ξ′²/2 + k ξ²/2 − f_u ξ `[J]`; the damping takes its share of it, too.
    fn stored_energy(&self) -> f64 {
        0.5 * self.mass * self.velocity * self.velocity
            + 0.5 * self.stiffness * self.position * self.position
            - self.user_force * self.position
    }
}

impl LinearPlant for SprungMass {
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
    use crate::hand::{Hand, IntendedPath, Intention};
    use crate::held_mass::HeldMass;
    use crate::viscous_mass::ViscousMass;

    const FORCES: [f64; 6] = [0.0, 3.0, -1.5, 80.0, 0.2, 1.0];

    #[test]
    fn it_moves_like_a_held_mass_in_the_same_hand() {
        // Weakly and strongly damped, and about critical: 2 √(300 · 0.3) = 18.97 N s/m.
        for (stiffness, damping) in [
            (300.0, 3.0),
            (400.0, 20.0),
            (300.0, 18.9737),
            (1e-6, 1e-6),
            (0.0, 5.0),
            (3e4, 600.0),
        ] {
            let hand = Hand::Impedance {
                mass: 0.05,
                stiffness,
                damping,
                intention: Intention {
                    path: IntendedPath::Constant(0.0),
                    tremor: None,
                },
                force: 1.0,
                tremor: None,
            };
            let mut held = HeldMass::new(0.25, hand)
                .and_then(|held| held.with_friction(0.04, 0.0))
                .and_then(|held| held.starting_at(0.01, -0.7))
                .unwrap();
            let mut sprung = SprungMass::new(0.3, stiffness, damping + 0.04, 1.0)
                .and_then(|device| device.starting_at(0.01, -0.7))
                .unwrap();
            for (force, duration) in FORCES.into_iter().zip([0.02, 0.02, 1e-4, 0.3, 0.02, 0.1]) {
                let (a, b) = (
                    held.advance(force, duration),
                    sprung.advance(force, duration),
                );
                let what = format!("{stiffness} N/m, {damping} N s/m, {force} N");
                assert!((a - b).abs() <= 1e-11 * (1.0 + a.abs()), "{what}: {a} {b}");
                let position = (held.position() - sprung.position()).abs();
                assert!(position <= 1e-12 * (1.0 + held.position().abs()), "{what}");
                let velocity = (held.velocity() - sprung.velocity()).abs();
                assert!(velocity <= 1e-11 * (1.0 + held.velocity().abs()), "{what}");
            }
        }
    }

    #[test]
    fn without_a_spring_it_is_a_viscous_mass() {
        let mut viscous = ViscousMass::new(0.25, 3.0, 1.0).unwrap();
        let mut sprung = SprungMass::new(0.25, 0.0, 3.0, 1.0).unwrap();
        for force in FORCES {
            viscous.advance(force, 0.013);
            sprung.advance(force, 0.013);
            assert!((viscous.position() - sprung.position()).abs() < 1e-14);
            assert!((viscous.velocity() - sprung.velocity()).abs() < 1e-13);
        }
    }

    #[test]
    fn a_spring_without_damping_keeps_its_energy() {
        let mut sprung = SprungMass::new(0.25, 400.0, 0.0, 1.0)
            .and_then(|device| device.starting_at(0.02, 0.3))
            .unwrap();
        let before = sprung.stored_energy();
        for _ in 0..1000 {
            sprung.advance(0.0, 0.02);
        }
        let change = sprung.stored_energy() / before - 1.0;
        assert!(change.abs() < 1e-11, "{change}");
    }

    #[test]
    fn a_rejected_parameter_is_named() {
        let refused = |mass, stiffness, damping| {
            SprungMass::new(mass, stiffness, damping, 0.0)
                .unwrap_err()
                .name
        };
        assert_eq!(refused(0.0, 1.0, 1.0), "mass");
        assert_eq!(refused(0.25, -1.0, 1.0), "stiffness");
        assert_eq!(refused(0.25, 1.0, f64::INFINITY), "damping");
    }
}
