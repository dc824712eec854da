//! The scene of a cell: an object falls onto a device and bounces.

use std::collections::HashMap;

use palpate_core::{AnyRenderer, Contact, LoopParams, ObjectState, ParameterValue};
use palpate_testbed::InvalidParameter;

use crate::sim::closed_loop::LoopError;
use palpate_scene::method::{MethodName, SettingKey, Settings};
use palpate_scene::{
    ActuatorParams, Delay, Hand, Measure, Model, PointMassDevice, Scene, SceneDevice, SetupError,
    Timing,
};

/// True values of a device, and the renderer's model of its mass.
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
    /// Model mass of the renderer over the true mass.
    pub model_mass: f64,
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
    /// Forces that drive device and object together.
    pub forces: Forces,
    /// Distance between device and object at the start `[m]`.
    pub gap: f64,
    /// Period T of the loop `[s]`.
    pub period: f64,
    /// Model period of the renderer over the true period.
    pub model_period: f64,
    /// Time from a sample to the start of its force `[periods]`; may be fractional.
    pub delay: f64,
    /// Time constant of the following first-order lag `[s]`.
    pub lag: f64,
    /// Further model values of the renderer: deviations of delay, lag and gain, and the sensor noise.
    pub model: Model,
}

/// Constant forces that drive device and object together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Forces {
    /// Equal and opposite forces on both, µ a with 1/µ = 1/m + 1/M: device and object approach each other with this
    /// acceleration a `[m/s²]` at any masses, and their centre of mass is at rest. The hand balances the weight of
    /// the object.
    Balanced(f64),
    /// A constant force of the hand, and gravity on the object. If the hand does not balance the weight, device and
    /// object accelerate away together.
    Weight {
        /// Force f_u of the hand on the device `[N]`.
        user_force: f64,
        /// Acceleration of gravity towards the device `[m/s²]`; it does not act on walls.
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
    /// Both plants, in the order of tables and figures.
    pub const ALL: [Self; 2] = [Self::Undamped, Self::Damped];

    /// Returns the name in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Undamped => "undamped",
            Self::Damped => "damped",
        }
    }
}

/// Reason why a bounce cannot be run.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BounceError {
    /// A method cannot be set up.
    #[error("{method}: {error}")]
    Method {
        /// The method.
        method: MethodName,
        /// Error of its renderer.
        error: SetupError,
    },
    /// The bench rejects a value.
    #[error(transparent)]
    Bench(#[from] InvalidParameter),
    /// The scene cannot be run.
    #[error(transparent)]
    Loop(#[from] LoopError),
    /// The object does not fall onto the device.
    #[error("the object never meets the device: no force drives them together")]
    NoBounce,
    /// The window has too many periods.
    #[error("the bounce takes {0:.0} periods; at most {most} fit", most = crate::sim::run::MAX_PERIODS)]
    TooLong(f64),
}

impl Bounce {
    /// Whether the object is a wall.
    #[must_use]
    pub fn is_wall(&self) -> bool {
        self.object_mass.is_infinite()
    }

    /// Returns the force f_u of the hand on the device `[N]`.
    #[must_use]
    pub fn user_force(&self) -> f64 {
        match self.forces {
            Forces::Balanced(acceleration) => {
                acceleration / (1.0 / self.device.mass + 1.0 / self.object_mass)
            }
            Forces::Weight { user_force, .. } => user_force,
        }
    }

    /// Returns the virtual force f_V on the object `[N]`; 0 for a wall, which cannot move.
    #[must_use]
    pub fn virtual_force(&self) -> f64 {
        match self.forces {
            _ if self.is_wall() => 0.0,
            Forces::Balanced(_) => -self.user_force(),
            Forces::Weight { gravity, .. } => -gravity * self.object_mass,
        }
    }

    /// Returns the same bounce with or without the friction of the device.
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

    /// Returns this bounce as a scene with a window of `periods` whole periods; `height` changes the start height by
    /// a share of the gap. Wrong model values of the renderer are not part of the scene.
    #[must_use]
    pub fn scene(&self, height: f64, periods: usize) -> Scene {
        Scene {
            title: String::new(),
            contact: Contact::object(self.stiffness, self.object_mass),
            loop_params: LoopParams {
                // No speed limit: a fast heavy object is not a sensor fault here.
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
            model_device_mass: None,
            delay: Delay::from_seconds(self.delay * self.period, self.period),
            timing: Timing::default(),
            actuator: ActuatorParams {
                lag: self.lag,
                ..ActuatorParams::default()
            },
            model: Model::default(),
            measure: Measure::Duration(periods as f64 * self.period),
            method: MethodName::Hfcr,
            settings: HashMap::from([(MethodName::Hfcr, default_settings(MethodName::Hfcr))]),
        }
    }

    /// Returns the renderer of `method`. Contact, encoder, delay and lag of its model are the true values, with their
    /// deviations; period and mass may be wrong.
    ///
    /// # Errors
    /// A parameter is out of range, or the settings do not fit the method.
    pub fn renderer(
        &self,
        method: MethodName,
        settings: Settings,
    ) -> Result<AnyRenderer<f64>, BounceError> {
        self.limited_renderer(method, settings, None)
    }

    /// Creates that renderer with a limit of the force `[N]`.
    pub(crate) fn limited_renderer(
        &self,
        method: MethodName,
        settings: Settings,
        force_limit: Option<f64>,
    ) -> Result<AnyRenderer<f64>, BounceError> {
        let mut scene = self.scene(0.0, 1);
        scene.loop_params.force_limit = force_limit;
        scene.loop_params.period *= self.model_period;
        scene.model_device_mass = Some(self.device.model_mass * self.device.mass);
        scene.model = self.model;
        scene.settings.insert(method, settings);
        scene
            .renderer(method)
            .map_err(|error| BounceError::Method { method, error })
    }
}

/// Returns the settings of a method in a map: its defaults, except for hfcr, which without a damping would equal
/// `hfcr-mod-st`.
#[must_use]
pub fn default_settings(method: MethodName) -> Settings {
    let defaults = Settings::default();
    if method == MethodName::Hfcr {
        defaults.with(SettingKey::DAMPING, ParameterValue::ToBeDerived)
    } else {
        defaults
    }
}
