//! Hands of a world and the drivetrains of its devices.

use std::sync::Arc;

use super::prescribed_motion::LedPath;
use super::scene::{InvalidScene, Vector, WorldDevice, above_zero, all_finite, not_negative};
use super::vector::Vec3;
use crate::InvalidParameter;
use crate::hand::{Hand, IntendedPath, Intention, Sinusoid};
use crate::held_mass::HeldMass;

/// Friction, motors and noise of the sensors of a device, the same along each of its axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drivetrain {
    /// Viscous friction B, at least 0 `[N s/m]`.
    pub viscous_friction: f64,
    /// Coulomb friction F_c, at least 0: at rest any force up to it `[N]`.
    pub coulomb_friction: f64,
    /// Largest force of each motor, above 0; infinite without a limit, as in the ideal `[N]`.
    pub largest_force: f64,
    /// Standard deviation of the noise of each position sensor, at least 0 `[m]`.
    pub noise: f64,
}

impl Default for Drivetrain {
    fn default() -> Self {
        Self {
            viscous_friction: 0.0,
            coulomb_friction: 0.0,
            largest_force: f64::INFINITY,
            noise: 0.0,
        }
    }
}

/// A sine motion about a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Swing {
    /// Amplitude along the world's axes `[m]`.
    pub amplitude: Vector,
    /// Frequency, above 0 `[Hz]`.
    pub frequency_hz: f64,
}

/// A hand in three axes: a force, a mass, and a spring and a damper towards a place.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct WorldHand {
    /// Constant force F `[N]`.
    pub force: Vector,
    /// Stiffness k, at least 0 `[N/m]`.
    pub stiffness: f64,
    /// Damping b, at least 0 `[N s/m]`.
    pub damping: f64,
    /// Rest position of the spring `[m]`.
    pub rest: Vector,
    /// Swing of the rest position, at its middle at t = 0.
    pub swing: Option<Swing>,
    /// Recorded rest position in place of `rest`: the path of one device.
    pub path: Option<Arc<LedPath>>,
    /// Mass m_h that moves with the device, at least 0 `[kg]`. The weights of an evaluation are without it.
    pub mass: f64,
    /// Time at which the hand releases the device permanently `[s]`.
    pub release: Option<f64>,
    /// Tremor forces along each of the device's axes, their amplitudes in `[N]`; they add up.
    pub tremor: [Vec<Sinusoid>; 3],
}

impl WorldDevice {
    /// Checks the intention of the hand, and the drivetrain.
    pub(super) fn check_intention(&self, name: &str) -> Result<(), InvalidScene> {
        let (hand, drivetrain) = (&self.hand, &self.drivetrain);
        if let Some(swing) = &hand.swing {
            let name = format!("{name}.hand.swing");
            all_finite(&name, &swing.amplitude)?;
            above_zero(&name, &[swing.frequency_hz])?;
        }
        if let Some(path) = &hand.path {
            let name = format!("{name}.hand.path");
            let devices = path.devices();
            InvalidParameter::unless(devices == 1, name, devices as f64, "of one device")?;
        }
        let release = hand.release.unwrap_or(0.0);
        not_negative(&format!("{name}.hand.release"), &[release])?;
        not_negative(&format!("{name}.hand.mass"), &[hand.mass])?;
        let frictions = [drivetrain.viscous_friction, drivetrain.coulomb_friction];
        not_negative(&format!("{name}.drivetrain.friction"), &frictions)?;
        not_negative(&format!("{name}.drivetrain.noise"), &[drivetrain.noise])?;
        let largest = drivetrain.largest_force;
        let allowed = "above 0 N";
        let motor = format!("{name}.drivetrain.largest_force");
        InvalidParameter::unless(largest > 0.0, motor, largest, allowed)?;
        let of_table = self.mass_table.is_some();
        for (key, value) in [
            ("hand.mass", hand.mass),
            ("drivetrain.coulomb_friction", drivetrain.coulomb_friction),
        ] {
            let allowed = "0 for a device with a mass table";
            let is_allowed = !of_table || value == 0.0;
            InvalidParameter::unless(is_allowed, format!("{name}.{key}"), value, allowed)?;
        }
        Ok(())
    }

    /// Returns the device along one of its axes as one that is held exactly between events, at t = 0.
    ///
    /// # Errors
    ///
    /// A number is outside its range, or the axis has more than one tremor.
    pub fn held_along(&self, axis: usize) -> Result<HeldMass, InvalidParameter> {
        let own = |vector: Vector| self.own(Vec3(vector)).0[axis];
        let hand = &self.hand;
        let tremors = &hand.tremor[axis];
        let count = tremors.len();
        InvalidParameter::unless(count <= 1, "hand.tremor", count as f64, "one along an axis")?;
        let (force, tremor) = (own(hand.force), tremors.first().copied());
        let held = if hand.stiffness > 0.0 || hand.damping > 0.0 || hand.mass > 0.0 {
            let swing = hand.swing.map(|swing| Sinusoid {
                amplitude: own(swing.amplitude),
                frequency_hz: swing.frequency_hz,
                phase: 0.0,
            });
            let path = match (&hand.path, swing) {
                (Some(path), _) => IntendedPath::Recorded(Arc::new(path.along(own)?)),
                (None, Some(swing)) => IntendedPath::Sinusoid {
                    centre: own(hand.rest),
                    swing,
                },
                (None, None) => IntendedPath::Constant(own(hand.rest)),
            };
            Hand::Impedance {
                mass: hand.mass,
                stiffness: hand.stiffness,
                damping: hand.damping,
                intention: Intention { path, tremor: None },
                force,
                tremor,
            }
        } else {
            Hand::ConstantForce { force, tremor }
        };
        let Drivetrain {
            viscous_friction,
            coulomb_friction,
            ..
        } = self.drivetrain;
        let held = HeldMass::new(self.mass[axis], held)?
            .with_friction(viscous_friction, coulomb_friction)?
            .starting_at(own(self.position), own(self.velocity))?;
        match hand.release {
            Some(release) => held.released_at(release),
            None => Ok(held),
        }
    }
}

impl WorldHand {
    /// Whether the hand has no intention, no mass and no release.
    pub(super) fn is_still(&self) -> bool {
        self.swing.is_none() && self.path.is_none() && self.mass == 0.0 && self.release.is_none()
    }
}
