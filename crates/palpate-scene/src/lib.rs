#![doc = include_str!("../README.md")]
//!
//! # Overview
//!
//! Scene files: devices with their hands, bodies, contacts, a loop and a renderer. The module [`method`] has the
//! methods by name, with their settings.
//!
//! A scene file is TOML with a format version. Every quantity is SI and has its unit in its key. Unknown keys are
//! errors. The scene alone decides who renders it: the closed form, if it has one contact along one axis, or the world
//! renderer ([`SceneFile`]). `experiments/` contains the paper's scenes. A separate device file of the same style
//! describes a linkage; see `devices/`.

mod beside;
mod check;
mod contact_body;
mod contact_device;
mod contact_file;
mod delay;
mod device;
mod device_file;
mod device_key;
mod drivetrain_key;
mod edit;
mod fault;
mod guard;
mod hand;
mod hand_key;
mod linkage;
pub mod method;
mod model;
pub mod named_parameters;
mod one_contact;
mod parameter;
mod period;
mod raw;
mod raw_settings;
mod recover;
mod render_key;
mod scene_file;
mod source;
mod timing;
mod toml_reader;
pub mod world;
mod write;

pub use beside::{beside, scene_bytes};
pub use check::{LARGEST, SceneParameterError, check_sizes};
pub use contact_file::ContactFile;
pub use delay::Delay;
pub use device::{PantographDevice, PointMassDevice, SceneDevice};
pub use edit::Edit;
pub use fault::in_plain_words;
pub use fault::{SceneError, SceneErrors};
pub use guard::{
    GUARD_ALLOWANCE, GUARD_RECOVERY, GUARD_SPEED, GuardBounds, GuardConflict, GuardMode,
    HAND_GUARD_ALLOWANCE, guard_of_device, hand_limit,
};
pub use hand::{Grip, Hand, Intention, Wave};
pub use linkage::{HandForceAt, Linkage};
pub use model::{Model, quantum_of};
pub use parameter::SceneParameter;
pub use period::{lag_question, period_question};
pub use scene_file::SceneFile;
pub use source::Source;
pub use timing::{Dropped, Jitter, RateCollapse, Timing};
pub use write::Unwritable;

use std::collections::HashMap;

use palpate_core::{
    AnyParams, AnyRenderer, Contact, Hold, LoopParams, Mass, ObjectState, ParameterError, Renderer,
    Rendering,
};

pub use palpate_testbed::actuator::ActuatorParams;
pub use palpate_testbed::drivetrain::{Cogging, Transmission};

use crate::method::{Basis, MethodName, Settings, SettingsError};

/// A closed loop with one contact along one axis: everything but the choice of the method is fixed.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// A line for tables and figures.
    pub title: String,
    /// The contact.
    pub contact: Contact<f64>,
    /// The loop.
    pub loop_params: LoopParams<f64>,
    /// The object at the start.
    pub object: ObjectState<f64>,
    /// Distance from the object's position to its centre, on its far side from the device `[m]`: the radius of a ball.
    /// Used for drawing and for the written centre; forces do not depend on it.
    pub object_radius: f64,
    /// Virtual force f_V on the object `[N]`.
    pub virtual_force: f64,
    /// The device and the hand that moves it.
    pub device: SceneDevice,
    /// Model value of the device mass `[kg]`; `None`: [`SceneDevice::mass`].
    pub model_device_mass: Option<f64>,
    /// Delay from a sample to its command.
    pub delay: Delay,
    /// Other timing imperfections of the loop.
    pub timing: Timing,
    /// True gain and lag of the actuator.
    pub actuator: ActuatorParams,
    /// Overrides of true values in the renderer's model of delay, lag and gain.
    pub model: Model,
    /// Evaluation window.
    pub measure: Measure,
    /// The method to run when none is named.
    pub method: MethodName,
    /// Settings of methods; one without an entry takes its defaults.
    pub settings: HashMap<MethodName, Settings>,
}

/// Evaluation window of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Measure {
    /// Until this many collisions of the ideal have ended, and half a period more.
    Collisions(usize),
    /// A time `[s]`, up to the next whole period.
    Duration(f64),
}

