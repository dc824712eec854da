//! Model of an actuator: a gain and a first-order lag between the commanded and the delivered force.
//!
//! ```text
//! τ y′ = g u − y,    y(0) = 0
//! ```
//!
//! with the command u as the driver sends it, the gain g (delivered over commanded force), the lag τ of the amplifier,
//! and the delivered force y. The [timeline](crate::timeline) models the delay.
//!
//! # Exact for a point mass
//!
//! A [`DevicePlant`] moves under held forces. A settling force is therefore delivered in pieces. Each piece is held in
//! two halves that have the impulse and the first moment of the exponential. At the end of each piece a mass under
//! constant forces has the position, velocity and port work that the exponential would have produced. A device whose
//! forces depend on its motion sees a second-moment error; the pieces are short against all of its rates. A linear
//! device computes its response to all pieces once ([`DevicePlant::advance_settling`]).

use crate::InvalidParameter;
use crate::device::DevicePlant;
use crate::error::positive;

/// Longest piece of a settling force `[s]`.
pub(crate) const LONGEST_PIECE: f64 = 2.5e-4;
/// Longest piece in lags.
const PIECE_IN_LAGS: f64 = 0.25;
/// Number of lags after which a force has settled: the remainder is below round-off.
const SETTLED_AFTER: f64 = 40.0;
/// Terms of the series of a piece, whose variable is at most [`PIECE_IN_LAGS`].
const TERMS: u32 = 14;

/// Gain and lag of an actuator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ActuatorParams {
    /// Delivered over commanded force g, finite and above 0.
    pub gain: f64,
    /// Time constant τ `[s]`, finite and at least 0.
    pub lag: f64,
}

impl Default for ActuatorParams {
    /// Gives what is commanded, at once.
    fn default() -> Self {
        Self {
            gain: 1.0,
            lag: 0.0,
        }
    }
}

/// An actuator, and the force that it gives now.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Actuator {
    params: ActuatorParams,
    force: f64,
}

/// Response of a device to one actuator step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Delivered {
    /// Mean over time of the force on the object `[N]`.
    pub mean_force: f64,
    /// Work through the device's port `[J]`, as [`DevicePlant::advance`] counts it.
    pub work: f64,
}

impl Actuator {
    /// An actuator that gives no force yet.
    ///
    /// # Errors
    ///
    /// A gain that is not finite and above 0, or a lag that is not finite and at least 0 s.
    pub fn new(params: ActuatorParams) -> Result<Self, InvalidParameter> {
        positive("gain", params.gain, "finite and above 0")?;
        InvalidParameter::unless(
            params.lag.is_finite() && params.lag >= 0.0,
            "lag",
            params.lag,
            "finite and at least 0 s",
        )?;
        Ok(Self { params, force: 0.0 })
    }

    /// Gain and lag.
    #[must_use]
    pub fn params(&self) -> ActuatorParams {
        self.params
    }

    /// Force on the object at the end of the last [`drive`](Self::drive) `[N]`; 0 before the first.
    #[must_use]
    pub fn force(&self) -> f64 {
        self.force
    }

    /// Force on the object that acts now while `command` is held at the input `[N]`.
    #[must_use]
    pub fn force_on(&self, command: f64) -> f64 {
        if self.params.lag == 0.0 {
            self.params.gain * command
        } else {
            self.force
        }
    }

    /// Moves `device` on for `duration` `[s]` while `command` `[N]`, a force on the object, is held at
    /// the input of this actuator.
    pub fn drive(
        &mut self,
        device: &mut impl DevicePlant,
        command: f64,
        duration: f64,
    ) -> Delivered {
        let aim = self.params.gain * command;
        let lag = self.params.lag;
        if lag == 0.0 {
            self.force = aim;
        }
        if lag == 0.0 || duration <= 0.0 {
            return Delivered {
                mean_force: self.force,
                work: device.advance(self.force, duration),
            };
        }
        let excess = self.force - aim;
        let work = device.advance_settling(aim, excess, lag, duration);
        let work =
            work.unwrap_or_else(|| in_pieces(device, (aim, excess), lag, duration, LONGEST_PIECE));
        self.force = aim + excess * (-duration / lag).exp();
        Delivered {
            mean_force: aim - excess * lag * (-duration / lag).exp_m1() / duration,
            work,
        }
    }

    /// Moves `device` on for `duration` `[s]` while a line is held at the input of this actuator, with a mean of
    /// `command` `[N]` over this duration and a `slope` `[N/s]`. A line is delivered without a lag.
    ///
    /// Each piece is held in two halves with its impulse and first moment. A mass under constant forces then ends with
    /// the position, velocity and port work of the line.
    pub fn drive_line(
        &mut self,
        device: &mut impl DevicePlant,
        command: f64,
        slope: f64,
        duration: f64,
    ) -> Delivered {
        let (aim, slope) = (self.params.gain * command, self.params.gain * slope);
        let pieces = (duration / LONGEST_PIECE).ceil().max(1.0);
        let piece = duration / pieces;
        let off = slope * piece / 3.0;
        let (mut work, mut done) = (0.0, 0.0);
        while done < pieces {
            let mean = aim + slope * (piece * (done + 0.5) - 0.5 * duration);
            work += device.advance(mean - off, 0.5 * piece);
            work += device.advance(mean + off, 0.5 * piece);
            done += 1.0;
        }
        self.force = aim + 0.5 * slope * duration;
        Delivered {
            mean_force: aim,
            work,
        }
    }
}

