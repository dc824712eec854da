//! Scene files.

use std::collections::{HashMap, HashSet};
use std::io;
use std::ops::Range;

use palpate_core::{Allowed, Contact, MethodParams as _, ObjectState, Parameter, Side};
use serde::Deserialize;
use toml::Spanned;
use toml::de::DeTable;

use super::beside::Files;
use super::check::SceneParameterError;
use super::delay::Delay;
use super::device_key::{DeviceFault, RawDevice, ReadDevice, ReadPointMass};
use super::fault::{Places, SceneError, SceneErrors};
use super::hand_key::{RawHand, ReadHand};
use super::model::RawModel;
use super::parameter::SceneParameter::{self, self as Of};
use super::recover::{self, Fault};
use super::renderer_key::RawRenderer;
use super::timing::{RawLoop, Timing};
use super::toml_reader;
use super::{HandForceAt, Measure, PantographDevice, Scene, SceneDevice, SetupError};
use crate::method::{GivenSettings, MethodName, Setting, Settings, SettingsError, method_named};
use crate::world::WorldFile;

/// The version of scene files this crate reads.
const FORMAT: i64 = 1;

/// A scene read from a file, with the spans of its values.
#[derive(Clone, Debug)]
pub struct SceneFile {
    /// The scene.
    pub scene: Scene,
    name: String,
    source: String,
    places: HashMap<SceneParameter, Range<usize>>,
    methods: HashMap<MethodName, MethodPlaces>,
}

/// Source spans of a method's settings.
#[derive(Clone, Debug)]
struct MethodPlaces {
    name: Range<usize>,
    /// Key and value of each setting.
    settings: HashMap<String, (Range<usize>, Range<usize>)>,
}

/// The key of the version.
const VERSION_KEY: &str = "scene_format";

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
    #[serde(default)]
    model: RawModel,
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

impl SceneFile {
    /// Reads a self-contained scene. Like [`parse_with`](Self::parse_with), but every file that the scene names is
    /// missing.
    ///
    /// # Errors
    /// All errors, each with its line, its column and the allowed values.
    pub fn parse(name: &str, source: &str) -> Result<Self, SceneErrors> {
        Self::parse_with(name, source, &mut |_| {
            let alone = "this scene is read without other files";
            Err(io::Error::new(io::ErrorKind::NotFound, alone))
        })
    }

    /// Reads a scene from the text of a file called `name`, and checks it for its method and for every method with
    /// settings. `files` returns the text of a file by its name in the scene; [`beside`](super::beside) reads from the
    /// scene's own folder.
    ///
    /// # Errors
    /// All errors in the scene file and, with that file's name, the first in the device file; each with its line, its
    /// column and the allowed values.
    pub fn parse_with(name: &str, source: &str, files: Files<'_>) -> Result<Self, SceneErrors> {
        let mut reading = Reading {
            name,
            source,
            faults: Vec::new(),
            damaged: HashSet::new(),
        };
        let file = reading.read(files);
        match (SceneErrors::new(reading.faults), file) {
            (None, Some(file)) => Ok(file),
            (Some(errors), _) => Err(errors),
            (None, None) => unreachable!("an unreadable file has a fault"),
        }
    }

    /// The place of what makes `method` impossible here.
    #[must_use]
    pub fn locate(&self, method: MethodName, error: &SetupError) -> SceneError {
        match error {
            SetupError::Parameter(parameter) if self.places.contains_key(&parameter.parameter) => {
                self.locate_parameter(parameter)
            }
            SetupError::Parameter(parameter) => {
                let setting = match parameter.parameter {
                    Of::Rendered(Parameter::Setting(setting)) => Some(setting),
                    _ => None,
                };
                self.at_settings(method, setting, parameter.to_string())
            }
            SetupError::Settings(error) => self.locate_settings(method, error),
        }
    }

    fn locate_settings(&self, method: MethodName, error: &SettingsError) -> SceneError {
        match error {
            SettingsError::Unused { setting, .. } => {
                let key = self.place_of(method, setting).map(|(key, _)| key);
                let message = format!(
                    "{method} does not use {}; it is for {}",
                    setting.key,
                    setting.key.users()
                );
                self.at_span(key.or_else(|| self.place_of_method(method)), message)
            }
            SettingsError::NoRule { setting, .. }
            | SettingsError::NoDeviceMass(setting)
            | SettingsError::OnlyBeside { setting, .. } => {
                self.at_settings(method, Some(setting), error.to_string())
            }
            SettingsError::NoPushedMass(_) => self.at_settings(method, None, error.to_string()),
        }
    }

