//! The device of a device report: its name, and its known properties with their sources.

use super::file_name;
use crate::calibrate::Quantity;
use palpate_record::recording::Recording;
use palpate_scene::{Scene, SceneDevice};
use serde::Serialize;

use super::{CardError, Sources};
use crate::recording::report::model;
use crate::recording::scene_of;

/// Name of the simulated device in metadata.
const SIMULATED: &str = "simulated";

/// A device and its known properties.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct DeviceCard {
    /// Name of the device.
    pub name: String,
    /// Source of the name.
    pub name_from: String,
    /// Whether the device is simulated.
    pub is_simulated: bool,
    /// Whether its motors hold their last force without new commands; none if unknown.
    pub holds_last_force: Option<bool>,
    /// Known properties.
    pub numbers: Vec<NumberCard>,
    /// Stiffness in the scene of the first recording `[N/m]`.
    #[serde(skip)]
    pub stiffness_of_scene: Option<f64>,
}

/// A property with its source.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct NumberCard {
    /// Name of the property, with its unit.
    pub key: &'static str,
    /// Value in that unit.
    pub value: f64,
    /// Standard deviation in that unit; none if unknown.
    pub standard_deviation: Option<f64>,
    /// Source of the value.
    pub source: String,
}

/// Metadata of a recording on its device.
struct RecordingMetadata<'a> {
    recording: &'a Recording,
    device: toml::Table,
}

impl<'a> RecordingMetadata<'a> {
    fn of(recording: &'a Recording) -> Self {
        let text = recording.metadata.texts.get("device");
        let device = text.and_then(|text| text.parse().ok()).unwrap_or_default();
        Self { recording, device }
    }

    fn name(&self) -> Option<&str> {
        self.device.get("name")?.as_str()
    }

    /// Returns the metadata value `from` as the property `key`: metadata and device files use different names for the
    /// quantum.
    fn number(&self, from: &str, key: &'static str) -> Option<NumberCard> {
        let value = self.device.get(from)?;
        let value = value
            .as_float()
            .or_else(|| value.as_integer().map(|whole| whole as f64))?;
        self.said(key, value, "the device, in")
    }

    fn said(&self, key: &'static str, value: f64, what: &str) -> Option<NumberCard> {
        value.is_finite().then(|| NumberCard {
            key,
            value,
            standard_deviation: None,
            source: format!("{what} {}", file_name(self.recording.path())),
        })
    }
}

impl DeviceCard {
    /// Creates the device that all sources describe.
    pub(super) fn new(sources: &Sources<'_>) -> Result<Self, CardError> {
        let metadata: Vec<RecordingMetadata<'_>> = sources
            .recordings
            .iter()
            .map(RecordingMetadata::of)
            .collect();
        refuse_several(&metadata)?;
        let first = metadata.first();
        let named = first.and_then(|metadata| metadata.name());
        let (name, name_from) = name_of(sources, first);
        let scene = first.and_then(|metadata| scene_of(metadata.recording).ok());
        let scene = scene.map(|file| file.scene);
        let is_simulated = named == Some(SIMULATED);
        let found = Found {
            sources,
            first,
            scene: scene.as_ref(),
            is_simulated,
        };
        let numbers = found.numbers();
        let holds = first.and_then(|metadata| metadata.device.get("holds_last_force")?.as_bool());
        Ok(Self {
            name,
            name_from,
            is_simulated,
            holds_last_force: holds,
            numbers,
            stiffness_of_scene: scene.map(|scene| scene.contact.stiffness),
        })
    }

    /// Returns the value of a property in the unit of its key, if known.
    #[must_use]
    pub fn value(&self, key: &str) -> Option<f64> {
        self.number(key).map(|number| number.value)
    }

    /// Returns a property, if known.
    #[must_use]
    pub fn number(&self, key: &str) -> Option<&NumberCard> {
        self.numbers.iter().find(|number| number.key == key)
    }
}

/// Returns the name of the device and the source of the name.
fn name_of(sources: &Sources<'_>, first: Option<&RecordingMetadata<'_>>) -> (String, String) {
    let named = first.and_then(|metadata| metadata.name());
    match (sources.name, named, sources.device_file) {
        (Some(name), ..) => (name.to_owned(), "--name".to_owned()),
        (None, Some(name), _) => {
            let path = first.map(|metadata| file_name(metadata.recording.path()));
            (name.to_owned(), path.unwrap_or_default())
        }
        (None, None, Some((path, _))) => (format!("device of {path}"), path.to_owned()),
        (None, None, None) => ("unnamed device".into(), "no --name was given".into()),
    }
}

