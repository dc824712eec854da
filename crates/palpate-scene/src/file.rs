//! Scene files.

use std::collections::HashMap;
use std::io;
use std::ops::Range;

use palpate::{Contact, Guard, GuardParams, LoopParams, ObjectState, Parameter, Side};
use serde::Deserialize;
use toml::Spanned;

use super::beside::Files;
use super::check::SceneParameterError;
use super::device_key::{DeviceFault, RawDevice};
use super::fault::{Places, SceneError, in_plain_words};
use super::hand::{RawHand, ReadHand};
use super::parameter::SceneParameter;
use super::timing::RawLoop;
use super::{Measure, PointMassDevice, Scene, SetupError};
use crate::method::{GivenSettings, MethodName, SettingsError, method_named};

/// The version of scene files this crate reads.
const FORMAT: i64 = 1;

/// A scene read from a file, which still knows where each of its values stands.
#[derive(Clone, Debug)]
pub struct SceneFile {
    /// The scene.
    pub scene: Scene,
    name: String,
    source: String,
    places: HashMap<SceneParameter, Range<usize>>,
    methods: HashMap<MethodName, Range<usize>>,
}

/// The version alone: a file of another version may have keys this one does not know.
#[derive(Deserialize)]
struct RawVersion {
    scene_format: Spanned<i64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawScene {
    #[serde(rename = "scene_format")]
    _scene_format: i64,
    title: String,
    object: RawObject,
    device: RawDevice,
    #[serde(default)]
    hand: RawHand,
    r#loop: RawLoop,
    measure: Spanned<RawMeasure>,
    #[serde(default)]
    renderer: RawRenderer,
    #[serde(default)]
    methods: HashMap<Spanned<String>, GivenSettings>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawObject {
    stiffness_n_per_m: Spanned<f64>,
    mass_kg: Spanned<f64>,
    position_m: Spanned<f64>,
    velocity_m_per_s: Option<Spanned<f64>>,
    radius_m: Option<Spanned<f64>>,
    force_n: Option<Spanned<f64>>,
    side: Option<Side>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawMeasure {
    collisions: Option<Spanned<usize>>,
    duration_s: Option<Spanned<f64>>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct RawRenderer {
    method: Option<Spanned<String>>,
    device_mass_kg: Option<Spanned<f64>>,
    unilateral: Option<bool>,
    force_limit_n: Option<Spanned<f64>>,
    slew_limit_n_per_s: Option<Spanned<f64>>,
    speed_limit_m_per_s: Option<Spanned<f64>>,
    largest_gap_s: Option<Spanned<f64>>,
    guard: Option<RawGuard>,
}

/// A bound on the energy that held forces give out.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawGuard {
    mode: GuardMode,
    speed_m_per_s: Option<Spanned<f64>>,
    allowance_j: Option<Spanned<f64>>,
}

/// What a guard does with a force beyond its bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum GuardMode {
    /// There is no guard.
    Off,
    /// It says so.
    Report,
    /// It keeps the force to the bound.
    Limit,
}

impl GuardMode {
    /// The guard against device speeds up to `largest_speed` `[m/s]`, with an `allowance` `[J]`.
    pub fn guard(self, largest_speed: f64, allowance: f64) -> Guard<f64> {
        let params = GuardParams {
            largest_speed,
            allowance,
        };
        match self {
            Self::Off => Guard::Off,
            Self::Report => Guard::Report(params),
            Self::Limit => Guard::Limit(params),
        }
    }
}

/// Device speed that a guard reckons with where none is stated `[m/s]`: a brisk hand.
pub const GUARD_SPEED: f64 = 1.0;
/// Allowance of a guard where none is stated `[J]`.
pub const GUARD_ALLOWANCE: f64 = 1e-3;

impl SceneFile {
    /// Reads a scene that stands alone: as [`parse_with`](Self::parse_with), but every file that the
    /// scene names is missing.
    ///
    /// # Errors
    /// The first fault, with its line and column and with what is allowed.
    pub fn parse(name: &str, source: &str) -> Result<Self, SceneError> {
        Self::parse_with(name, source, &mut |_| {
            let alone = "this scene is read without the files beside it";
            Err(io::Error::new(io::ErrorKind::NotFound, alone))
        })
    }

    /// Reads a scene from the text of a file called `name`, and checks it for the method it names
    /// and for every method it has settings for. `files` gives the text of a file by the name that
    /// stands in the scene; [`beside`](super::beside) looks in the scene's own folder.
    ///
    /// # Errors
    /// The first fault in the scene file or, with that file's name, in the device file; with its line
    /// and column and with what is allowed.
    pub fn parse_with(name: &str, source: &str, files: Files<'_>) -> Result<Self, SceneError> {
        let fault =
            |span: Range<usize>, message: String| SceneError::at(name, source, span, message);
        if let Ok(RawVersion { scene_format }) = toml::from_str(source)
            && *scene_format.get_ref() != FORMAT
        {
            return Err(fault(
                scene_format.span(),
                format!(
                    "scene_format is {}, but this version reads {FORMAT} only",
                    scene_format.get_ref()
                ),
            ));
        }
        let raw: RawScene = toml::from_str(source).map_err(|error| {
            fault(
                error.span().unwrap_or(0..0),
                in_plain_words(error.message()),
            )
        })?;
        let mut places = Places::default();
        let mut method_places = HashMap::new();

        let measure_span = raw.measure.span();
        let measure = raw.measure.into_inner();
        let measure = match (measure.collisions, measure.duration_s) {
            (Some(count), None) => {
                Measure::Collisions(places.take(SceneParameter::Collisions, count))
            }
            (None, Some(duration)) => {
                Measure::Duration(places.take(SceneParameter::Duration, duration))
            }
            _ => {
                return Err(fault(
                    measure_span,
                    "[measure] needs either collisions or duration_s, one of them".into(),
                ));
            }
        };
        let mut settings = HashMap::new();
        // In the file's order: the first fault is to be the same one every time.
        let mut methods: Vec<_> = raw.methods.into_iter().collect();
        methods.sort_by_key(|(method_key, _)| method_key.span().start);
        for (method_key, raw) in methods {
            let span = method_key.span();
            let method = method_named(method_key.get_ref())
                .map_err(|error| fault(span.clone(), error.to_string()))?;
            method_places.insert(method, span);
            settings.insert(method, raw.0);
        }
        let method = match &raw.renderer.method {
            Some(name) => method_named(name.get_ref())
                .map_err(|error| fault(name.span(), error.to_string()))?,
            None => MethodName::default(),
        };
        let limit =
            |places: &mut Places<SceneParameter>,
             of: SceneParameter,
             value: Option<Spanned<f64>>| { value.map(|value| places.take(of, value)) };
        let contact = Contact {
            side: raw.object.side.unwrap_or_default(),
            unilateral: raw.renderer.unilateral.unwrap_or(false),
            ..Contact::object(
                places.take(Parameter::Stiffness, raw.object.stiffness_n_per_m),
                places.take(Parameter::ObjectMass, raw.object.mass_kg),
            )
        };
        let mut device = raw.device;
        let linkage = device.linkage(name, files).map_err(|error| match error {
            DeviceFault::Here(span, message) => fault(span, message),
            DeviceFault::InDeviceFile(error) => error,
        })?;
        let device_position = places.take_or(
            SceneParameter::DevicePosition,
            device.position_m.take(),
            0.0,
        );
        let device_mass = match &linkage {
            Some(linkage) => linkage.effective_mass(device_position).map_err(|error| {
                let place = places.0.get(&SceneParameter::DevicePosition).cloned();
                fault(place.unwrap_or(device.kind.span()), error.to_string())
            })?,
            // Checked to be there.
            None => places.take_or(Parameter::DeviceMass, device.mass_kg.take(), f64::NAN),
        };
        let ReadHand {
            force,
            force_at,
            tremor,
            release,
            grip,
        } = raw
            .hand
            .read(&mut places, files)
            .map_err(|(span, message)| fault(span, message))?;
        let period = places.take(Parameter::Period, raw.r#loop.period_s.clone());
        let (delay, timing) = raw
            .r#loop
            .timing(&mut places)
            .map_err(|(span, message)| fault(span, message.into()))?;
        let scene = Scene {
            title: raw.title,
            contact,
            loop_params: LoopParams {
                // A simulated device does not glitch; a loop that diverges is to be seen doing so.
                speed_limit: limit(
                    &mut places,
                    Parameter::SpeedLimit.into(),
                    raw.renderer.speed_limit_m_per_s,
                ),
                force_limit: limit(
                    &mut places,
                    Parameter::ForceLimit.into(),
                    raw.renderer.force_limit_n,
                ),
                slew_limit: limit(
                    &mut places,
                    Parameter::SlewLimit.into(),
                    raw.renderer.slew_limit_n_per_s,
                ),
                largest_gap: limit(
                    &mut places,
                    Parameter::LargestGap.into(),
                    raw.renderer.largest_gap_s,
                ),
                guard: raw.renderer.guard.map_or(Guard::Off, |guard| {
                    guard.mode.guard(
                        places.take_or(Parameter::GuardSpeed, guard.speed_m_per_s, GUARD_SPEED),
                        places.take_or(
                            Parameter::GuardAllowance,
                            guard.allowance_j,
                            GUARD_ALLOWANCE,
                        ),
                    )
                }),
                ..LoopParams::new(period)
            },
            object: ObjectState {
                position: places.take(Parameter::ObjectPosition, raw.object.position_m),
                velocity: places.take_or(
                    Parameter::ObjectVelocity,
                    raw.object.velocity_m_per_s,
                    0.0,
                ),
            },
            object_radius: places.take_or(SceneParameter::ObjectRadius, raw.object.radius_m, 0.0),
            virtual_force: places.take_or(Parameter::VirtualForce, raw.object.force_n, 0.0),
            linkage,
            device: PointMassDevice {
                mass: device_mass,
                position: device_position,
                velocity: places.take_or(
                    SceneParameter::DeviceVelocity,
                    device.velocity_m_per_s,
                    0.0,
                ),
                encoder_quantum: places.take_or(
                    Parameter::EncoderQuantum,
                    device.encoder_quantum_m,
                    0.0,
                ),
                viscous_friction: places.take_or(
                    SceneParameter::ViscousFriction,
                    device.viscous_n_s_per_m,
                    0.0,
                ),
                coulomb_friction: places.take_or(
                    SceneParameter::CoulombFriction,
                    device.coulomb_n,
                    0.0,
                ),
                largest_force: limit(
                    &mut places,
                    SceneParameter::MotorLimit,
                    device.motor_limit_n,
                ),
            },
            told_device_mass: limit(
                &mut places,
                SceneParameter::ToldDeviceMass,
                raw.renderer.device_mass_kg,
            ),
            user_force: force,
            user_force_at: force_at,
            tremor,
            release,
            grip,
            recorded_hand: None,
            delay,
            timing,
            measure,
            method,
            settings,
        };
        let file = Self {
            scene,
            name: name.into(),
            source: source.into(),
            places: places.0,
            methods: method_places,
        };
        file.scene
            .check()
            .map_err(|error| file.locate_parameter(&error))?;
        let named = |method: &MethodName| {
            *method == file.scene.method || file.scene.settings.contains_key(method)
        };
        for method in MethodName::ALL.into_iter().filter(named) {
            file.scene
                .renderer(method)
                .map_err(|error| file.locate(method, &error))?;
        }
        Ok(file)
    }

    /// The place of what makes `method` impossible here.
    pub fn locate(&self, method: MethodName, error: &SetupError) -> SceneError {
        match error {
            SetupError::Parameter(parameter) if self.places.contains_key(&parameter.parameter) => {
                self.locate_parameter(parameter)
            }
            SetupError::Parameter(parameter) => self.at_settings(method, parameter.to_string()),
            SetupError::Settings(SettingsError::Unused { setting, .. }) => self.at_settings(
                method,
                format!(
                    "{method} has no use for {}; it is for {}",
                    setting.key,
                    setting.key.users()
                ),
            ),
            SetupError::Settings(other) => self.at_settings(method, other.to_string()),
        }
    }

    /// The place of a parameter that is out of range.
    pub fn locate_parameter(&self, error: &SceneParameterError) -> SceneError {
        self.at(error.parameter, error.to_string())
    }

    /// A fault at the place of `parameter`; at the file's beginning, where the file does not say it.
    pub fn at(&self, parameter: SceneParameter, message: String) -> SceneError {
        let span = self.places.get(&parameter).cloned();
        SceneError::at(&self.name, &self.source, span.unwrap_or(0..0), message)
    }

    /// A fault of the file as a whole.
    pub fn as_a_whole(&self, message: String) -> SceneError {
        SceneError::at(&self.name, &self.source, 0..0, message)
    }

    fn at_settings(&self, method: MethodName, message: String) -> SceneError {
        let span = self.methods.get(&method).cloned();
        SceneError::at(&self.name, &self.source, span.unwrap_or(0..0), message)
    }
}
