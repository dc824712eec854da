//! Worlds, read from a file.

mod contact;
mod refused;
mod render;

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use palpate_core::{Actuation, Hold, LARGEST_DELAY, Range};
use palpate_testbed::actuator::ActuatorParams;
use palpate_world::{
    Body, Contact, Free, IDENTITY, Motion, Shape, World, WorldField as Field, WorldPart,
};
use toml::Spanned;

use super::device::wrong_body_name;
use super::place::WorldPlaces;
use super::shape::{RawShape, unit};
use super::{WorldRender, WorldScene, WorldTiming};
use crate::fault::{Places, SceneError, SceneErrors, Span};
use crate::model::RawModel;
use crate::one_contact::NotOneContact;
use crate::parameter::SceneParameter;
use crate::raw::{RawBody, RawScene};
use crate::scene_file::Tables;
use crate::source::Source;
use crate::timing::RawLoop;
use crate::{lag_question, period_question};

/// Default duration of a world `[s]`.
const DURATION: f64 = 0.5;

/// A world read from a file, with the spans of its parts.
#[derive(Clone, Debug)]
pub struct WorldFile {
    /// The world and its loop.
    pub scene: WorldScene,
    source: Source,
    places: WorldPlaces,
    notes: Vec<String>,
    /// Why it is not one contact along one axis, unless it is.
    not_one_contact: Option<NotOneContact>,
}

impl WorldFile {
    /// Reads any scene as a world, one contact along one axis included, from the text of a file called `name`. Mesh
    /// files are read from that file's folder.
    ///
    /// # Errors
    /// All errors, each with its line, its column and the allowed values.
    pub fn parse(name: &str, source: &str) -> Result<Self, SceneErrors> {
        let folder = Path::new(name).parent().unwrap_or(Path::new(""));
        Self::parse_in(name, source, folder)
    }

    /// Reads any scene as a world with edits, as [`parse`](Self::parse) does.
    ///
    /// # Errors
    /// Those of [`parse`](Self::parse); errors in an edit name its flag.
    pub fn parse_edited(source: &Source) -> Result<Self, SceneErrors> {
        let folder = Path::new(&source.name).parent().unwrap_or(Path::new(""));
        Self::read(source, Tables::read(source)?, folder)
    }

    /// Reads a world whose devices follow a motion that is known otherwise, as [`parse_edited`](Self::parse_edited)
    /// does, but without the traces in the `rest_file` of its hands.
    ///
    /// # Errors
    /// Those of [`parse`](Self::parse).
    pub fn parse_led(source: &Source) -> Result<Self, SceneErrors> {
        let folder = Path::new(&source.name).parent().unwrap_or(Path::new(""));
        let mut tables = Tables::read(source)?;
        for device in &mut tables.raw.device {
            device.get_mut().hand.rest_file = None;
        }
        Self::read(source, tables, folder)
    }

    /// Reads a world from a text that is called `name`. Mesh files are read from `folder`.
    ///
    /// # Errors
    /// Those of [`parse`](Self::parse).
    pub fn parse_in(name: &str, source: &str, folder: &Path) -> Result<Self, SceneErrors> {
        let source = Source::new(name, source);
        Self::read(&source, Tables::read(&source)?, folder)
    }

    /// Reads a world from the tables of its file.
    pub(crate) fn read(
        source: &Source,
        tables: Tables,
        folder: &Path,
    ) -> Result<Self, SceneErrors> {
        let why = tables.raw.one_contact().err();
        let mut reading = Reading {
            places: WorldPlaces::default(),
            faults: tables.faults,
            notes: Vec::new(),
            folder: folder.into(),
            damaged: tables.damaged,
            removed: tables.removed,
        };
        reading.refuse(&tables.raw, why.as_ref());
        reading.refuse_beside_lines(&tables.raw);
        let scene = reading.scene(tables.raw);
        match source.errors(reading.faults) {
            None => Ok(Self {
                scene,
                source: source.clone(),
                places: reading.places,
                notes: reading.notes,
                not_one_contact: why,
            }),
            Some(errors) => Err(errors),
        }
    }

    /// Returns the error where one contact along one axis is needed.
    #[must_use]
    pub fn not_one_contact(&self) -> SceneErrors {
        let why = self.not_one_contact.clone();
        let why = why.unwrap_or_else(|| NotOneContact {
            reason: "it is read as a world".into(),
            span: 0..0,
        });
        why.needed(&self.source)
    }

    /// Returns one line for each mesh that was read from a file: its size and its omitted parts. Further lines report a
    /// world without contacts or bodies, and a period that is probably in milliseconds.
    #[must_use]
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Returns the text of the file with the edits of flags in it.
    ///
    /// # Errors
    /// The edits cannot be written.
    pub fn edited_text(&self) -> Result<String, SceneErrors> {
        self.source.edited_text()
    }

    /// A fault at a field of a part of the world.
    #[must_use]
    pub fn at(&self, place: WorldPart, field: Field, message: String) -> SceneError {
        let span = self.places.of(place, field);
        self.source.error(span, message)
    }
}

