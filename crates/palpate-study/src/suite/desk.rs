//! Random desktop devices with real actuators.

use palpate_core::{Contact, LoopParams, ObjectState};
use palpate_scene::method::MethodName;
use palpate_scene::{
    ActuatorParams, Cogging, Delay, Hand, Measure, Model, PointMassDevice, Scene, SceneDevice,
    Timing, Transmission,
};

use crate::calibrate::{ExcitationParams, Quantity};

use super::COLLISIONS;
use super::chance::Chance;
use super::draw::{DrawError, GRAVITY, RandomPlant, grip, tremor};
use super::set::truth;
use crate::calibrated;

/// Period of a desktop loop `[s]`.
const PERIOD: f64 = 1e-3;
/// Largest error of a calibrated delay `[periods]`.
const DELAY_ERROR: f64 = 0.02;
/// Largest error of a calibrated gain at a known mass, relative.
const GAIN_ERROR: f64 = 0.015;

/// Draws object, hand and user of a desktop device with ideal loop, actuator and sensor.
pub(super) fn base(chance: &mut Chance) -> RandomPlant {
    let mass = chance.log_between(0.08, 0.4);
    let stiffness = chance.log_between(500.0, 10_000.0);
    let object_mass = chance.log_between(0.03, 0.5);
    let push = chance.between(2.0, 10.0);
    let impact_speed = chance.between(0.2, 1.0);
    let viscous_friction = mass * chance.between(0.0, 1.0);
    let user_force = mass * push;
    let is_held = chance.happens(0.7);
    let grip = grip(chance, mass);
    let tremor = tremor(chance, user_force);
    let per_stiffness = PERIOD * PERIOD;
    RandomPlant {
        seed: 0,
        index: 0,
        redrawn: 0,
        kappa: stiffness * per_stiffness / mass,
        object_kappa: stiffness * per_stiffness / object_mass,
        impact_speed,
        scene: Scene {
            title: String::new(),
            contact: Contact::object(stiffness, object_mass),
            loop_params: LoopParams {
                // No speed limit: a diverging loop shall be visible, as in scene files.
                speed_limit: None,
                ..LoopParams::new(PERIOD)
            },
            object: ObjectState::at_rest(impact_speed * impact_speed / (2.0 * (push + GRAVITY))),
            virtual_force: -GRAVITY * object_mass,
            device: SceneDevice::PointMass(PointMassDevice {
                mass,
                encoder_quantum: 1e-6,
                viscous_friction,
                hand: Hand {
                    force: user_force,
                    tremor,
                    grip: is_held.then_some(grip),
                    release: None,
                },
                ..PointMassDevice::default()
            }),
            model_device_mass: None,
            object_radius: 0.0,
            delay: Delay::NONE,
            timing: Timing {
                seed: chance.number(),
                ..Timing::default()
            },
            actuator: ActuatorParams::default(),
            model: Model::default(),
            measure: Measure::Collisions(COLLISIONS),
            method: MethodName::Coupled,
            settings: std::collections::HashMap::new(),
        },
    }
}

/// Draws a desktop device with all imperfections; the renderer's model has the errors of a calibration.
pub(super) fn desk(chance: &mut Chance) -> RandomPlant {
    let mut plant = base(chance);
    let scene = &mut plant.scene;
    let user_force = scene.device.hand_force();
    scene.delay = Delay::Seconds(PERIOD * chance.between(0.0, 1.5));
    let lag = chance.between(0.0, 5e-4);
    scene.timing.command_jitter = PERIOD * chance.between(0.0, 0.1);
    scene.actuator = ActuatorParams {
        lag,
        gain: chance.between(0.95, 1.05),
    };
    let rubs = chance.happens(0.5);
    let coulomb_friction = user_force * chance.between(0.0, 0.3);
    let cogs = chance.happens(0.5);
    let cogging = Cogging {
        amplitude: user_force * chance.between(0.0, 0.2),
        pitch: chance.log_between(0.002, 0.01),
    };
    let is_flexible = chance.happens(0.5);
    let transmission = transmission(chance, 50.0, 300.0);
    let plays = chance.happens(0.5);
    let backlash = chance.between(0.0, 1e-4);
    let encoder_quantum = chance.log_between(1e-6, 1e-4);
    let is_noisy = chance.happens(0.5);
    let noise = chance.between(0.0, 5e-6);
    if let Some(device) = scene.device.point_mass_mut() {
        device.encoder_quantum = encoder_quantum;
        if rubs {
            device.coulomb_friction = coulomb_friction;
        }
        device.cogging = cogs.then_some(cogging);
        device.transmission = is_flexible.then_some(Transmission {
            backlash: if plays { backlash } else { 0.0 },
            ..transmission
        });
        if is_noisy {
            device.noise = noise;
        }
    }
    calibrate(scene, chance);
    plant
}