/// Reason why a method cannot be rendered in this scene.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SetupError {
    /// A parameter is outside its range.
    #[error(transparent)]
    Parameter(#[from] SceneParameterError),
    /// Settings and method do not go together.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// The actuator is to hold a line, and the method plans constants.
    #[error(
        "{0} plans a constant force, but loop.hold is \"line\"; coupled plans lines: use it, or loop.hold = \"constant\""
    )]
    HoldsConstant(MethodName),
}

impl From<ParameterError> for SetupError {
    fn from(error: ParameterError) -> Self {
        Self::Parameter(error.map(SceneParameter::Rendered))
    }
}

impl Scene {
    /// Returns the offset of the object's centre from its position, in the user's frame `[m]`.
    #[must_use]
    pub fn centre_offset(&self) -> f64 {
        let sign: f64 = self.contact.side.sign();
        sign * self.object_radius
    }

    /// Returns the force that the actuator holds for each command.
    #[must_use]
    pub fn hold(&self) -> Hold {
        self.loop_params.actuation.hold
    }

    /// The renderer of this scene by `method`.
    ///
    /// # Errors
    /// A parameter of the contact, the loop or the method outside its range; a setting that the
    /// method cannot use; a line hold that it cannot use.
    pub fn renderer(&self, method: MethodName) -> Result<AnyRenderer<f64>, SetupError> {
        let params = self.params(method)?;
        if self.hold() == Hold::Line && method != MethodName::Coupled {
            return Err(SetupError::HoldsConstant(method));
        }
        let renderer = Renderer::new(self.contact, self.loop_params_with_delay(), params);
        renderer.map_err(SetupError::from)
    }

    /// Returns the renderer's model of the loop, with the model values of delay, lag and gain.
    #[must_use]
    pub fn loop_params_with_delay(&self) -> LoopParams<f64> {
        LoopParams {
            actuation: self.model_actuation(),
            guard: guard_of_device(
                self.loop_params.guard,
                Some(self.model_device_mass.unwrap_or(self.device.mass())),
                self.model
                    .sensor_quantum
                    .unwrap_or(self.device.encoder_quantum()),
            ),
            ..self.loop_params
        }
    }

    /// Returns the rendering of this scene by `method`.
    ///
    /// # Errors
    /// Those of [`renderer`](Self::renderer).
    pub fn rendering(&self, method: MethodName) -> Result<Rendering<f64>, SetupError> {
        let renderer = self.renderer(method)?;
        Ok(Rendering {
            contact: self.contact,
            loop_params: *renderer.loop_params(),
            params: self.params(method)?,
            virtual_force: self.virtual_force,
            object: self.object,
        })
    }

    /// Parameters of `method` here, from its settings and their defaults.
    ///
    /// # Errors
    /// A setting that the method cannot use.
    pub fn params(&self, method: MethodName) -> Result<AnyParams<f64>, SettingsError> {
        let settings = self.settings.get(&method).copied().unwrap_or_default();
        let basis = Basis {
            stiffness: self.contact.stiffness,
            period: self.loop_params.period,
            device_mass: Some(self.model_device_mass.unwrap_or(self.device.mass())),
            encoder_quantum: self.model_quantum(),
            recorded: false,
            stored_energy: stored_energy(&self.contact, self.object, self.device.position()),
        };
        method.params(&settings, &basis)
    }
}

/// Kinetic energy of an object and elastic energy of its contact with a device at
/// `device_position` `[J]`.
#[must_use]
pub fn stored_energy(
    contact: &Contact<f64>,
    object: ObjectState<f64>,
    device_position: f64,
) -> f64 {
    let sign: f64 = contact.side.sign();
    let pressed = (sign * (device_position - object.position)).max(0.0);
    let kinetic = match contact.object_mass {
        Mass::Finite(mass) => mass * object.velocity * object.velocity,
        Mass::Infinite => 0.0,
    };
    0.5 * (kinetic + contact.stiffness * pressed * pressed)
}