/// A partially read world, with its source spans and errors.
pub(crate) struct Reading {
    pub(super) places: WorldPlaces,
    faults: Vec<(Span, String)>,
    /// Notes on meshes, on a world without contacts or bodies, and on its period.
    notes: Vec<String>,
    /// Folder of mesh files.
    pub(super) folder: PathBuf,
    /// Tables that keys at fault were taken out of.
    pub(super) damaged: HashSet<String>,
    /// Keys that were at fault, with those of their tables.
    pub(super) removed: HashSet<String>,
}

impl Reading {
    pub(super) fn fault(&mut self, span: Span, message: impl Into<String>) {
        self.faults.push((span, message.into()));
    }

    fn scene(&mut self, raw: RawScene) -> WorldScene {
        let line = raw.r#loop.hold.clone();
        let line = line.filter(|hold| *hold.get_ref() == Hold::Line);
        let timing = self.timing(raw.r#loop, &raw.model);
        let hold = line.map_or(Hold::Constant, |line| {
            self.places.take(WorldPart::Loop, Field::Actuation, line)
        });
        let mut tools = Vec::new();
        let mut devices = Vec::new();
        for (index, device) in raw.device.into_iter().enumerate() {
            let (tool, device) = self.device(index, device);
            tools.push(tool);
            devices.push(device);
        }
        let bodies = raw.body.into_iter().enumerate();
        let bodies = bodies.map(|(index, body)| self.body(index, body));
        let bodies: Vec<Body> = bodies.collect();
        let contacts = raw.contact.into_iter().enumerate();
        let contacts = contacts.map(|(index, contact)| self.contact(index, contact));
        let contacts: Vec<Contact> = contacts.collect();
        let fields = raw.field.into_iter().enumerate();
        let fields = fields.map(|(index, field)| self.field(index, field));
        let fields: Vec<_> = fields.collect();
        let missing = if contacts.is_empty() {
            Some("[[contact]]")
        } else {
            bodies.is_empty().then_some("[[body]]")
        };
        if let Some(missing) = missing.filter(|_| fields.is_empty()) {
            let note = format!("the world has no {missing}, so nothing in it is felt");
            self.notes.push(note);
        }
        let joints = raw.joint.into_iter().enumerate();
        let joints = joints.map(|(index, joint)| self.joint(index, joint, &bodies));
        let joints = joints.collect();
        let world = World {
            joints,
            fields,
            tools,
            bodies,
            contacts,
        };
        self.check(&world);
        let known = Actuation {
            hold,
            ..self.known_actuation(&timing)
        };
        let render = self.render(raw.render, raw.model, &devices, known);
        let render = WorldRender {
            settings: self.settings(&raw.methods),
            ..render
        };
        let duration = raw.measure.duration_s;
        WorldScene {
            title: raw.title,
            world,
            devices,
            timing,
            render,
            duration: duration.map_or(DURATION, |duration| {
                self.number("duration_s", duration, Range::Positive)
            }),
        }
    }

    /// Returns the timing of the loop. Records the first key of an actuation, the model's or the loop's.
    fn timing(&mut self, raw: RawLoop, model: &RawModel) -> WorldTiming {
        self.places
            .take(WorldPart::Loop, Field::Period, raw.period_s.clone());
        let period = self.number("period_s", raw.period_s.clone(), Range::Positive);
        let question = period_question("loop.period_s", "period_s = 0.001", period);
        self.notes.extend(question);
        let timed = [
            &model.delay_s,
            &model.lag_s,
            &model.gain,
            &raw.delay_s,
            &raw.lag_s,
            &raw.gain,
        ];
        if let Some(delay) = timed.into_iter().flatten().next() {
            self.places
                .take(WorldPart::Loop, Field::Actuation, delay.clone());
        }
        let lag = raw.lag_s.clone();
        let lag = lag.map_or(0.0, |lag| self.number("lag_s", lag, Range::NotNegative));
        (self.notes).extend(lag_question("loop.lag_s", "lag_s = 0.001", lag));
        let gain = raw.gain.clone();
        let gain = gain.map_or(1.0, |gain| self.number("gain", gain, Range::Positive));
        let mut places = Places::<SceneParameter>::default();
        let (delay, imperfections) = raw.timing(&mut places).unwrap_or_else(|(span, message)| {
            self.fault(span, message);
            Default::default()
        });
        if Range::Positive.contains(period)
            && let Err(error) = imperfections.check(period, delay)
            && let Some(span) = places.0.get(&error.parameter)
        {
            self.fault(span.clone(), error.to_string());
        }
        WorldTiming {
            period,
            delay,
            actuator: ActuatorParams { gain, lag },
            imperfections,
        }
    }

    /// Returns the model of the true actuators: without a fraction of a period, which no model knows, and with at most
    /// the longest delay that a renderer models.
    fn known_actuation(&mut self, timing: &WorldTiming) -> Actuation<f64> {
        let known = timing.device_delay();
        let longest = LARGEST_DELAY as f64 * timing.period;
        if known > longest * (1.0 + 1e-9) {
            let note = format!(
                "the renderer models at most {LARGEST_DELAY} periods of delay, {longest} s; the rest of {known} s is \
                 unmodelled"
            );
            self.notes.push(note);
        }
        Actuation {
            delay: known.min(longest),
            lag: timing.actuator.lag,
            gain: timing.actuator.gain,
            ..Actuation::default()
        }
    }

    /// Rejects what is wrong between the parts of a world.
    fn check(&mut self, world: &World) {
        // If a part is missing because its keys are faulty, references to it are not faults.
        let whole = ["device", "body", "contact", "joint"].map(|part| self.damaged.contains(part));
        let errors = if whole.contains(&true) {
            None
        } else {
            world.check().err()
        };
        for error in errors.into_iter().flatten() {
            let span = self.places.of(error.part, error.field);
            // An invalid number has already been reported at its key.
            if !self.faults.iter().any(|(other, _)| *other == span) {
                self.fault(span, error.to_string());
            }
        }
    }

    /// Returns the shape of the item with this name.
    pub(super) fn shape(&mut self, place: WorldPart, name: &str, raw: Spanned<RawShape>) -> Shape {
        self.places.take(place, Field::Shape, raw.clone());
        for (key, length) in raw.get_ref().lengths() {
            // A tool may be a point, or have points.
            let range = match (place, raw.get_ref()) {
                (WorldPart::Tool(_), RawShape::Sphere { .. } | RawShape::Spheres(_)) => {
                    Range::NotNegative
                }
                _ => Range::Positive,
            };
            self.numbers(key, raw.span(), &[length], range);
        }
        let fields = [
            Field::Radius,
            Field::HalfExtents,
            Field::HalfLength,
            Field::Normal,
            Field::Offset,
            Field::Spheres,
            Field::Centre,
        ];
        for field in fields {
            self.places.take(place, field, raw.clone());
        }
        let span = raw.span();
        match raw.into_inner().shape(&self.folder) {
            Ok(read) => {
                let note = read.note.map(|note| format!("{name}, {note}"));
                self.notes.extend(note);
                read.shape
            }
            Err(message) => {
                // A shape with a removed key has already been reported.
                let table = match place {
                    WorldPart::Tool(number) => format!("device.{number}.tool"),
                    WorldPart::Body(number) => format!("body.{number}.shape"),
                    _ => String::new(),
                };
                if !self
                    .damaged
                    .iter()
                    .any(|damaged| damaged.starts_with(&table))
                {
                    self.fault(span, message);
                }
                // For what else there is to find; the file is refused.
                Shape::Sphere { radius: 1.0 }
            }
        }
    }

    fn body(&mut self, index: usize, raw: Spanned<RawBody>) -> Body {
        let place = WorldPart::Body(index);
        let span = raw.span();
        self.places.part(place, span.clone());
        let raw = raw.into_inner();
        if raw.fixed {
            for (key, span) in raw.keys_of_motion() {
                if let Some(span) = span {
                    let way_out = if key.contains("velocity") {
                        "; a body of a large mass keeps its velocity (mass_kg = 1e6 instead of fixed)"
                    } else {
                        ""
                    };
                    self.fault(span, format!("a fixed body has no {key}{way_out}"));
                }
            }
        }
        let motion = match (raw.fixed, raw.mass_kg) {
            (false, Some(mass)) => {
                let free = Free {
                    mass: self.places.take(place, Field::Mass, mass),
                    inertia: raw
                        .inertia_kg_m2
                        .map(|inertia| self.places.take(place, Field::Inertia, inertia)),
                    velocity: self.vector("velocity_m_per_s", raw.velocity_m_per_s, [0.0; 3]),
                    angular_velocity: self.vector(
                        "angular_velocity_rad_per_s",
                        raw.angular_velocity_rad_per_s,
                        [0.0; 3],
                    ),
                    force: self.vector("force_n", raw.force_n, [0.0; 3]),
                };
                Motion::Free(free)
            }
            (true, _) => Motion::Fixed,
            // It has been refused, or the file has other faults.
            (false, _) if raw.axes.is_some() => Motion::Fixed,
            (false, None) => {
                // A key that was at fault may have been meant to be one of these.
                if !self.damaged.contains(&format!("body.{index}")) {
                    let message = "a body needs either mass_kg or fixed = true";
                    self.fault(span, message);
                }
                Motion::Fixed
            }
        };
        let orientation = raw.orientation.map_or(IDENTITY, |orientation| {
            let orientation = self.places.take(place, Field::Orientation, orientation);
            unit(orientation)
        });
        if let Some(message) = wrong_body_name(raw.name.get_ref()) {
            self.fault(raw.name.span(), message);
        }
        let name = self.places.take(place, Field::Name, raw.name);
        Body {
            shape: self.shape(place, &name, raw.shape),
            name,
            position: self.vector("position_m", raw.position_m, [0.0; 3]),
            orientation,
            motion,
        }
        // Its place is that of the mesh's origin, wherever the centre of mass is.
        .balanced()
    }
}