/// Draws a variant of the plausible device: a transmission of about 150 Hz, a lag of about .3 ms, a delay of about
/// half a period, friction, cogging and an encoder of 10 um. The renderer's model has the errors of a calibration.
pub(super) fn real(chance: &mut Chance) -> RandomPlant {
    let mut plant = base(chance);
    let scene = &mut plant.scene;
    let user_force = scene.device.hand_force();
    scene.delay = Delay::Seconds(PERIOD * chance.between(0.3, 0.7));
    scene.actuator.lag = chance.between(2e-4, 4e-4);
    if let Some(device) = scene.device.point_mass_mut() {
        device.coulomb_friction = user_force * chance.between(0.05, 0.15);
        device.cogging = Some(Cogging {
            amplitude: user_force * chance.between(0.05, 0.15),
            pitch: chance.log_between(0.003, 0.008),
        });
        device.transmission = Some(transmission(chance, 120.0, 190.0));
        device.encoder_quantum = 1e-5;
    }
    calibrate(scene, chance);
    plant
}

/// Draws a transmission with a resonance between two frequencies `[Hz]`.
fn transmission(chance: &mut Chance, from: f64, to: f64) -> Transmission {
    Transmission {
        resonance_hz: chance.log_between(from, to),
        damping_ratio: chance.log_between(0.01, 0.1),
        motor_share: chance.between(0.3, 0.7),
        backlash: 0.0,
    }
}

/// Sets the renderer's model to the true values with the errors of a calibration, and to their uncertainties.
fn calibrate(scene: &mut Scene, chance: &mut Chance) {
    let truth = truth(scene);
    let delay_error = PERIOD * chance.between(-DELAY_ERROR, DELAY_ERROR);
    let gain_error = chance.between(-GAIN_ERROR, GAIN_ERROR);
    // Standard deviations of a uniform distribution and of the jitter.
    let third = 1.0 / 3.0_f64.sqrt();
    let of_calibration = third * DELAY_ERROR * PERIOD;
    let of_jitter = truth.delay_deviation.unwrap_or(0.0);
    let deviation = (of_calibration * of_calibration + of_jitter * of_jitter).sqrt();
    scene.model = Model {
        delay: truth.delay.map(|delay| (delay + delay_error).max(0.0)),
        delay_deviation: Some(deviation),
        gain: Some(scene.actuator.gain * (1.0 + gain_error)),
        gain_deviation: Some(third * GAIN_ERROR),
        sensor_noise: truth.sensor_noise,
        ..Model::default()
    };
}

/// Excitation forces of a calibration `[N]`, tried in this order until the calibration succeeds. A real calibration
/// also advises a larger force if friction is close to the force.
const FORCES: [f64; 4] = [0.5, 1.0, 2.0, 4.0];

/// Largest tremor of the hand that a calibration accepts `[m]`: hands of the suite tremble by 20 % of their pushing
/// force, also when they do not push.
const TREMOR: f64 = 3e-3;

/// Sets the renderer's model to the results of a simulated calibration of the device. Adds the excitation force to
/// the plant's title, and a note if the contact is stiffer than the resonance allows.
pub(super) fn calibrate_itself(plant: &mut RandomPlant) -> Result<(), DrawError> {
    let mut declined = String::new();
    for largest_force in FORCES {
        let params = ExcitationParams {
            largest_force,
            tremor: TREMOR,
            ..ExcitationParams::new(plant.scene.loop_params.period)
        };
        match calibrated::calibrate(&plant.scene, &params) {
            Ok(calibration) => {
                let scene = &mut plant.scene;
                scene.model = calibrated::model(&calibration, |_| true);
                scene.model_device_mass = calibration.value(Quantity::DeviceMass);
                scene.title += &format!(", calibrated with {largest_force} N");
                if let palpate_core::Mass::Finite(object) = scene.contact.object_mass
                    && let Some(stiffest) = calibration.stiffest_contact(object, PERIOD)
                    && stiffest < scene.contact.stiffness
                {
                    scene.title += ", stiffer than its resonance allows";
                }
                return Ok(());
            }
            Err(error) => declined = error.to_string(),
        }
    }
    Err(DrawError::Calibration(plant.index, declined))
}
