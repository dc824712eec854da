//! A device with a flexible transmission, backlash and cogging, in a hand.
//!
//! ```text
//! m₁ x₁″ = −f + s − B x₁′ − F_c sgn(x₁′) + A sin(2π x₁/pitch)
//! (m₂ + m_h) x₂″ = −s + u(t, x₂, x₂′)
//! s = k_t d + c_t (x₂′ − x₁′),    d = x₂ − x₁ beyond half of the backlash; s = 0 within
//! ```
//!
//! Sensor and motor are on side 1, where the force f on the object acts and the contact is rendered; the
//! hand u is on side 2, which is the end-point. Without a transmission both sides are one body. The
//! **ideal** of such a device is therefore the contact at the motor's side: what a loop of infinite rate
//! with this sensor and this motor would render.
//!
//! The motion is integrated by velocity Verlet steps of at most 5 us, with friction by projection: the
//! error of a resonance at 300 Hz is 4e-6 of its frequency. Between two advances nothing is lost, but
//! cutting an advance in pieces moves the steps.

mod params;

pub use params::{Cogging, DrivetrainParams, Transmission};

use std::f64::consts::TAU;

use crate::InvalidParameter;
use crate::device::DevicePlant;
use crate::error::{finite, not_negative};
use crate::hand::Hand;

/// Longest step `[s]`.
const LONGEST_STEP: f64 = 5e-6;
/// Longest step in radians of the transmission's resonance, and of the hand.
const LONGEST_ANGLE: f64 = 0.02;

/// A [`DrivetrainParams`] in motion, held by a [`Hand`].
#[derive(Debug, Clone, PartialEq)]
pub struct Drivetrain {
    /// Mass of the motor's side, or of all there is where there is one body `[kg]`.
    motor_mass: f64,
    /// Mass of the end-point's side with that of the hand `[kg]`; 0 where there is one body.
    end_mass: f64,
    stiffness: f64,
    damping: f64,
    half_backlash: f64,
    params: DrivetrainParams,
    hand: Hand,
    longest_step: f64,
    time: f64,
    /// Time at which the hand releases the device `[s]`; infinite if it never does or already has.
    release: f64,
    motor: Side,
    end: Side,
}

/// Motion of one side.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Side {
    position: f64,
    velocity: f64,
}

impl Drivetrain {
    /// The device in a hand, at rest at the origin at time 0.
    ///
    /// # Errors
    ///
    /// A parameter outside the range in its description.
    pub fn new(params: DrivetrainParams, hand: Hand) -> Result<Self, InvalidParameter> {
        params.check()?;
        hand.check()?;
        let (mut motor_mass, mut end_mass) = (params.mass + hand.mass(), 0.0);
        let (mut stiffness, mut damping, mut half_backlash) = (0.0, 0.0, 0.0);
        let mut rate = (hand.stiffness() / motor_mass).sqrt() + hand.damping() / motor_mass;
        if let Some(transmission) = params.transmission {
            motor_mass = transmission.motor_share * params.mass;
            end_mass = params.mass - motor_mass + hand.mass();
            (stiffness, damping) = transmission.stiffness_and_damping(params.mass);
            half_backlash = 0.5 * transmission.backlash;
            rate = (hand.stiffness() / end_mass).sqrt()
                + hand.damping() / end_mass
                + TAU * transmission.resonance_hz;
        }
        Ok(Self {
            motor_mass,
            end_mass,
            stiffness,
            damping,
            half_backlash,
            params,
            hand,
            longest_step: LONGEST_STEP.min(LONGEST_ANGLE / rate),
            time: 0.0,
            release: f64::INFINITY,
            motor: Side::default(),
            end: Side::default(),
        })
    }

    /// Returns the same device at another position `[m]` and velocity `[m/s]`, both sides of it.
    ///
    /// # Errors
    ///
    /// `position` or `velocity` is not finite.
    pub fn starting_at(self, position: f64, velocity: f64) -> Result<Self, InvalidParameter> {
        let side = Side {
            position: finite("position", position, "finite [m]")?,
            velocity: finite("velocity", velocity, "finite [m/s]")?,
        };
        Ok(Self {
            motor: side,
            end: side,
            ..self
        })
    }

    /// Returns the device with a hand that releases it permanently at `time` `[s]`. The hand's force then ends, and its
    /// mass no longer moves with the device.
    ///
    /// # Errors
    ///
    /// `time` is not finite and at least 0.
    pub fn released_at(self, time: f64) -> Result<Self, InvalidParameter> {
        Ok(Self {
            release: not_negative("release", time, "finite and at least 0 s")?,
            ..self
        })
    }

    fn disable_output(&mut self) {
        if self.is_one_body() {
            self.motor_mass = self.params.mass;
        } else {
            self.end_mass = self.params.mass - self.motor_mass;
        }
        self.hand = Hand::pushing(0.0);
        self.release = f64::INFINITY;
    }

