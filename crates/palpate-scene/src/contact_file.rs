//! Scenes of one contact along one axis, read from a file.

use std::collections::{HashMap, HashSet};
use std::io;
use std::ops;

use palpate_core::{Allowed, Contact, Hold, MethodParams as _, Parameter, Range};
use palpate_world::{Vector, out_of_range};
use toml::Spanned;

use super::beside::Files;
use super::check::SceneParameterError;
use super::delay::Delay;
use super::device_key::RawDevice;
use super::fault::{Places, SceneError, SceneErrors};
use super::one_contact::OneAxis;
use super::parameter::SceneParameter::{self, self as Of};
use super::raw::{RawBody, RawContact, RawMeasure, RawScene};
use super::raw_settings::{MethodPlaces, RawSettings};
use super::recover::Fault;
use super::scene_file::Tables;
use super::source::Source;
use super::timing::Timing;
use super::{Measure, Scene, SetupError};
use crate::method::{MethodName, Setting, Settings, SettingsError, UnknownMethod, method_named};
use crate::model::RawModel;
use crate::render_key::{RawGuard, RawRender};
use crate::world::WorldScene;
use crate::world::device::{wrong_body_name, wrong_device_name};
use crate::world::per_axis::PerAxis;

/// Default duration `[s]`.
const DURATION: f64 = 0.5;

/// A scene of one contact along one axis, read from a file, with the spans of its values.
#[derive(Clone, Debug)]
pub struct ContactFile {
    /// The scene.
    pub scene: Scene,
    source: Source,
    places: HashMap<SceneParameter, ops::Range<usize>>,
    methods: HashMap<MethodName, MethodPlaces>,
}

impl ContactFile {
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
    /// column and the allowed values. A scene with more than one contact along one axis.
    pub fn parse_with(name: &str, source: &str, files: Files<'_>) -> Result<Self, SceneErrors> {
        Self::parse_edited(&Source::new(name, source), files)
    }

    /// Reads a scene with edits, as [`parse_with`](Self::parse_with) does.
    ///
    /// # Errors
    /// Those of [`parse_with`](Self::parse_with); errors in an edit name its flag.
    pub fn parse_edited(source: &Source, files: Files<'_>) -> Result<Self, SceneErrors> {
        let tables = Tables::read(source)?;
        match tables.raw.one_contact() {
            Ok(axis) => Self::read(source, tables, axis, files),
            Err(why) => Err(source
                .errors(tables.faults)
                .unwrap_or_else(|| why.needed(source))),
        }
    }

    /// Reads a scene of one contact from the tables of its file.
    pub(crate) fn read(
        source: &Source,
        tables: Tables,
        axis: OneAxis,
        files: Files<'_>,
    ) -> Result<Self, SceneErrors> {
        let mut reading = Reading {
            source,
            axis,
            faults: Vec::new(),
            damaged: tables.damaged,
        };
        for fault in tables.faults {
            reading.fault(fault);
        }
        let file = reading.scene(tables.raw, files);
        reading.check(&file);
        match SceneErrors::new(reading.faults) {
            None => Ok(file),
            Some(errors) => Err(errors),
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
            SetupError::HoldsConstant(_) => self.at(Parameter::HoldOrder.into(), error.to_string()),
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
    ) -> Option<(ops::Range<usize>, ops::Range<usize>)> {
        let places = &self.methods.get(&method)?.settings;
        places.get(setting.key.as_str()).cloned()
    }

    fn place_of_method(&self, method: MethodName) -> Option<ops::Range<usize>> {
        Some(self.methods.get(&method)?.name.clone())
    }

    fn at_span(&self, span: Option<ops::Range<usize>>, message: String) -> SceneError {
        self.source.error(span.unwrap_or(0..0), message)
    }
}

/// A partially read scene file with its errors.
pub(crate) struct Reading<'a> {
    pub source: &'a Source,
    pub axis: OneAxis,
    pub faults: Vec<SceneError>,
    /// Tables that keys at fault were taken out of.
    damaged: HashSet<String>,
}