/// Sources of the properties of a device.
struct Found<'a> {
    sources: &'a Sources<'a>,
    /// Metadata of the first recording.
    first: Option<&'a RecordingMetadata<'a>>,
    /// Scene of the first recording.
    scene: Option<&'a Scene>,
    is_simulated: bool,
}

impl Found<'_> {
    /// Returns the known properties, each from its best source.
    fn numbers(&self) -> Vec<NumberCard> {
        let first = self.first;
        let mut numbers = Vec::new();
        let mut put = |number: Option<NumberCard>| numbers.extend(number);
        put(self
            .given_period()
            .or_else(|| self.period_of_scene())
            .or_else(|| self.of_file(Quantity::Period)));
        put(self
            .of_file(Quantity::DeviceMass)
            .or_else(|| self.of_model("device_mass_kg")));
        let delay = self.of_file(Quantity::Delay).or_else(|| {
            // If only the sum of delay and lag is known, the sum is the better delay.
            Some(NumberCard {
                key: Quantity::Delay.key(),
                ..self.of_file(Quantity::DelayPlusLag)?
            })
        });
        let of_a_file = delay.is_some();
        put(delay.or_else(|| self.of_model("delay_s")));
        put(self
            .of_file(Quantity::Lag)
            .or_else(|| self.of_model("lag_s").filter(|_| !of_a_file)));
        put(self
            .of_file(Quantity::Gain)
            .or_else(|| self.of_model("gain")));
        put(self.of_file(Quantity::ViscousFriction).or_else(|| {
            self.of_simulated(Quantity::ViscousFriction.key(), |device| {
                device.viscous_friction()
            })
        }));
        put(self.of_file(Quantity::CoulombFriction).or_else(|| {
            self.of_simulated(Quantity::CoulombFriction.key(), |device| {
                device.coulomb_friction()
            })
        }));
        put(self
            .of_file(Quantity::SensorQuantum)
            .or_else(|| first?.number("encoder_quantum_m", Quantity::SensorQuantum.key()))
            .or_else(|| {
                self.of_simulated(Quantity::SensorQuantum.key(), |device| {
                    device.encoder_quantum()
                })
            }));
        put(self.of_file(Quantity::Resonance));
        put(first.and_then(|metadata| metadata.number("largest_force_n", "largest_force_n")));
        numbers
    }

    /// Returns the stated period.
    fn given_period(&self) -> Option<NumberCard> {
        self.sources.period.map(|value| NumberCard {
            key: "period_s",
            value,
            standard_deviation: None,
            source: "--period".into(),
        })
    }

    /// Returns the period of the scene of the first recording.
    fn period_of_scene(&self) -> Option<NumberCard> {
        let period = self.scene?.loop_params.period;
        self.first?.said("period_s", period, "the scene of")
    }

    /// Returns a quantity of the device file.
    fn of_file(&self, quantity: Quantity) -> Option<NumberCard> {
        let (path, calibration) = self.sources.device_file?;
        let known = calibration.known.get(&quantity)?;
        Some(NumberCard {
            key: quantity.key(),
            value: known.value,
            standard_deviation: known.standard_deviation,
            source: format!("device file {path}"),
        })
    }

    /// Returns a value of the renderer's model in the first recording.
    fn of_model(&self, key: &'static str) -> Option<NumberCard> {
        let metadata = self.first?;
        let value = *model(metadata.recording).get(key)?;
        metadata.said(key, value, "the renderer's model in")
    }

    /// Returns a property of the simulated device, if the device is simulated.
    fn of_simulated(
        &self,
        key: &'static str,
        value: fn(&SceneDevice) -> f64,
    ) -> Option<NumberCard> {
        let scene = self.scene.filter(|_| self.is_simulated)?;
        self.first?
            .said(key, value(&scene.device), "the simulated device of")
    }
}

fn refuse_several(metadata: &[RecordingMetadata<'_>]) -> Result<(), CardError> {
    let mut named = metadata
        .iter()
        .filter_map(|metadata| Some((file_name(metadata.recording.path()), metadata.name()?)));
    let Some((first, of_first)) = named.next() else {
        return Ok(());
    };
    match named.find(|(_, name)| *name != of_first) {
        None => Ok(()),
        Some((other, of_other)) => Err(CardError::SeveralDevices {
            first: first.to_string(),
            of_first: of_first.to_owned(),
            other: other.to_string(),
            of_other: of_other.to_owned(),
        }),
    }
}
