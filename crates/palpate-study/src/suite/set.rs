//! Sets of plants, and the conditions of their evaluation.

use std::fmt;

use palpate_core::Transmission;
use palpate_scene::method::MethodName;
use palpate_scene::{Delay, Model, Scene};

use super::DELAYS;
use super::column::{Column, Dampings};
use super::desk;
use super::draw::{self, DrawError, RandomPlant};
use super::steps::Step;
use crate::text::counted;

/// A family of plants with the conditions of its evaluation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Set {
    /// Wide ranges of all parameters, ideal actuators: without delay, and with a modelled and an unmodelled delay of
    /// one sample.
    #[default]
    Paper,
    /// Desktop devices at 1 kHz with real actuators: no actuator model, the true model, and a calibrated model.
    Desk,
    /// Variants of one plausible flexible device with a transmission and a lag, with the same models.
    Real,
    /// The same plausible devices: the true model, and the results of each device's own calibration.
    Calibrated,
    /// Desktop devices with one imperfection at a time.
    Steps,
}

/// Condition of the evaluation of a plant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Condition {
    /// A delay `[samples]` of an otherwise ideal loop, included in every renderer's model.
    Delay(usize),
    /// The same delay, with a model delay of 0 in every renderer.
    UnmodelledDelay(usize),
    /// The renderer's model of the actuator.
    Model(Telling),
    /// One imperfection.
    Step(Step),
}

/// A renderer's model of the actuator and of the device's mass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Telling {
    /// The mass; no delay, no lag, a gain of 1.
    Nothing,
    /// The mass, the mean delay with the standard deviation of its jitter, lag and gain.
    Truth,
    /// The true values with the drawn errors of a calibration.
    Calibrated,
    /// The results of a calibration of the device.
    Measured,
}

impl Set {
    /// Every set.
    pub const ALL: [Self; 5] = [
        Self::Paper,
        Self::Desk,
        Self::Real,
        Self::Calibrated,
        Self::Steps,
    ];

    /// Returns the name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Desk => "desk",
            Self::Real => "real",
            Self::Calibrated => "calibrated",
            Self::Steps => "steps",
        }
    }

    /// Returns the conditions of the evaluation of each plant, in order.
    #[must_use]
    pub fn conditions(self) -> Vec<Condition> {
        match self {
            Self::Paper => {
                let [none, one] = DELAYS;
                let modelled = [none, one].map(Condition::Delay);
                let unmodelled = [Condition::UnmodelledDelay(one)];
                [&modelled[..], &unmodelled].concat()
            }
            Self::Desk | Self::Real => {
                let tellings = [Telling::Nothing, Telling::Truth, Telling::Calibrated];
                tellings.map(Condition::Model).to_vec()
            }
            Self::Calibrated => [Telling::Truth, Telling::Measured]
                .map(Condition::Model)
                .to_vec(),
            Self::Steps => Step::ALL.map(Condition::Step).to_vec(),
        }
    }

    /// Draws plant number `index` of `seed`; it is always the same.
    ///
    /// # Errors
    /// No force calibrates a device of the calibrated set.
    pub fn draw(self, seed: u64, index: usize) -> Result<RandomPlant, DrawError> {
        match self {
            Self::Paper => RandomPlant::draw(seed, index),
            Self::Desk => draw::colliding(seed, index, "Desk plant", desk::desk, &[]),
            Self::Real => draw::colliding(seed, index, "Plausible device", desk::real, &[]),
            Self::Calibrated => {
                let mut plant = Self::Real.draw(seed, index)?;
                desk::calibrate_itself(&mut plant)?;
                Ok(plant)
            }
            Self::Steps => draw::colliding(
                seed,
                index,
                "Perfect desk plant",
                desk::base,
                &Step::OF_DEVICES,
            ),
        }
    }

    /// Returns the default columns. The damper of the sets with real actuators uses the best of 24 values on each
    /// plant and condition, selected with knowledge of the ideal.
    #[must_use]
    pub fn columns(self) -> Vec<Column> {
        if self == Self::Paper {
            return MethodName::ALL.map(Column::new).to_vec();
        }
        vec![
            Column::new(MethodName::Coupled),
            Column::new(MethodName::Hfcr),
            Column {
                name: "virtual-damper, best B of each".into(),
                dampings: Some(Dampings::OverImpedance(DAMPINGS.to_vec())),
                ..Column::new(MethodName::VirtualDamper)
            },
        ]
    }
}

/// Dampings over K T from which the best damper is selected.
const DAMPINGS: [f64; 24] = [
    0.0, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.2, 1.4, 1.7, 2.0, 2.4,
    2.8, 3.4, 4.0, 5.0, 6.5, 8.0,
];