impl Reading<'_> {
    pub fn fault(&mut self, (span, message): Fault) {
        let fault = self.source.error(span, message);
        self.faults.push(fault);
    }

    /// Returns the value that was read from keys of `table`. On a fault, records it and returns `instead` so that
    /// reading continues.
    pub fn or<T>(&mut self, table: &str, read: Result<T, Fault>, instead: T) -> T {
        read.unwrap_or_else(|fault| {
            self.in_table(table, fault);
            instead
        })
    }

    /// A fault of several keys of a `table`; none where one of them has been at fault by itself.
    pub fn in_table(&mut self, table: &str, fault: Fault) {
        if !self.damaged.contains(table) {
            self.fault(fault);
        }
    }

    /// Rejects the keys that are given and that a scene of one contact lacks.
    pub fn refuse(&mut self, keys: &[(&str, Option<ops::Range<usize>>)], why: &str) {
        for (key, span) in keys {
            if let Some(span) = span {
                self.fault((span.clone(), format!("{key} {why}")));
            }
        }
    }

    /// Returns the component of a vector along the axis. Rejects components along other axes than those of `held`.
    pub fn along(
        &mut self,
        key: &str,
        value: Option<Spanned<Vector>>,
        held: Vector,
    ) -> Option<Spanned<f64>> {
        let value = value?;
        if let Some(message) = self.axis.axes.refused(key, *value.get_ref(), held) {
            self.fault((value.span(), message));
        }
        Some(Spanned::new(
            value.span(),
            self.axis.along(*value.get_ref()),
        ))
    }

    /// Returns the component of a position along the axis `[m]`; the others have no effect.
    pub fn place(&mut self, key: &str, value: Option<Spanned<Vector>>) -> Option<Spanned<f64>> {
        let value = value?;
        if let Some(part) = value.get_ref().iter().find(|part| !part.is_finite()) {
            self.fault((
                value.span(),
                format!("{key} is {part} m, but must be finite"),
            ));
        }
        Some(Spanned::new(
            value.span(),
            self.axis.along(*value.get_ref()),
        ))
    }

    fn scene(&mut self, raw: RawScene, files: Files<'_>) -> ContactFile {
        let mut places = Places::default();
        let measure = self.measure(raw.measure, &mut places);
        let (settings, methods) = self.settings(&raw.methods);
        let method = self.method(raw.render.method.as_ref());
        let (mut body, mut contact) = (raw.body.into_iter(), raw.contact.into_iter());
        let mut device = raw.device.into_iter();
        // The rule of one contact has counted them.
        let (Some(body), Some(contact), Some(device)) =
            (body.next(), contact.next(), device.next())
        else {
            unreachable!("a scene of one contact has one of each")
        };
        self.check_unused(body.get_ref(), device.get_ref(), contact.get_ref());
        let body = self.body(body, &mut places);
        let contact = Contact {
            side: body.side,
            unilateral: raw
                .render
                .unilateral
                .as_ref()
                .is_some_and(|only| *only.get_ref()),
            ..Contact::object(
                places.take(Parameter::Stiffness, contact.into_inner().stiffness_n_per_m),
                body.mass,
            )
        };
        let device = self.held_device(device, &mut places, files);
        let period = places.take(Parameter::Period, raw.r#loop.period_s.clone());
        let actuator = raw.r#loop.actuator(&mut places);
        let hold = raw.r#loop.hold.clone();
        if let Some(alone) = raw.model.alone() {
            self.in_table("model", alone);
        }
        let model = raw.model.read(&mut places);
        let model_device_mass = self.model_device_mass(&raw.model, device.mass(), &mut places);
        let timing = raw.r#loop.timing(&mut places);
        let timing = timing.map_err(|(span, message)| (span, message.to_owned()));
        let (delay, timing) = self.or("loop", timing, (Delay::NONE, Timing::default()));
        self.refuse_torque(&raw.render);
        let mut loop_params = raw.render.of_one_contact(period, &mut places);
        loop_params.actuation.hold = places.take_or(Parameter::HoldOrder, hold, Hold::Constant);
        let scene = Scene {
            title: raw.title,
            contact,
            loop_params,
            object: body.state,
            object_radius: body.radius,
            virtual_force: body.force,
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
        ContactFile {
            scene,
            source: self.source.clone(),
            places: places.0,
            methods,
        }
    }

    /// Rejects names, and friction keys of a contact without friction, that are wrong although nothing depends on them.
    fn check_unused(&mut self, body: &RawBody, device: &RawDevice, contact: &RawContact) {
        for (name, wrong) in [
            (&body.name, wrong_body_name(body.name.get_ref())),
            (&device.name, wrong_device_name(device.name.get_ref())),
        ] {
            if let Some(message) = wrong {
                self.fault((name.span(), message.into()));
            }
        }
        let (stiffness, damping) = (
            &contact.friction_stiffness_n_per_m,
            &contact.friction_damping_n_s_per_m,
        );
        for (key, value, range) in [
            ("friction_stiffness_n_per_m", stiffness, Range::Positive),
            ("friction_damping_n_s_per_m", damping, Range::NotNegative),
        ] {
            if let Some(value) = value
                && let Some(message) = out_of_range(key, *value.get_ref(), range)
            {
                self.fault((value.span(), message));
            }
        }
    }

    /// Rejects limits of torque and turning, which one axis lacks, and bounds of a hand that is not given.
    fn refuse_torque(&mut self, render: &RawRender) {
        let guard = render.guard.as_ref();
        let span = |value: &Option<Spanned<f64>>| value.as_ref().map(Spanned::span);
        let of_guard =
            |key: fn(&RawGuard) -> &Option<Spanned<f64>>| guard.and_then(|guard| span(key(guard)));
        let keys = [
            (
                "render.torque_limit_n_m",
                render.torque_limit_n_m.as_ref().map(Spanned::span),
            ),
            (
                "render.guard.turning_rad_per_s",
                of_guard(|guard| &guard.turning_rad_per_s),
            ),
            (
                "render.guard.turning_acceleration_rad_per_s2",
                of_guard(|guard| &guard.turning_acceleration_rad_per_s2),
            ),
            (
                "render.guard.hand_torque_n_m",
                of_guard(|guard| &guard.hand_torque_n_m),
            ),
            (
                "render.guard.least_inertia_kg_m2",
                of_guard(|guard| &guard.least_inertia_kg_m2),
            ),
        ];
        self.refuse(&keys, "needs a device of six axes, with inertia_kg_m2");
        let hand = guard.map(|guard| (&guard.acceleration_m_per_s2, &guard.hand_force_n));
        match hand {
            Some((None, None)) => {
                let learned = guard.and_then(|guard| guard.learn_mass.as_ref());
                let keys = [
                    (
                        "render.guard.least_mass_kg",
                        of_guard(|guard| &guard.least_mass_kg),
                    ),
                    ("render.guard.learn_mass", learned.map(Spanned::span)),
                ];
                self.refuse(&keys, "needs acceleration_m_per_s2 or hand_force_n");
            }
            Some((Some(_), force)) => {
                let keys = [("render.guard.hand_force_n", span(force))];
                self.refuse(&keys, "excludes acceleration_m_per_s2; remove one");
            }
            _ => {}
        }
    }

    /// Returns the device mass of the renderer's model `[kg]`, if it differs from `mass` `[kg]`.
    fn model_device_mass(
        &mut self,
        model: &RawModel,
        mass: f64,
        places: &mut Places<SceneParameter>,
    ) -> Option<f64> {
        let inertia = model.device_inertia_kg_m2.as_ref().map(Spanned::span);
        let keys = [("model.device_inertia_kg_m2", inertia)];
        self.refuse(&keys, "needs a device of six axes, with inertia_kg_m2");
        let given = model.device_mass_kg.as_ref();
        let given = given.and_then(|mass| self.one_number("model.device_mass_kg", mass));
        let given = given.map(|mass| places.take(Of::ModelDeviceMass, mass));
        let Some(factor) = model.device_mass_factor.clone() else {
            return given;
        };
        if given.is_some() {
            let message = "give either device_mass_kg or device_mass_factor, not both";
            self.fault((factor.span(), message.into()));
        }
        Some(mass * places.take(Of::ModelDeviceMass, factor))
    }

    /// Returns the number under a key that may have one for each axis of a device.
    pub fn one_number(&mut self, key: &str, value: &Spanned<PerAxis>) -> Option<Spanned<f64>> {
        if let [number] = value.get_ref().given() {
            return Some(Spanned::new(value.span(), *number));
        }
        let message = format!(
            "{key} has {} numbers, but the device has 1 axis; give one number",
            value.get_ref().given().len()
        );
        self.fault((value.span(), message));
        None
    }

    /// Returns what `[measure]` gives; the default duration for neither of its keys or both.
    fn measure(&mut self, raw: RawMeasure, places: &mut Places<SceneParameter>) -> Measure {
        match (raw.collisions, raw.duration_s) {
            (Some(count), None) => Measure::Collisions(places.take(Of::Collisions, count)),
            (None, Some(duration)) => Measure::Duration(places.take(Of::Duration, duration)),
            (None, None) => Measure::Duration(DURATION),
            (Some(_), Some(duration)) => {
                let message = "[measure] has either collisions or duration_s, not both";
                self.fault((duration.span(), message.into()));
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
                Err(error) => {
                    self.fault((given.span(), not_of_one_contact(given.get_ref(), &error)))
                }
            }
        }
        method
    }

    /// Settings of the methods that the file names, and where it does.
    fn settings(
        &mut self,
        raw: &HashMap<Spanned<String>, RawSettings>,
    ) -> (
        HashMap<MethodName, Settings>,
        HashMap<MethodName, MethodPlaces>,
    ) {
        let (mut settings, mut places) = (HashMap::new(), HashMap::new());
        for (name, given) in raw {
            match method_named(name.get_ref()) {
                Ok(method) => {
                    let (of_method, faults) = given.of_one_contact();
                    if !faults.is_empty() {
                        self.damaged.insert(format!("methods.{method}"));
                    }
                    for fault in faults {
                        self.fault(fault);
                    }
                    places.insert(method, given.places(name.span()));
                    settings.insert(method, of_method);
                }
                Err(error) => self.fault((name.span(), not_of_one_contact(name.get_ref(), &error))),
            }
        }
        (settings, places)
    }

    /// Adds what is wrong with the scene that was read.
    fn check(&mut self, file: &ContactFile) {
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

/// Returns the error message for a name of a method that cannot render one contact.
fn not_of_one_contact(name: &str, error: &UnknownMethod) -> String {
    if WorldScene::METHODS.contains(&name) {
        return format!(
            "{name} renders worlds; this scene has one contact along one axis, which the closed form renders"
        );
    }
    error.to_string()
}