    /// Moves on in the same hand for a `duration` `[s]` above 0, under a finite force `[N]`.
    fn move_on(&mut self, force: f64, duration: f64) -> f64 {
        let steps = (duration / self.longest_step).ceil();
        let step = duration / steps;
        let (start, from) = (self.time, self.motor.position);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a whole number above 0; a longer advance than u64 counts does not end anyway"
        )]
        for number in 1..=steps as u64 {
            self.kick(force, 0.5 * step, false);
            self.motor.position += step * self.motor.velocity;
            self.end.position += step * self.end.velocity;
            self.time = start + number as f64 * step;
            self.kick(force, 0.5 * step, true);
        }
        self.time = start + duration;
        force * (self.motor.position - from)
    }

    /// Position x₂ `[m]` and velocity x₂′ `[m/s]` of the end-point, where the hand is.
    #[must_use]
    pub fn end_point(&self) -> (f64, f64) {
        let side = if self.is_one_body() {
            self.motor
        } else {
            self.end
        };
        (side.position, side.velocity)
    }

    fn is_one_body(&self) -> bool {
        self.end_mass == 0.0
    }

    /// Returns the stretch of the transmission beyond its backlash `[m]`.
    fn stretch(&self) -> f64 {
        let apart = self.end.position - self.motor.position;
        apart - apart.clamp(-self.half_backlash, self.half_backlash)
    }

    /// Forces `[N]` on the two sides that do not depend on velocities, and the damping `[N s/m]` that
    /// acts between the sides now.
    fn forces(&self, force_on_object: f64) -> (f64, f64, f64) {
        let cogging = self.params.cogging.map_or(0.0, |cogging| {
            cogging.amplitude * (TAU * self.motor.position / cogging.pitch).sin()
        });
        let on_motor = cogging - force_on_object;
        if self.is_one_body() {
            let hand = self.hand.force(self.time, self.motor.position, 0.0);
            return (on_motor + hand, 0.0, 0.0);
        }
        let hand = self.hand.force(self.time, self.end.position, 0.0);
        let stretch = self.stretch();
        let engaged = self.half_backlash == 0.0 || stretch != 0.0;
        let spring = self.stiffness * stretch;
        let damping = if engaged { self.damping } else { 0.0 };
        (on_motor + spring, hand - spring, damping)
    }

    /// Half a step of the velocities by forces and damping. The first half takes the damping at its start
    /// and the second at its end, so that both together are symmetric in time.
    fn kick(&mut self, force_on_object: f64, half: f64, is_second: bool) {
        let (on_motor, on_end, between) = self.forces(force_on_object);
        let viscous = self.params.viscous_friction;
        let held = self.hand.damping();
        if self.is_one_body() {
            let share = (viscous + held) * half / self.motor_mass;
            let push = on_motor * half / self.motor_mass;
            let velocity = self.motor.velocity;
            self.motor.velocity = if is_second {
                (velocity + push) / (1.0 + share)
            } else {
                velocity * (1.0 - share) + push
            };
        } else {
            let (a, b) = (half / self.motor_mass, half / self.end_mass);
            let (u, v) = (self.motor.velocity, self.end.velocity);
            // Damping matrix times the half step over the masses.
            let m = [
                [a * (viscous + between), -a * between],
                [-b * between, b * (held + between)],
            ];
            if is_second {
                let (p, q) = (u + a * on_motor, v + b * on_end);
                let (m00, m11) = (1.0 + m[0][0], 1.0 + m[1][1]);
                let determinant = m00 * m11 - m[0][1] * m[1][0];
                self.motor.velocity = (m11 * p - m[0][1] * q) / determinant;
                self.end.velocity = (m00 * q - m[1][0] * p) / determinant;
            } else {
                self.motor.velocity = u - m[0][0] * u - m[0][1] * v + a * on_motor;
                self.end.velocity = v - m[1][0] * u - m[1][1] * v + b * on_end;
            }
        }
        let most = self.params.coulomb_friction * half / self.motor_mass;
        if most > 0.0 {
            let velocity = self.motor.velocity;
            self.motor.velocity = velocity - velocity.clamp(-most, most);
        }
    }
}

impl DevicePlant for Drivetrain {
    /// Position x₁ of the motor's side `[m]`, where the sensor is.
    fn position(&self) -> f64 {
        self.motor.position
    }

    /// Velocity x₁′ of the motor's side `[m/s]`.
    fn velocity(&self) -> f64 {
        self.motor.velocity
    }

    /// A force that is not finite is not applied, and a duration that is not finite and above 0 moves
    /// nothing.
    fn advance(&mut self, force_on_object: f64, duration: f64) -> f64 {
        if !(duration.is_finite() && duration > 0.0) {
            return 0.0;
        }
        let force = if force_on_object.is_finite() {
            force_on_object
        } else {
            0.0
        };
        let held = self.release - self.time;
        if held >= duration {
            return self.move_on(force, duration);
        }
        let mut work = 0.0;
        if held > 0.0 {
            work += self.move_on(force, held);
        }
        self.disable_output();
        work + self.move_on(force, duration - held.max(0.0))
    }

    /// Energy of motion, of the transmission's and the hand's springs, of the cogging, and of the hand's
    /// constant force `[J]`.
    fn stored_energy(&self) -> f64 {
        let kinetic = |mass: f64, side: Side| 0.5 * mass * side.velocity * side.velocity;
        let (end, _) = self.end_point();
        let distance = self.hand.intended_position(self.time) - end;
        let cogging = self.params.cogging.map_or(0.0, |cogging| {
            let rate = TAU / cogging.pitch;
            cogging.amplitude / rate * (rate * self.motor.position).cos()
        });
        let stretch = if self.is_one_body() {
            0.0
        } else {
            self.stretch()
        };
        kinetic(self.motor_mass, self.motor)
            + kinetic(self.end_mass, self.end)
            + 0.5 * self.stiffness * stretch * stretch
            + 0.5 * self.hand.stiffness() * distance * distance
            + cogging
            - self.hand.constant_force() * end
    }
}
