//! The device of a device report: its name, and its known properties with their sources.

use super::file_name;
use crate::calibrate::Quantity;
use palpate_record::recording::Recording;
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
        let (name, name_from) = match (sources.name, named, sources.device_file) {
            (Some(name), ..) => (name.to_owned(), "--name".to_owned()),
            (None, Some(name), _) => {
                let path = first.map(|metadata| file_name(metadata.recording.path()));
                (name.to_owned(), path.unwrap_or_default())
            }
            (None, None, Some((path, _))) => (format!("device of {path}"), path.to_owned()),
            (None, None, None) => ("unnamed device".into(), "no --name was given".into()),
        };
        let mut numbers = Vec::new();
        let mut put = |number: Option<NumberCard>| numbers.extend(number);
        let of_file = |quantity: Quantity| {
            let (path, calibration) = sources.device_file?;
            let known = calibration.known.get(&quantity)?;
            Some(NumberCard {
                key: quantity.key(),
                value: known.value,
                standard_deviation: known.standard_deviation,
                source: format!("device file {path}"),
            })
        };
        let model_value = |key: &'static str| {
            let metadata = first?;
            let value = *model(metadata.recording).get(key)?;
            metadata.said(key, value, "the renderer's model in")
        };
        let scene = first.and_then(|metadata| scene_of(metadata.recording).ok());
        let scene = scene.map(|file| file.scene);
        let period_of_scene = || {
            let period = scene.as_ref()?.loop_params.period;
            first?.said("period_s", period, "the scene of")
        };
        put(sources
            .period
            .map(|value| NumberCard {
                key: "period_s",
                value,
                standard_deviation: None,
                source: "--period".into(),
            })
            .or_else(period_of_scene)
            .or_else(|| of_file(Quantity::Period)));
        put(of_file(Quantity::DeviceMass).or_else(|| model_value("device_mass_kg")));
        let delay = of_file(Quantity::Delay).or_else(|| {
            // If only the sum of delay and lag is known, the sum is the better delay.
            Some(NumberCard {
                key: Quantity::Delay.key(),
                ..of_file(Quantity::DelayPlusLag)?
            })
        });
        let of_a_file = delay.is_some();
        put(delay.or_else(|| model_value("delay_s")));
        put(of_file(Quantity::Lag).or_else(|| model_value("lag_s").filter(|_| !of_a_file)));
        put(of_file(Quantity::Gain).or_else(|| model_value("gain")));
        let is_simulated = named == Some(SIMULATED);
        let simulated = |key: &'static str, value: fn(&palpate_scene::SceneDevice) -> f64| {
            let scene = scene.as_ref().filter(|_| is_simulated)?;
            first?.said(key, value(&scene.device), "the simulated device of")
        };
        put(of_file(Quantity::ViscousFriction).or_else(|| {
            simulated(Quantity::ViscousFriction.key(), |device| {
                device.viscous_friction()
            })
        }));
        put(of_file(Quantity::CoulombFriction).or_else(|| {
            simulated(Quantity::CoulombFriction.key(), |device| {
                device.coulomb_friction()
            })
        }));
        put(of_file(Quantity::SensorQuantum)
            .or_else(|| first?.number("encoder_quantum_m", Quantity::SensorQuantum.key()))
            .or_else(|| {
                simulated(Quantity::SensorQuantum.key(), |device| {
                    device.encoder_quantum()
                })
            }));
        put(of_file(Quantity::Resonance));
        put(first.and_then(|metadata| metadata.number("largest_force_n", "largest_force_n")));
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