/// Moves `device` on for `duration` while the force on the object is aim + excess e^(−t/lag), in pieces of at most
/// `longest`; returns the work.
pub(crate) fn in_pieces(
    device: &mut impl DevicePlant,
    (aim, excess): (f64, f64),
    lag: f64,
    duration: f64,
    longest: f64,
) -> f64 {
    let settling = duration.min(SETTLED_AFTER * lag);
    let pieces = (settling / longest.min(PIECE_IN_LAGS * lag))
        .ceil()
        .max(1.0);
    let piece = settling / pieces;
    let [first, second, after] = halves(piece / lag);
    let (mut work, mut left) = (0.0, excess);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "at least 1, and bounded for every duration of a loop"
    )]
    for _ in 0..pieces as u64 {
        work += device.advance(aim + first * left, 0.5 * piece);
        work += device.advance(aim + second * left, 0.5 * piece);
        left *= after;
    }
    if duration > settling {
        work += device.advance(aim, duration - settling);
    }
    work
}

/// Returns the two values, each held for half of a piece of `x` lags, that match the integral and the first moment of
/// e^(−t/τ), which is 1 at the start of the piece. The third value is the exponential at its end.
fn halves(x: f64) -> [f64; 3] {
    // Mean a = Σ (−x)ⁿ/(n + 1)! and first moment over the squared length b = Σ (−x)ⁿ/(n! (n + 2)):
    // the closed forms are differences of nearly equal numbers.
    let (mut mean, mut moment, mut power) = (0.0, 0.0, 1.0);
    for n in 0..TERMS {
        mean += power / f64::from(n + 1);
        moment += power / f64::from(n + 2);
        power *= -x / f64::from(n + 1);
    }
    [3.0 * mean - 4.0 * moment, 4.0 * moment - mean, (-x).exp()]
}

#[cfg(test)]
#[allow(clippy::print_stdout)] // what was measured
mod tests {
    use super::*;
    use crate::device::PointMass;
    use crate::hand::{Hand, Intention, Sinusoid};
    use crate::held_mass::HeldMass;

    fn actuator(gain: f64, lag: f64) -> Actuator {
        Actuator::new(ActuatorParams { gain, lag }).unwrap()
    }

    #[test]
    fn a_perfect_actuator_changes_no_bit() {
        let mut driven = PointMass::new(0.17, 0.3).unwrap();
        let mut alone = driven;
        let mut perfect = Actuator::default();
        for (force, duration) in [(0.3, 0.001), (-7.1, 0.02), (1.0 / 3.0, 1e-7), (2.0, 0.0)] {
            let delivered = perfect.drive(&mut driven, force, duration);
            assert_eq!(delivered.work, alone.advance(force, duration));
            assert_eq!(delivered.mean_force, force);
            assert_eq!(driven, alone);
        }
    }

    /// With y = g u + c e^(−t/τ): v = v₀ + ((f_u − g u) t − c τ (1 − e^(−t/τ)))/m, and its integral.
    #[test]
    fn a_point_mass_follows_the_closed_form_over_any_duration() {
        let (mass, push) = (0.08, 0.4);
        for lag in [1e-6, 1e-4, 3e-4, 5e-3, 10.0] {
            for duration in [1e-5, 1e-3, 0.02] {
                let mut device = PointMass::new(mass, push).unwrap();
                let mut real = actuator(0.9, lag);
                let (mut force, mut position, mut velocity) = (0.0, 0.0, 0.0);
                for command in [5.0, -3.0, 0.0, 12.0] {
                    let delivered = real.drive(&mut device, command, duration);
                    let aim = 0.9 * command;
                    let excess: f64 = force - aim;
                    let decay = (-duration / lag).exp();
                    let gone = -(-duration / lag).exp_m1();
                    let before: f64 = velocity;
                    position += before * duration
                        + (0.5 * (push - aim) * duration * duration
                            - excess * lag * (duration - lag * gone))
                            / mass;
                    velocity += ((push - aim) * duration - excess * lag * gone) / mass;
                    let travel_scale = 12.0 * duration * duration / mass + position.abs();
                    assert!(
                        (device.position() - position).abs() < 1e-9 * travel_scale,
                        "lag {lag}, duration {duration}: {} for {position}",
                        device.position()
                    );
                    let speed_scale = 12.0 * duration / mass + velocity.abs();
                    assert!((device.velocity() - velocity).abs() < 1e-12 * speed_scale);
                    force = aim + excess * decay;
                    assert!((real.force() - force).abs() < 1e-12);
                    let mean = aim + excess * lag * gone / duration;
                    assert!((delivered.mean_force - mean).abs() < 1e-11);
                }
            }
        }
    }

