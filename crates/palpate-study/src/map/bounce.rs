//! The scene of a cell: an object falls onto a device and bounces.

use std::collections::HashMap;

use palpate::{AnyRenderer, Contact, LoopParams, ObjectState, ParameterValue};
use palpate_testbed::InvalidParameter;

use palpate_scene::method::{MethodName, SettingKey, Settings};
use palpate_scene::{
    ActuatorParams, Delay, Hand, Measure, PointMassDevice, Scene, SceneDevice, SetupError, Timing,
    Told,
};
use palpate_sim::closed_loop::LoopError;

/// A device as it is, and what the renderer is told of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BounceDevice {
    /// Mass m `[kg]`.
    pub mass: f64,
    /// Viscous friction b `[N s/m]`.
    pub viscous_friction: f64,
    /// Coulomb friction `[N]`.
    pub coulomb_friction: f64,
    /// Quantum of the position sensor `[m]`; 0 for an ideal one.
    pub encoder_quantum: f64,
    /// Mass that the renderer is told, over the true one.
    pub told_mass: f64,
}

/// An object at rest before a device at rest, and the loop between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounce {
    /// The device.
    pub device: BounceDevice,
    /// Contact stiffness K `[N/m]`.
    pub stiffness: f64,
    /// Object mass M `[kg]`; infinite for a wall.
    pub object_mass: f64,
    /// What drives the two together.
    pub forces: Forces,
    /// Distance between device and object at the start `[m]`.
    pub gap: f64,
    /// Period T of the loop `[s]`.
    pub period: f64,
    /// Period that the renderer is told, over the true one.
    pub told_period: f64,
    /// Time from a sample to the beginning of its force `[periods]`, of any fraction.
    pub delay: f64,
    /// Time constant of the force after that, a first-order lag `[s]`.
    pub lag: f64,
    /// Model values of the renderer besides those: deviations of delay, lag and gain, and the noise of the sensor.
    pub told: Told,
}

/// Constant forces that drive device and object together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Forces {
    /// Equal and opposite forces on both, µ a with 1/µ = 1/m + 1/M: the two approach each other
    /// with this acceleration a `[m/s²]`, whatever their masses, and their centre of mass stays. It is
    /// a hand that holds the weight of the object.
    Balanced(f64),
    /// A constant hand, and gravity on the object. Where the hand does not hold the weight, device
    /// and object fly away together, ever faster.
    Weight {
        /// Force f_u of the hand on the device `[N]`.
        user_force: f64,
        /// Acceleration of gravity towards the device `[m/s²]`; no wall falls.
        gravity: f64,
    },
}

/// With or without the device's friction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Plant {
    /// The device without any friction.
    Undamped,
    /// The device with its viscous friction.
    Damped,
}

impl Plant {
    /// Both, in the order of tables and figures.
    pub const ALL: [Self; 2] = [Self::Undamped, Self::Damped];

    /// The name in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Undamped => "undamped",
            Self::Damped => "damped",
        }
    }
}

/// Why a bounce cannot be run.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BounceError {
    /// A method cannot be set up.
    #[error("{method}: {error}")]
    Method {
        /// The method.
        method: MethodName,
        /// What its renderer says.
        error: SetupError,
    },
    /// The bench refuses a value.
    #[error(transparent)]
    Bench(#[from] InvalidParameter),
    /// The scene cannot be run.
    #[error(transparent)]
    Loop(#[from] LoopError),
    /// The object does not fall onto the device.
    #[error("the object never meets the device: no force drives them together")]
    NoBounce,
    /// The window has too many periods.
    #[error("the bounce takes {0:.0} periods; at most {most} fit", most = palpate_sim::run::MOST_PERIODS)]
    TooLong(f64),
}

impl Bounce {
    /// Whether the object is a wall.
    #[must_use]
    pub fn is_wall(&self) -> bool {
        self.object_mass.is_infinite()
    }

    /// Force f_u of the hand on the device `[N]`.
    #[must_use]
    pub fn user_force(&self) -> f64 {
        match self.forces {
            Forces::Balanced(acceleration) => {
                acceleration / (1.0 / self.device.mass + 1.0 / self.object_mass)
            }
            Forces::Weight { user_force, .. } => user_force,
        }
    }

    /// Virtual force f_V on the object `[N]`; 0 for a wall, which no force moves.
    #[must_use]
    pub fn virtual_force(&self) -> f64 {
        match self.forces {
            _ if self.is_wall() => 0.0,
            Forces::Balanced(_) => -self.user_force(),
            Forces::Weight { gravity, .. } => -gravity * self.object_mass,
        }
    }

    /// The same bounce without the friction of the device, or with it.
    #[must_use]
    pub fn on(self, plant: Plant) -> Self {
        match plant {
            Plant::Damped => self,
            Plant::Undamped => Self {
                device: BounceDevice {
                    viscous_friction: 0.0,
                    coulomb_friction: 0.0,
                    ..self.device
                },
                ..self
            },
        }
    }

    /// This bounce as a scene, from a start height that differs by a share of the gap, judged over
    /// so many whole periods. What the renderer is told wrong is no part of it.
    #[must_use]
    pub fn scene(&self, height: f64, periods: usize) -> Scene {
        Scene {
            title: String::new(),
            contact: Contact::object(self.stiffness, self.object_mass),
            loop_params: LoopParams {
                // Nothing here is a broken sensor: a heavy object falls as fast as it falls.
                speed_limit: None,
                ..LoopParams::new(self.period)
            },
            object: ObjectState::at_rest((1.0 + height) * self.gap),
            virtual_force: self.virtual_force(),
            device: SceneDevice::PointMass(PointMassDevice {
                mass: self.device.mass,
                encoder_quantum: self.device.encoder_quantum,
                viscous_friction: self.device.viscous_friction,
                coulomb_friction: self.device.coulomb_friction,
                hand: Hand::pushing(self.user_force()),
                ..PointMassDevice::default()
            }),
            object_radius: 0.0,
            told_device_mass: None,
            delay: Delay::told_whole(self.delay, self.period),
            timing: Timing::default(),
            actuator: ActuatorParams {
                lag: self.lag,
                ..ActuatorParams::default()
            },
            told: Told::default(),
            measure: Measure::Duration(periods as f64 * self.period),
            method: MethodName::Hfcr,
            settings: HashMap::from([(MethodName::Hfcr, default_settings(MethodName::Hfcr))]),
        }
    }

    /// The renderer of `method` with its model values: contact, encoder, delay and lag as they are, with their
    /// deviations; period and mass perhaps wrong.
    ///
    /// # Errors
    /// A parameter outside its range, or settings that do not make the method.
    pub fn renderer(
        &self,
        method: MethodName,
        settings: Settings,
    ) -> Result<AnyRenderer<f64>, BounceError> {
        let mut scene = self.scene(0.0, 1);
        scene.loop_params.period *= self.told_period;
        scene.told_device_mass = Some(self.device.told_mass * self.device.mass);
        scene.told = self.told;
        scene.settings.insert(method, settings);
        scene
            .renderer(method)
            .map_err(|error| BounceError::Method { method, error })
    }
}

/// Settings that a map gives a method: its defaults, but for hfcr, which without a damping would be
/// `hfcr-mod-st` once more.
#[must_use]
pub fn default_settings(method: MethodName) -> Settings {
    let defaults = Settings::default();
    if method == MethodName::Hfcr {
        defaults.with(SettingKey::DAMPING, ParameterValue::ToBeDerived)
    } else {
        defaults
    }
}