    /// The place of a parameter that is out of range.
    #[must_use]
    pub fn locate_parameter(&self, error: &SceneParameterError) -> SceneError {
        self.at(error.parameter, error.to_string())
    }

    /// Returns a fault at the span of `parameter`, or at the beginning of the file if it has no such key.
    #[must_use]
    pub fn at(&self, parameter: SceneParameter, message: String) -> SceneError {
        self.at_span(self.places.get(&parameter).cloned(), message)
    }

    /// A fault of the file as a whole.
    #[must_use]
    pub fn as_a_whole(&self, message: String) -> SceneError {
        self.at_span(None, message)
    }

    /// A fault of a method's settings: at the value of `setting` where the file gives it, else at the method's name.
    fn at_settings(
        &self,
        method: MethodName,
        setting: Option<&Setting>,
        message: String,
    ) -> SceneError {
        let value = setting.and_then(|setting| self.place_of(method, setting));
        let span = value.map(|(_, value)| value);
        self.at_span(span.or_else(|| self.place_of_method(method)), message)
    }

    /// Returns the spans of the key and value of a setting.
    fn place_of(
        &self,
        method: MethodName,
        setting: &Setting,
    ) -> Option<(Range<usize>, Range<usize>)> {
        let places = &self.methods.get(&method)?.settings;
        places.get(setting.key.as_str()).cloned()
    }

    fn place_of_method(&self, method: MethodName) -> Option<Range<usize>> {
        Some(self.methods.get(&method)?.name.clone())
    }

    fn at_span(&self, span: Option<Range<usize>>, message: String) -> SceneError {
        SceneError::at(&self.name, &self.source, span.unwrap_or(0..0), message)
    }
}

/// A partially read scene file with its errors.
struct Reading<'a> {
    name: &'a str,
    source: &'a str,
    faults: Vec<SceneError>,
    /// Tables that keys at fault were taken out of.
    damaged: HashSet<String>,
}

