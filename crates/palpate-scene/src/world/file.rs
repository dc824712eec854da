//! Scene files of format 2.

mod contact;
mod render;

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use palpate_core::Range;
use palpate_world::{
    Body, Contact, Free, IDENTITY, Motion, Quaternion, Shape, Vector, World, WorldField as Field,
    WorldPart,
};
use serde::Deserialize;
use toml::Spanned;
use toml::de::DeTable;

use self::contact::RawContact;
use self::render::RawRender;
use super::device::RawDevice;
use super::joint::RawJoint;
use super::place::WorldPlaces;
use super::shape::{RawShape, unit};
use super::{WorldActuator, WorldScene, WorldTiming};
use crate::fault::{SceneError, SceneErrors, Span};
use crate::{period_question, recover};

/// Format version of scene files that describe a world.
pub(crate) const WORLD_FORMAT: i64 = 2;
/// Default duration of a world `[s]`.
const DURATION: f64 = 0.5;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawFile {
    format: Spanned<i64>,
    #[serde(default)]
    title: String,
    r#loop: RawLoop,
    #[serde(default)]
    device: Vec<Spanned<RawDevice>>,
    #[serde(default)]
    body: Vec<Spanned<RawBody>>,
    #[serde(default)]
    contact: Vec<Spanned<RawContact>>,
    #[serde(default)]
    joint: Vec<Spanned<RawJoint>>,
    #[serde(default)]
    render: RawRender,
    #[serde(default)]
    model: RawModel,
    #[serde(default)]
    measure: RawMeasure,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawLoop {
    period_s: Spanned<f64>,
    delay_s: Option<Spanned<f64>>,
    lag_s: Option<Spanned<f64>>,
    gain: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawBody {
    name: Spanned<String>,
    #[serde(default)]
    fixed: bool,
    mass_kg: Option<Spanned<f64>>,
    inertia_kg_m2: Option<Spanned<Vector>>,
    position_m: Option<Spanned<Vector>>,
    orientation: Option<Spanned<Quaternion>>,
    velocity_m_per_s: Option<Spanned<Vector>>,
    angular_velocity_rad_per_s: Option<Spanned<Vector>>,
    force_n: Option<Spanned<Vector>>,
    shape: Spanned<RawShape>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct RawModel {
    delay_s: Option<Spanned<f64>>,
    lag_s: Option<Spanned<f64>>,
    gain: Option<Spanned<f64>>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct RawMeasure {
    duration_s: Option<Spanned<f64>>,
}

/// A world read from a file, with the spans of its parts.
#[derive(Clone, Debug)]
pub struct WorldFile {
    /// The world and its loop.
    pub scene: WorldScene,
    name: String,
    source: String,
    places: WorldPlaces,
    notes: Vec<String>,
}

impl WorldFile {
    /// Whether the text of a file has the key `format`, and so is a world, of whatever format; `false` too where it is
    /// no TOML. A scene of one contact has `scene_format`.
    #[must_use]
    pub fn is_world_file(source: &str) -> bool {
        DeTable::parse(source).is_ok_and(|table| {
            let has = |key: &str| table.get_ref().keys().any(|name| name.get_ref() == key);
            has("format") && !has("scene_format")
        })
    }

    /// Returns whether the text of a file has bodies or several devices, as a world has, but no format.
    pub(crate) fn lacks_its_format(source: &str) -> bool {
        DeTable::parse(source).is_ok_and(|table| {
            let is_list = |key: &str| {
                let entry = table
                    .get_ref()
                    .iter()
                    .find(|(name, _)| name.get_ref() == key);
                entry.is_some_and(|(_, value)| value.get_ref().is_array())
            };
            let says = table.get_ref().keys().any(|name| {
                let name: &str = name.get_ref();
                name == "format" || name == "scene_format"
            });
            !says && (is_list("device") || is_list("body"))
        })
    }

    /// Reads a world from the text of a file called `name`. Mesh files are read from that file's folder.
    ///
    /// # Errors
    /// All errors, each with its line, its column and the allowed values.
    pub fn parse(name: &str, source: &str) -> Result<Self, SceneErrors> {
        let folder = Path::new(name).parent().unwrap_or(Path::new(""));
        Self::parse_in(name, source, folder)
    }

    /// Reads a world from a text that is called `name`. Mesh files are read from `folder`.
    ///
    /// # Errors
    /// Those of [`parse`](Self::parse).
    pub fn parse_in(name: &str, source: &str, folder: &Path) -> Result<Self, SceneErrors> {
        let left = recover::read::<RawFile>(source);
        let mut reading = Reading {
            places: WorldPlaces::default(),
            faults: left.faults,
            notes: Vec::new(),
            folder: folder.into(),
            damaged: left.damaged,
            removed: left.removed,
        };
        let scene = left.read.map(|raw| reading.scene(raw));
        let at = |(span, message)| SceneError::at(name, source, span, message);
        match (
            SceneErrors::new(reading.faults.into_iter().map(at).collect()),
            scene,
        ) {
            (None, Some(scene)) => Ok(Self {
                scene,
                name: name.into(),
                source: source.into(),
                places: reading.places,
                notes: reading.notes,
            }),
            (Some(errors), _) => Err(errors),
            (None, None) => unreachable!("an unreadable file has a fault"),
        }
    }

    /// Returns one line for each mesh that was read from a file: its size and its omitted parts. Further lines report a
    /// world without contacts or bodies, and a period that is probably in milliseconds.
    #[must_use]
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// A fault at a field of a part of the world.
    #[must_use]
    pub fn at(&self, place: WorldPart, field: Field, message: String) -> SceneError {
        let span = self.places.of(place, field);
        SceneError::at(&self.name, &self.source, span, message)
    }
}

/// A partially read world, with its source spans and errors.
pub(super) struct Reading {
    pub(super) places: WorldPlaces,
    faults: Vec<(Span, String)>,
    /// Notes on meshes, on a world without contacts or bodies, and on its period.
    notes: Vec<String>,
    /// Folder of mesh files.
    folder: PathBuf,
    /// Tables that keys at fault were taken out of.
    pub(super) damaged: HashSet<String>,
    /// Keys that were at fault, with those of their tables.
    pub(super) removed: HashSet<String>,
}

impl Reading {
    pub(super) fn fault(&mut self, span: Span, message: impl Into<String>) {
        self.faults.push((span, message.into()));
    }

    fn scene(&mut self, raw: RawFile) -> WorldScene {
        self.check_format(&raw.format);
        let timing = self.timing(raw.r#loop, &raw.model);
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
        if contacts.is_empty() {
            let note = "the world has no [[contact]], so nothing in it is felt".into();
            self.notes.push(note);
        } else if bodies.is_empty() {
            let note = "the world has no [[body]], so nothing in it is felt".into();
            self.notes.push(note);
        }
        let joints = raw.joint.into_iter().enumerate();
        let joints = joints.map(|(index, joint)| self.joint(index, joint, &bodies));
        let joints = joints.collect();
        let world = World {
            joints,
            tools,
            bodies,
            contacts,
        };
        self.check(&world);
        let render = self.render(raw.render, raw.model, &devices, timing.actuator);
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

    /// Rejects another version than that of worlds.
    fn check_format(&mut self, format: &Spanned<i64>) {
        if *format.get_ref() != WORLD_FORMAT {
            let given = format.get_ref();
            let message = format!(
                "format is {given}; a world with [[device]] and [[body]] needs {WORLD_FORMAT}"
            );
            self.fault(format.span(), message);
        }
    }

    /// Returns period and actuators of the loop. Records the first key of an actuation, the model's or the loop's.
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
        let RawLoop {
            delay_s,
            lag_s,
            gain,
            ..
        } = raw;
        let perfect = WorldActuator {
            delay: 0.0,
            lag: 0.0,
            gain: 1.0,
        };
        let actuator = self.actuator([delay_s, lag_s, gain], perfect);
        WorldTiming { period, actuator }
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

    /// Returns delay, lag and gain, each with a default from `otherwise`.
    fn actuator(
        &mut self,
        [delay, lag, gain]: [Option<Spanned<f64>>; 3],
        otherwise: WorldActuator,
    ) -> WorldActuator {
        let mut or = |key, value: Option<Spanned<f64>>, otherwise, range| {
            value.map_or(otherwise, |value| self.number(key, value, range))
        };
        WorldActuator {
            delay: or("delay_s", delay, otherwise.delay, Range::NotNegative),
            lag: or("lag_s", lag, otherwise.lag, Range::NotNegative),
            gain: or("gain", gain, otherwise.gain, Range::Positive),
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
        let moves = [
            (
                "inertia_kg_m2",
                raw.inertia_kg_m2.as_ref().map(Spanned::span),
            ),
            (
                "velocity_m_per_s",
                raw.velocity_m_per_s.as_ref().map(Spanned::span),
            ),
            (
                "angular_velocity_rad_per_s",
                raw.angular_velocity_rad_per_s.as_ref().map(Spanned::span),
            ),
            ("force_n", raw.force_n.as_ref().map(Spanned::span)),
        ];
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
            (true, None) => {
                for (key, span) in moves {
                    if let Some(span) = span {
                        self.fault(span, format!("a fixed body has no {key}"));
                    }
                }
                Motion::Fixed
            }
            (true, Some(mass)) => {
                self.fault(mass.span(), "a fixed body has no mass_kg");
                Motion::Fixed
            }
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
        if raw.name.get_ref().contains(char::is_control) {
            let message = "a body's name must have no control character";
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
