//! The transmission, the cogging and the sensor's noise of a scene's device.

use std::ops::Range;

use palpate_testbed::drivetrain::{Cogging, Transmission};
use toml::Spanned;

use super::PointMassDevice;
use super::fault::Places;
use super::parameter::SceneParameter as Of;

/// Damping ratio of a resonance where none is stated: a metal shaft, a steel cable.
const DAMPING_RATIO: f64 = 0.02;
/// Share of the mass on the motor's side where none is stated.
const MOTOR_SHARE: f64 = 0.5;

/// Keys of a drivetrain, as read from the file.
#[derive(Default)]
pub(super) struct RawDrivetrain {
    pub resonance_hz: Option<Spanned<f64>>,
    pub resonance_damping_ratio: Option<Spanned<f64>>,
    pub motor_mass_share: Option<Spanned<f64>>,
    pub backlash_m: Option<Spanned<f64>>,
    pub cogging_n: Option<Spanned<f64>>,
    pub cogging_pitch_m: Option<Spanned<f64>>,
    pub noise_m: Option<Spanned<f64>>,
}

impl RawDrivetrain {
    /// The place of the first key, if there is one.
    pub fn any(&self) -> Option<Range<usize>> {
        let keys = [
            &self.resonance_hz,
            &self.resonance_damping_ratio,
            &self.motor_mass_share,
            &self.backlash_m,
            &self.cogging_n,
            &self.cogging_pitch_m,
            &self.noise_m,
        ];
        keys.into_iter().flatten().map(Spanned::span).next()
    }

    /// Returns the span of a key whose required key is missing, and the error.
    pub fn alone(&self) -> Option<(Range<usize>, &'static str)> {
        let of_a_transmission = [
            &self.resonance_damping_ratio,
            &self.motor_mass_share,
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
            motor_share: places.take_or(Of::MotorMassShare, self.motor_mass_share, MOTOR_SHARE),
            backlash: places.take_or(Of::Backlash, self.backlash_m, 0.0),
        });
        let cogging = self.cogging_n.zip(self.cogging_pitch_m);
        PointMassDevice {
            transmission,
            cogging: cogging.map(|(amplitude, pitch)| Cogging {
                amplitude: places.take(Of::Cogging, amplitude),
                pitch: places.take(Of::CoggingPitch, pitch),
            }),
            noise: places.take_or(Of::SensorNoise, self.noise_m, 0.0),
            ..device
        }
    }
}