impl fmt::Display for Set {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl Condition {
    /// Returns the delay, if the condition is a delay `[samples]`.
    #[must_use]
    pub fn delay(self) -> Option<usize> {
        match self {
            Self::Delay(delay) | Self::UnmodelledDelay(delay) => Some(delay),
            Self::Model(_) | Self::Step(_) => None,
        }
    }

    /// Returns the delay in the renderer's model, if the condition is a delay `[samples]`.
    #[must_use]
    pub fn model_delay(self) -> Option<usize> {
        match self {
            Self::Delay(delay) => Some(delay),
            Self::UnmodelledDelay(_) => Some(0),
            Self::Model(_) | Self::Step(_) => None,
        }
    }

    /// Returns the scene of `plant` under this condition.
    #[must_use]
    pub fn of(self, plant: &RandomPlant) -> Scene {
        let mut scene = plant.scene.clone();
        match self {
            Self::Delay(delay) => scene.delay = Delay::samples(delay),
            Self::UnmodelledDelay(delay) => {
                scene.delay = Delay::samples(delay);
                scene.model.delay = Some(0.0);
            }
            Self::Model(telling) => telling.tell(&mut scene),
            Self::Step(step) => step.change(&mut scene),
        }
        scene
    }
}

impl Telling {
    fn tell(self, scene: &mut Scene) {
        match self {
            Self::Nothing => {
                scene.model_device_mass = None;
                scene.model = Model {
                    delay: Some(0.0),
                    lag: Some(0.0),
                    gain: Some(1.0),
                    ..Model::default()
                };
            }
            Self::Truth => {
                scene.model_device_mass = None;
                scene.model = truth(scene);
                if scene.model.transmission.is_some() {
                    let of_hand = scene.device.grip().map_or(0.0, |grip| grip.mass);
                    scene.model_device_mass = Some(scene.device.mass() + of_hand);
                }
            }
            // The scene already contains the model.
            Self::Calibrated | Self::Measured => {}
        }
    }
}

/// Returns the true values of a scene as model values: the mean command delay, the standard deviation of its jitter,
/// the sensor noise and the transmission. Lag and gain are unset, which means their true values.
pub(super) fn truth(scene: &Scene) -> Model {
    let jitter = scene.timing.command_jitter;
    Model {
        delay: Some(scene.delay.seconds() + 0.5 * jitter),
        delay_deviation: (jitter > 0.0).then(|| jitter / 12.0_f64.sqrt()),
        sensor_noise: true_noise(scene),
        transmission: true_transmission(scene),
        ..Model::default()
    }
}

/// Returns the standard deviation of a sensor's error `[m]`, from noise and quantum; `None` without noise.
pub(super) fn true_noise(scene: &Scene) -> Option<f64> {
    let noise = scene.device.noise();
    let of_quantum = scene.device.encoder_quantum() / 12.0_f64.sqrt();
    (noise > 0.0).then(|| noise.hypot(of_quantum))
}

/// Returns the transmission of a scene's device, with the mass of the hand on its output side.
fn true_transmission(scene: &Scene) -> Option<Transmission<f64>> {
    let transmission = scene.device.point_mass()?.transmission?;
    let mass = scene.device.mass();
    let (stiffness, damping) = transmission.stiffness_and_damping(mass);
    let of_motor = transmission.motor_share * mass;
    let of_hand = scene.device.grip().map_or(0.0, |grip| grip.mass);
    let all = mass + of_hand;
    let beyond = all - of_motor;
    let reduced = of_motor * beyond / all;
    let rate = (stiffness / reduced).sqrt();
    Some(Transmission {
        resonance: rate / std::f64::consts::TAU,
        damping_ratio: (damping / (2.0 * reduced * rate)).min(1.0),
        flexible_mass_fraction: beyond / all,
    })
}

/// Formats a condition, for example `no delay`, `1 sample of delay, modelled`, `true model`.
impl fmt::Display for Condition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Delay(0) => f.write_str("no delay"),
            Self::Delay(delay) => write!(f, "{} of delay, modelled", counted(*delay, "sample")),
            Self::UnmodelledDelay(delay) => {
                write!(f, "{} of delay, unmodelled", counted(*delay, "sample"))
            }
            Self::Model(Telling::Nothing) => f.write_str("actuator unmodelled"),
            Self::Model(Telling::Truth) => f.write_str("true model"),
            Self::Model(Telling::Calibrated) => f.write_str("calibrated model"),
            Self::Model(Telling::Measured) => f.write_str("model from its own calibration"),
            Self::Step(step) => f.write_str(step.in_words()),
        }
    }
}
