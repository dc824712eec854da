//! `[device.drivetrain]` of a scene file: friction, motor, transmission and cogging.

use std::ops::Range;

use palpate_testbed::drivetrain::{Cogging, Transmission};
use serde::Deserialize;
use toml::Spanned;

use super::PointMassDevice;
use super::fault::Places;
use super::parameter::SceneParameter as Of;

/// Damping ratio of a resonance where none is stated: a metal shaft, a steel cable.
const DAMPING_RATIO: f64 = 0.02;
/// Share of the mass on the motor's side where none is stated.
const MOTOR_SHARE: f64 = 0.5;

/// Keys of a drivetrain.
#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawDrivetrain {
    pub viscous_friction_n_s_per_m: Option<Spanned<f64>>,
    pub coulomb_friction_n: Option<Spanned<f64>>,
    pub motor_limit_n: Option<Spanned<f64>>,
    pub resonance_hz: Option<Spanned<f64>>,
    pub resonance_damping_ratio: Option<Spanned<f64>>,
    pub motor_mass_fraction: Option<Spanned<f64>>,
    pub backlash_m: Option<Spanned<f64>>,
    pub cogging_n: Option<Spanned<f64>>,
    pub cogging_pitch_m: Option<Spanned<f64>>,
}

impl RawDrivetrain {
    /// Returns the name of each key, and its span if it is given.
    pub fn spans(&self) -> [(&'static str, Option<Range<usize>>); 9] {
        [
            (
                "device.drivetrain.viscous_friction_n_s_per_m",
                &self.viscous_friction_n_s_per_m,
            ),
            (
                "device.drivetrain.coulomb_friction_n",
                &self.coulomb_friction_n,
            ),
            ("device.drivetrain.motor_limit_n", &self.motor_limit_n),
            ("device.drivetrain.resonance_hz", &self.resonance_hz),
            (
                "device.drivetrain.resonance_damping_ratio",
                &self.resonance_damping_ratio,
            ),
            (
                "device.drivetrain.motor_mass_fraction",
                &self.motor_mass_fraction,
            ),
            ("device.drivetrain.backlash_m", &self.backlash_m),
            ("device.drivetrain.cogging_n", &self.cogging_n),
            ("device.drivetrain.cogging_pitch_m", &self.cogging_pitch_m),
        ]
        .map(|(key, value)| (key, value.as_ref().map(Spanned::span)))
    }

    /// Returns the span of a key whose required key is missing, and the error.
    pub fn alone(&self) -> Option<(Range<usize>, &'static str)> {
        let of_a_transmission = [
            &self.resonance_damping_ratio,
            &self.motor_mass_fraction,
            &self.backlash_m,
        ];
        if self.resonance_hz.is_none()
            && let Some(key) = of_a_transmission.into_iter().flatten().next()
        {
            return Some((
                key.span(),
                "keys of a flexible transmission need resonance_hz",
            ));
        }
        match (&self.cogging_n, &self.cogging_pitch_m) {
            (Some(key), None) | (None, Some(key)) => Some((
                key.span(),
                "cogging needs both cogging_n and cogging_pitch_m",
            )),
            _ => None,
        }
    }

    /// Returns `device` with the drivetrain of these keys.
    pub fn on(self, device: PointMassDevice, places: &mut Places<Of>) -> PointMassDevice {
        let transmission = self.resonance_hz.map(|resonance| Transmission {
            resonance_hz: places.take(Of::Resonance, resonance),
            damping_ratio: places.take_or(
                Of::ResonanceDamping,
                self.resonance_damping_ratio,
                DAMPING_RATIO,
            ),
            motor_share: places.take_or(
                Of::MotorMassFraction,
                self.motor_mass_fraction,
                MOTOR_SHARE,
            ),
            backlash: places.take_or(Of::Backlash, self.backlash_m, 0.0),
        });
        let cogging = self.cogging_n.zip(self.cogging_pitch_m);
        PointMassDevice {
            viscous_friction: places.take_or(
                Of::ViscousFriction,
                self.viscous_friction_n_s_per_m,
                0.0,
            ),
            coulomb_friction: places.take_or(Of::CoulombFriction, self.coulomb_friction_n, 0.0),
            largest_force: self
                .motor_limit_n
                .map(|force| places.take(Of::MotorLimit, force)),
            transmission,
            cogging: cogging.map(|(amplitude, pitch)| Cogging {
                amplitude: places.take(Of::Cogging, amplitude),
                pitch: places.take(Of::CoggingPitch, pitch),
            }),
            ..device
        }
    }
}
