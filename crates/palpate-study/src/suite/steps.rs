//! One imperfection at a time of a loop, its actuator or its device.

use palpate_scene::{ActuatorParams, Delay, Model, Scene, Transmission};

use super::set::{true_noise, truth};

/// An imperfection, and the renderer's model of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // each is described in words
pub enum Step {
    Nothing,
    ShortDelay,
    DelayUnmodelled,
    DelayModelled,
    Lag,
    LagAndDelay,
    LagAndDelayMismatched,
    Jitter,
    Gain,
    Quantum,
    Flexible,
    Friction,
    Noise,
    /// The same noise, modelled.
    NoiseModelled,
}

/// Error of a wrong model delay `[periods]`.
const MISMATCH: f64 = 0.02;
/// Lag of the steps with a lag `[s]`.
const LAG: f64 = 3e-4;

impl Step {
    /// Every step, in order.
    pub const ALL: [Self; 14] = [
        Self::Nothing,
        Self::ShortDelay,
        Self::DelayUnmodelled,
        Self::DelayModelled,
        Self::Lag,
        Self::LagAndDelay,
        Self::LagAndDelayMismatched,
        Self::Jitter,
        Self::Gain,
        Self::Quantum,
        Self::Flexible,
        Self::Friction,
        Self::Noise,
        Self::NoiseModelled,
    ];

    /// Steps that change the device, and thereby the ideal.
    pub const OF_DEVICES: [Self; 2] = [Self::Flexible, Self::Friction];

    /// Describes the imperfection and its model.
    #[must_use]
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Nothing => "a perfect loop",
            Self::ShortDelay => "delay .03 T, unmodelled",
            Self::DelayUnmodelled => "delay .3 T, unmodelled",
            Self::DelayModelled => "delay .3 T, modelled",
            Self::Lag => "lag .3 ms, unmodelled",
            Self::LagAndDelay => "lag .3 ms + delay .5 T, both modelled",
            Self::LagAndDelayMismatched => "the same, delay mismatched by .02 T",
            Self::Jitter => "jitter 0-.1 T, mean modelled",
            Self::Gain => "gain .9, unmodelled",
            Self::Quantum => "lag .3 ms + delay .5 T modelled, quantum 10 um",
            Self::Flexible => "flexible 150 Hz",
            Self::Friction => "friction 30 % of the user's force",
            Self::Noise => "sensor noise 5 um, unmodelled",
            Self::NoiseModelled => "sensor noise 5 um, modelled",
        }
    }

    /// Applies the step to an ideal scene.
    pub fn change(self, scene: &mut Scene) {
        let period = scene.loop_params.period;
        match self {
            Self::Nothing => {}
            Self::ShortDelay => {
                delay_by(scene, 0.03);
                scene.model = unmodelled();
            }
            Self::DelayUnmodelled => {
                delay_by(scene, 0.3);
                scene.model = unmodelled();
            }
            Self::DelayModelled => delay_by(scene, 0.3),
            Self::Lag => {
                add_lag(scene);
                scene.model = unmodelled();
            }
            Self::LagAndDelay => {
                add_lag(scene);
                delay_by(scene, 0.5);
            }
            Self::LagAndDelayMismatched => {
                add_lag(scene);
                delay_by(scene, 0.5);
                // Too long on every second plant, too short on the others.
                let is_even = scene.timing.seed.is_multiple_of(2);
                let error = if is_even { MISMATCH } else { -MISMATCH };
                scene.model.delay = Some((0.5 + error) * period);
                scene.model.delay_deviation = Some(MISMATCH * period);
            }
            Self::Jitter => {
                scene.timing.command_jitter = 0.1 * period;
                scene.model = truth(scene);
            }
            Self::Gain => {
                scene.actuator.gain = 0.9;
                scene.model = unmodelled();
            }
            Self::Quantum => {
                add_lag(scene);
                delay_by(scene, 0.5);
                if let Some(device) = scene.device.point_mass_mut() {
                    device.encoder_quantum = 1e-5;
                }
            }
            Self::Flexible => {
                if let Some(device) = scene.device.point_mass_mut() {
                    device.transmission = Some(Transmission {
                        resonance_hz: 150.0,
                        damping_ratio: 0.03,
                        motor_share: 0.5,
                        backlash: 0.0,
                    });
                }
            }
            Self::Friction => {
                if let Some(device) = scene.device.point_mass_mut() {
                    device.coulomb_friction = 0.3 * device.hand.force;
                }
            }
            Self::Noise | Self::NoiseModelled => {
                if let Some(device) = scene.device.point_mass_mut() {
                    device.noise = 5e-6;
                }
                if self == Self::NoiseModelled {
                    scene.model.sensor_noise = true_noise(scene);
                }
            }
        }
    }
}

/// Sets the delay of the loop to `periods` `[periods]`.
fn delay_by(scene: &mut Scene, periods: f64) {
    scene.delay = Delay::Seconds(periods * scene.loop_params.period);
}

/// Sets an actuator with a lag.
fn add_lag(scene: &mut Scene) {
    scene.actuator = ActuatorParams {
        lag: LAG,
        ..ActuatorParams::default()
    };
}

/// Returns a model of a perfect loop.
fn unmodelled() -> Model {
    Model {
        delay: Some(0.0),
        lag: Some(0.0),
        gain: Some(1.0),
        ..Model::default()
    }
}