impl Reading<'_> {
    fn fault(&mut self, (span, message): Fault) {
        let fault = SceneError::at(self.name, self.source, span, message);
        self.faults.push(fault);
    }

    /// Returns the value that was read from keys of `table`. On a fault, records it and returns `instead` so that
    /// reading continues.
    fn or<T>(&mut self, table: &str, read: Result<T, Fault>, instead: T) -> T {
        read.unwrap_or_else(|fault| {
            self.in_table(table, fault);
            instead
        })
    }

    /// A fault of several keys of a `table`; none where one of them has been at fault by itself.
    fn in_table(&mut self, table: &str, fault: Fault) {
        if !self.damaged.contains(table) {
            self.fault(fault);
        }
    }

    /// The file; where there are faults, what is left of it, or nothing.
    fn read(&mut self, files: Files<'_>) -> Option<SceneFile> {
        if let Ok(RawVersion { scene_format }) = toml_reader::from_text(self.source)
            && *scene_format.get_ref() != FORMAT
        {
            let message = format!(
                "scene_format is {}, but this version reads {FORMAT} only",
                scene_format.get_ref()
            );
            self.fault((scene_format.span(), message));
            return None;
        }
        if WorldFile::is_world_file(self.source) {
            let message = "the key format belongs to a world of several bodies; a scene of one contact is needed here, \
                           with scene_format = 1";
            self.fault((0..0, message.into()));
            return None;
        }
        if WorldFile::lacks_its_format(self.source) {
            let message =
                "the key format is missing; a world with [[device]] and [[body]] needs format = 2";
            self.fault((0..0, message.into()));
            return None;
        }
        let left = recover::read::<RawScene>(self.source);
        let without_version = left.missing.get(VERSION_KEY);
        for (number, (span, mut message)) in left.faults.into_iter().enumerate() {
            if without_version == Some(&number) {
                message += "; a scene of one contact has scene_format = 1, and a world of several bodies format = 2";
            }
            self.fault((span, message));
        }
        self.damaged = left.damaged;
        let file = self.scene(left.read?, files);
        self.check(&file);
        Some(file)
    }

    fn scene(&mut self, raw: RawScene, files: Files<'_>) -> SceneFile {
        let mut places = Places::default();
        let measure = self.measure(raw.measure, &mut places);
        let (settings, methods) = self.settings(raw.methods);
        let method = self.method(raw.renderer.method.as_ref());
        let object = raw.object;
        let contact = Contact {
            side: object.side.unwrap_or_default(),
            unilateral: raw.renderer.unilateral.unwrap_or(false),
            ..Contact::object(
                places.take(Parameter::Stiffness, object.stiffness_n_per_m),
                places.take(Parameter::ObjectMass, object.mass_kg),
            )
        };
        let device = self.held_device(raw.device, raw.hand, &mut places, files);
        let period = places.take(Parameter::Period, raw.r#loop.period_s.clone());
        let actuator = raw.r#loop.actuator(&mut places);
        if let Some(alone) = raw.model.alone() {
            self.in_table("model", alone);
        }
        let model = raw.model.read(&mut places);
        let timing = raw.r#loop.timing(&mut places);
        let timing = timing.map_err(|(span, message)| (span, message.to_owned()));
        let (delay, timing) = self.or("loop", timing, (Delay::NONE, Timing::default()));
        let (loop_params, model_device_mass) = raw.renderer.read(period, &mut places);
        let scene = Scene {
            title: raw.title,
            contact,
            loop_params,
            object: ObjectState {
                position: places.take(Parameter::ObjectPosition, object.position_m),
                velocity: places.take_or(Parameter::ObjectVelocity, object.velocity_m_per_s, 0.0),
            },
            object_radius: places.take_or(Of::ObjectRadius, object.radius_m, 0.0),
            virtual_force: places.take_or(Parameter::VirtualForce, object.force_n, 0.0),
            device,
            model_device_mass,
            delay,
            timing,
            actuator,
            model,
            measure,
            method,
            settings,
        };
        SceneFile {
            scene,
            name: self.name.into(),
            source: self.source.into(),
            places: places.0,
            methods,
        }
    }

    /// Returns what `[measure]` gives; a substitute for neither or both of its keys.
    fn measure(
        &mut self,
        raw: Spanned<RawMeasure>,
        places: &mut Places<SceneParameter>,
    ) -> Measure {
        let measure_span = raw.span();
        let measure = raw.into_inner();
        match (measure.collisions, measure.duration_s) {
            (Some(count), None) => Measure::Collisions(places.take(Of::Collisions, count)),
            (None, Some(duration)) => Measure::Duration(places.take(Of::Duration, duration)),
            _ => {
                let message = "[measure] needs either collisions or duration_s";
                self.in_table("measure", (measure_span, message.into()));
                Measure::Collisions(1)
            }
        }
    }

    /// Returns the method of that name; the default for none or an unknown one.
    fn method(&mut self, given: Option<&Spanned<String>>) -> MethodName {
        let mut method = MethodName::default();
        if let Some(given) = given {
            match method_named(given.get_ref()) {
                Ok(named) => method = named,
                Err(error) => self.fault((given.span(), error.to_string())),
            }
        }
        method
    }

    /// Returns the device with its hand.
    fn held_device(
        &mut self,
        device: RawDevice,
        hand: RawHand,
        places: &mut Places<SceneParameter>,
        files: Files<'_>,
    ) -> SceneDevice {
        let before = self.faults.len();
        let mut device = self.device(device, places, files);
        let is_that_device = self.faults.len() == before && !self.damaged.contains("device");
        let hand = hand.read(places, files);
        let hand = self.or("hand", hand, ReadHand::default());
        for fault in hand.hold(&mut device) {
            // The substitute of a faulty device may be of another kind.
            if is_that_device {
                self.in_table("hand", fault);
            }
        }
        device
    }

    /// Settings of the methods that the file names, and where it does.
    fn settings(
        &mut self,
        raw: HashMap<Spanned<String>, GivenSettings>,
    ) -> (
        HashMap<MethodName, Settings>,
        HashMap<MethodName, MethodPlaces>,
    ) {
        // Settings are read by their keys in methods, so their spans come from a second parse of the file.
        let table = DeTable::parse(self.source).ok();
        let table = table.as_ref().map(Spanned::get_ref);
        let methods = table.and_then(|file| file.get("methods")?.get_ref().as_table());
        let (mut settings, mut places) = (HashMap::new(), HashMap::new());
        for (key, given) in raw {
            match method_named(key.get_ref()) {
                Ok(method) => {
                    let of_method = methods.and_then(|all| all.get(method.name()));
                    let of_method = of_method.and_then(|given| given.get_ref().as_table());
                    let spans = of_method.into_iter().flatten().map(|(key, value)| {
                        (key.get_ref().to_string(), (key.span(), value.span()))
                    });
                    let place = MethodPlaces {
                        name: key.span(),
                        settings: spans.collect(),
                    };
                    places.insert(method, place);
                    settings.insert(method, given.0);
                }
                Err(error) => self.fault((key.span(), error.to_string())),
            }
        }
        (settings, places)
    }

    /// Returns the device, without a hand.
    fn device(
        &mut self,
        raw: RawDevice,
        places: &mut Places<SceneParameter>,
        files: Files<'_>,
    ) -> SceneDevice {
        let kind = raw.kind.span();
        let device = match raw.read(self.name, files) {
            Ok(device) => device,
            Err(fault) => {
                match fault {
                    DeviceFault::Here(span, message) => self.in_table("device", (span, message)),
                    DeviceFault::InDeviceFile(error) => self.faults.push(error),
                }
                // A valid mass, so that the remaining keys can be checked.
                let mass = Spanned::new(kind.clone(), 1.0);
                ReadDevice::PointMass(ReadPointMass::new(mass))
            }
        };
        match device {
            ReadDevice::PointMass(read) => SceneDevice::PointMass(read.device(places)),
            ReadDevice::Pantograph(linkage, position) => {
                let at = position.as_ref().map_or(kind, Spanned::span);
                let position = places.take_or(Of::DevicePosition, position, 0.0);
                let mass = linkage.effective_mass(position);
                let mass = mass.map_err(|error| (at, error.to_string()));
                SceneDevice::Pantograph(PantographDevice {
                    mass: self.or("device", mass, 1.0),
                    linkage,
                    position,
                    encoder_quantum: 0.0,
                    force: 0.0,
                    force_at: HandForceAt::default(),
                })
            }
        }
    }

    /// Adds what is wrong with the scene that was read.
    fn check(&mut self, file: &SceneFile) {
        let (scene, is_whole) = (&file.scene, self.faults.is_empty());
        // The substitute of a faulty value may contradict other values; a range check involves only one number.
        let counts =
            |error: &SceneParameterError| is_whole || matches!(error.allowed, Allowed::Range(_));
        let faults = scene.faults();
        for error in faults.iter().filter(|error| counts(error)) {
            self.faults.push(file.locate_parameter(error));
        }
        let loop_params = scene.loop_params_with_delay();
        let rendered = scene.contact.faults().chain(loop_params.faults());
        let rendered: Vec<_> = rendered.collect();
        for error in &rendered {
            // Model values that equal the true ones have already been rejected at their keys.
            let model = match error.parameter {
                Parameter::Lag => scene.model.lag,
                Parameter::Gain => scene.model.gain,
                Parameter::Delay => None,
                _ => Some(0.0),
            };
            if model.is_none() {
                continue;
            }
            let error = error.map(SceneParameter::Rendered);
            if faults
                .iter()
                .all(|other| other.parameter != error.parameter)
            {
                self.faults.push(file.locate_parameter(&error));
            }
        }
        let is_sound = self.faults.is_empty();
        for method in MethodName::ALL {
            let given = scene.settings.get(&method);
            if method != scene.method && given.is_none() {
                continue;
            }
            match scene.params(method) {
                Err(error) => {
                    if !self.damaged.contains(&format!("methods.{method}")) {
                        self.faults.push(file.locate(method, &error.into()));
                    }
                }
                Ok(params) => {
                    let Err(error) = params.check(&scene.contact, &loop_params) else {
                        continue;
                    };
                    // A default may be derived from an invalid value elsewhere.
                    let is_given = match error.parameter {
                        Parameter::Setting(setting) => {
                            given.is_some_and(|given| given.has(setting.key))
                        }
                        _ => false,
                    };
                    if is_sound || is_given {
                        self.faults.push(file.locate(method, &error.into()));
                    }
                }
            }
        }
    }
}
