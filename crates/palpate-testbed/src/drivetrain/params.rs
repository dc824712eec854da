//! Parameters of a drivetrain.

use std::f64::consts::TAU;

use crate::InvalidParameter;
use crate::error::positive;

/// A device whose motor and end-point are not one rigid body, or whose motor cogs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DrivetrainParams {
    /// Mass m of the device, of both sides together `[kg]`, above 0.
    pub mass: f64,
    /// Viscous friction B at the motor `[N s/m]`, at least 0.
    pub viscous_friction: f64,
    /// Coulomb friction F_c at the motor `[N]`, at least 0.
    pub coulomb_friction: f64,
    /// Transmission between motor and end-point; `None` where they are one rigid body.
    pub transmission: Option<Transmission>,
    /// Cogging of the motor, if it has any.
    pub cogging: Option<Cogging>,
}

/// A flexible transmission between a motor's side and an end-point's side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transmission {
    /// Resonance of the free device `[Hz]`, above 0: the two masses oscillate against each other.
    pub resonance_hz: f64,
    /// Damping of that resonance over the critical, from 0 to 1.
    pub damping_ratio: f64,
    /// Share of the mass that is on the motor's side, between 0 and 1.
    pub motor_share: f64,
    /// Way between the two sides on which the transmission gives no force `[m]`, at least 0.
    pub backlash: f64,
}

/// A force of the motor that depends on its position x₁ alone: A sin(2π x₁/pitch).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cogging {
    /// Amplitude A `[N]`, at least 0.
    pub amplitude: f64,
    /// `[m]`, above 0.
    pub pitch: f64,
}

impl DrivetrainParams {
    pub(super) fn check(&self) -> Result<(), InvalidParameter> {
        let not_negative = |name, value: f64, allowed| {
            InvalidParameter::unless(value.is_finite() && value >= 0.0, name, value, allowed)
        };
        positive("mass", self.mass, "finite and above 0 kg")?;
        for (name, value, allowed) in [
            (
                "viscous_friction",
                self.viscous_friction,
                "finite and at least 0 N s/m",
            ),
            (
                "coulomb_friction",
                self.coulomb_friction,
                "finite and at least 0 N",
            ),
        ] {
            not_negative(name, value, allowed)?;
        }
        if let Some(transmission) = self.transmission {
            transmission.check()?;
        }
        if let Some(cogging) = self.cogging {
            not_negative(
                "cogging.amplitude",
                cogging.amplitude,
                "finite and at least 0 N",
            )?;
            positive("cogging.pitch", cogging.pitch, "finite and above 0 m")?;
        }
        Ok(())
    }
}

impl Transmission {
    /// Highest resonance `[Hz]`: the loop and its device are integrated in steps that follow it.
    pub const HIGHEST_RESONANCE: f64 = 5000.0;

    fn check(&self) -> Result<(), InvalidParameter> {
        for (name, value, holds, allowed) in [
            (
                "resonance_hz",
                self.resonance_hz,
                self.resonance_hz > 0.0 && self.resonance_hz <= Self::HIGHEST_RESONANCE,
                "above 0 Hz, at most 5000 Hz",
            ),
            (
                "damping_ratio",
                self.damping_ratio,
                (0.0..=1.0).contains(&self.damping_ratio),
                "from 0 to 1",
            ),
            (
                "motor_share",
                self.motor_share,
                self.motor_share > 0.0 && self.motor_share < 1.0,
                "between 0 and 1",
            ),
            (
                "backlash",
                self.backlash,
                self.backlash.is_finite() && self.backlash >= 0.0,
                "finite and at least 0 m",
            ),
        ] {
            InvalidParameter::unless(holds, name, value, allowed)?;
        }
        Ok(())
    }

    /// Stiffness `[N/m]` and damping `[N s/m]` in a device of `mass` `[kg]`: with the reduced mass
    /// μ = m₁ m₂/m and ω = 2π f they are μ ω² and 2 ζ μ ω.
    #[must_use]
    pub fn stiffness_and_damping(&self, mass: f64) -> (f64, f64) {
        let reduced = mass * self.motor_share * (1.0 - self.motor_share);
        let rate = TAU * self.resonance_hz;
        (
            reduced * rate * rate,
            2.0 * self.damping_ratio * reduced * rate,
        )
    }
}