    /// With f = f0 + s (t - T/2): v = v0 + (f_u - f0) t/m - s (t^2 - t T)/(2 m), and its integral.
    #[test]
    fn a_point_mass_follows_a_line_exactly_and_a_mass_in_a_hand_nearly() {
        let (mass, push, duration) = (0.08, 0.4, 0.02);
        let mut device = PointMass::new(mass, push).unwrap();
        let mut real = actuator(0.9, 0.0);
        for (command, slope) in [(5.0, 300.0), (-3.0, -90.0), (0.0, 50.0)] {
            let (position, velocity, store) =
                (device.position(), device.velocity(), device.stored_energy());
            let given = real.drive_line(&mut device, command, slope, duration);
            let acceleration = (push - 0.9 * command) / mass;
            let travel = (velocity + 0.5 * acceleration * duration) * duration
                + 0.9 * slope * duration.powi(3) / (12.0 * mass);
            assert!((device.position() - position - travel).abs() < 1e-15);
            assert!((device.velocity() - velocity - acceleration * duration).abs() < 1e-13);
            assert!((store - device.stored_energy() - given.work).abs() < 1e-13);
            assert_eq!(given.mean_force, 0.9 * command);
            assert!((real.force() - 0.9 * (command + 0.5 * slope * duration)).abs() < 1e-12);
        }
        let hand = Hand::Impedance {
            mass: 0.05,
            stiffness: 300.0,
            damping: 5.0,
            intention: Intention::constant(0.001),
            force: 1.0,
            tremor: None,
        };
        let held = HeldMass::new(0.08, hand).unwrap();
        let (mut whole, mut steps, mut real) = (held.clone(), held, actuator(1.0, 0.0));
        real.drive_line(&mut whole, 3.0, 400.0, duration);
        let count = 20_000;
        let step = duration / f64::from(count);
        for i in 0..count {
            let at = (f64::from(i) + 0.5) * step - 0.5 * duration;
            steps.advance(3.0 + 400.0 * at, step);
        }
        assert!((whole.position() - steps.position()).abs() < 1e-10);
        assert!((whole.velocity() - steps.velocity()).abs() < 1e-8);
    }

    #[test]
    fn the_work_through_the_port_is_what_the_store_gives() {
        let mut device = PointMass::new(0.25, 1.0)
            .and_then(|device| device.starting_at(-0.01, 0.4))
            .unwrap();
        let mut real = actuator(1.05, 3e-4);
        for command in [0.0, 5.0, -1.5, 80.0] {
            let before = device.stored_energy();
            let work = real.drive(&mut device, command, 0.013).work;
            assert!((before - device.stored_energy() - work).abs() < 1e-12);
        }
    }

    #[test]
    fn shorter_pieces_hardly_change_the_motion_in_a_hand() {
        let hand = Hand::Impedance {
            mass: 0.05,
            stiffness: 300.0,
            damping: 5.0,
            intention: Intention::constant(0.001),
            force: 1.0,
            tremor: Some(Sinusoid {
                amplitude: 0.2,
                frequency_hz: 9.0,
                phase: 0.0,
            }),
        };
        // If a force settles across the level of dry friction, the halves shift the instant at which the mass comes to
        // rest or breaks away.
        for (dry, tolerance) in [(0.0, 2e-10), (0.05, 1e-5)] {
            let device = HeldMass::new(0.08, hand.clone())
                .and_then(|device| device.with_friction(0.5, dry))
                .unwrap();
            for lag in [5e-5, 3e-4, 2e-3] {
                let run = |longest: f64| {
                    let (mut device, mut force) = (device.clone(), 0.0);
                    for i in 0..60_i32 {
                        let command = if i % 7 < 3 { 9.0 } else { -2.0 };
                        let excess = force - command;
                        in_pieces(&mut device, (command, excess), lag, 1e-3, longest);
                        force = command + excess * (-1e-3 / lag).exp();
                    }
                    (device.position(), device.velocity())
                };
                let (usual, fine) = (run(LONGEST_PIECE), run(0.1 * LONGEST_PIECE));
                println!("dry {dry} N, lag {lag} s: {usual:?} {fine:?}");
                // The mass has moved by centimetres, at up to 1 m/s.
                assert!((usual.0 - fine.0).abs() < 0.01 * tolerance);
                assert!((usual.1 - fine.1).abs() < tolerance);
            }
        }
    }

    #[test]
    fn a_rejected_parameter_is_named() {
        for (gain, lag, name) in [
            (0.0, 0.0, "gain"),
            (f64::NAN, 0.0, "gain"),
            (1.0, -1e-6, "lag"),
            (1.0, f64::INFINITY, "lag"),
        ] {
            let error = Actuator::new(ActuatorParams { gain, lag }).unwrap_err();
            assert_eq!(error.name, name);
        }
    }
}
