//! Device report: known properties of a device, timing of its loop, and renderable contacts.
//!
//! Everything on a [`Card`] comes from recordings, from a calibrated device file, or from a simulation with their
//! values, and has its source. Unknown values are omitted.

mod calibration;
mod checks;
mod contact;
mod date;
mod device;
mod felt;
mod reach;
mod text;
mod ticks;
mod timing;

use crate::calibrate::Calibration;
use palpate_record::recording::{Recording, RecordingError};
use palpate_scene::Model;
use palpate_scene::method::MethodName;
use serde::Serialize;

pub use calibration::{CalibrationCard, CalibrationRun, FoundCard, NoCalibrationRun};
pub use checks::{Check, Outcome};
pub use contact::{ContactCard, Curve};
pub use date::utc;
pub use device::{DeviceCard, NumberCard};
pub use felt::{EffectiveCard, FeltCard, FeltPointCard, MethodFeltCard};
pub use reach::{MethodReachCard, ReachCard};
pub use timing::{Distribution, Histogram, TimingCard};

use crate::calibrated;
use crate::map::BounceError;
use crate::recording;
use ticks::Ticks;

/// Name and version of the JSON report.
const FORMAT: &str = "palpate card 1";

/// Default contact stiffness if no source states one `[N/m]`.
const USUAL_STIFFNESS: f64 = 1000.0;

/// Maximum number of recordings of a report.
pub const MAX_RECORDINGS: usize = 3;

/// Report on a device, from real data with their sources.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Card {
    /// Name and version of this JSON.
    #[cfg_attr(any(test, feature = "schema"), schemars(extend("const" = FORMAT)))]
    pub format: &'static str,
    /// Version of palpate that made the report.
    pub palpate_version: String,
    /// Time at which the report was made, as UTC.
    pub made: String,
    /// Origin of the data, one sentence per source.
    pub obtained: Vec<String>,
    /// The device and its known properties.
    pub device: DeviceCard,
    /// Timing of its loop, one entry per recording.
    pub timing: Vec<TimingCard>,
    /// The calibration; none without a device file.
    pub calibration: Option<CalibrationCard>,
    /// Renderable contacts; none if a required value is unknown.
    pub reach: Option<ReachCard>,
    /// Felt impedance of contacts, and the stable stiffness over damping; none if a required value is unknown.
    pub felt: Option<FeltCard>,
    /// A recorded or simulated contact, if any.
    pub contact: Option<ContactCard>,
    /// Reasons why there is no contact, or no recorded one.
    pub no_contact: Vec<String>,
    /// Checks, warnings first.
    pub checks: Vec<Check>,
    /// Files that were written.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<String>,
}

/// Sources of a device report.
#[derive(Debug)]
pub struct Sources<'a> {
    /// Name of the device, if stated.
    pub name: Option<&'a str>,
    /// Recordings of its loop.
    pub recordings: &'a [Recording],
    /// A device file, with its [`file_name`].
    pub device_file: Option<(&'a str, &'a Calibration)>,
    /// The report of the calibration, with its [`file_name`].
    pub calibration_run: Option<(&'a str, CalibrationRun)>,
    /// Stiffness of the requested contact `[N/m]`; defaults to the stiffness of the first recording.
    pub stiffness: Option<f64>,
    /// Period of the loop `[s]`, if no other source states it.
    pub period: Option<f64>,
    /// Methods to compare.
    pub methods: &'a [MethodName],
    /// Time at which the report is made, as UTC.
    pub made: String,
}

/// Progress of a device report.
#[derive(Clone, Copy, Debug)]
pub enum CardProgress<'a> {
    /// Start of a part.
    Part(&'a str),
    /// End of one of the [`Card::steps`] steps.
    Step,
}

/// Reason why there is no report.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CardError {
    /// A recording cannot be read to its end.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The recordings are of different devices.
    #[error(
        "{first} is from the device `{of_first}`, but {other} is from `{of_other}`; a report covers one device"
    )]
    SeveralDevices {
        /// The first recording.
        first: String,
        /// Its device.
        of_first: String,
        /// Another recording.
        other: String,
        /// Its device.
        of_other: String,
    },
    /// The map cannot be computed with the properties of the device.
    #[error("the renderable contacts cannot be computed with the values of this device: {0}")]
    Reach(#[from] BounceError),
}

impl Card {
    /// Returns the number of [steps](CardProgress::Step) of the work, for a device with known mass and period.
    #[must_use]
    pub fn steps(methods: usize) -> usize {
        methods * ReachCard::lines()
    }

    /// Creates the report. Calls `progress` at each part and step.
    ///
    /// # Errors
    /// A recording cannot be read, the recordings are of different devices, or the map cannot be computed.
    pub fn new(
        sources: &Sources<'_>,
        progress: impl Fn(CardProgress<'_>) + Sync,
    ) -> Result<Self, CardError> {
        let begins = |part| progress(CardProgress::Part(part));
        begins("reading");
        let mut read = Vec::new();
        for recording in sources.recordings {
            read.push(Ticks::read(recording)?);
        }
        let device = DeviceCard::new(sources)?;
        let timing: Vec<TimingCard> = sources
            .recordings
            .iter()
            .zip(&read)
            .map(|(recording, ticks)| TimingCard::new(recording, ticks))
            .collect();
        let calibration = sources
            .device_file
            .map(|file| CalibrationCard::new(file, sources.calibration_run.as_ref()));
        let stiffness = sources
            .stiffness
            .or(device.stiffness_of_scene)
            .unwrap_or(USUAL_STIFFNESS);
        let deviations = deviations(sources);
        begins("a contact");
        let mut no_contact = Vec::new();
        let mut contact = None;
        for (recording, ticks) in sources.recordings.iter().zip(&read) {
            match ContactCard::recorded(recording, ticks) {
                Ok(found) => {
                    contact = Some(found);
                    break;
                }
                Err(why) => no_contact.push(why),
            }
        }
        if contact.is_none() {
            match ContactCard::simulated(&device, &deviations, stiffness) {
                Ok(found) => contact = Some(found),
                Err(why) => no_contact.push(why),
            }
        }
        begins("renderable contacts");
        let step = || progress(CardProgress::Step);
        let reach = ReachCard::new(&device, &deviations, stiffness, sources.methods, step)?;
        begins("felt impedance");
        let felt = FeltCard::new(&device, &deviations, stiffness, sources.methods)?;
        let mut card = Self {
            format: FORMAT,
            palpate_version: env!("CARGO_PKG_VERSION").to_owned(),
            made: sources.made.clone(),
            obtained: obtained(sources),
            device,
            timing,
            calibration,
            reach,
            felt,
            contact,
            no_contact,
            checks: Vec::new(),
            files: Vec::new(),
        };
        card.checks = checks::of(&card, sources, &read);
        Ok(card)
    }

    /// Adds a written file.
    pub fn wrote(&mut self, path: &std::path::Path) {
        self.files.push(file_name(path));
    }

    /// Returns the checks with a warning.
    pub fn warnings(&self) -> impl Iterator<Item = &Check> {
        self.checks
            .iter()
            .filter(|check| check.outcome == Outcome::Warning)
    }
}

/// Returns the deviations of the renderer's model from the device file, or else from the first recording.
fn deviations(sources: &Sources<'_>) -> Model {
    if let Some((_, calibration)) = sources.device_file {
        return calibrated::deviations(calibration, |_| true);
    }
    let model = sources.recordings.first().map(recording::report::model);
    let model = model.unwrap_or_default();
    let value = |key: &str| model.get(key).copied();
    let gain = value("gain").unwrap_or(1.0);
    Model {
        delay_deviation: value("delay_deviation_s"),
        lag_deviation: value("lag_deviation_s"),
        gain_deviation: value("gain_deviation").map(|deviation| deviation / gain),
        ..Model::default()
    }
}

/// Returns the name of a file without its folder, because the page is made for sharing.
#[must_use]
pub fn file_name(path: &std::path::Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}

/// Returns the origin of the data, one sentence per source.
fn obtained(sources: &Sources<'_>) -> Vec<String> {
    let mut said: Vec<String> = sources
        .recordings
        .iter()
        .map(|recording| {
            let written = std::fs::metadata(recording.path()).and_then(|file| file.modified());
            let written = written.map_or_else(
                |_| String::new(),
                |time| format!(", last written on {}", utc(time)),
            );
            format!(
                "Recording {}, made by palpate {}{written}.",
                file_name(recording.path()),
                recording.metadata.palpate_version
            )
        })
        .collect();
    if let Some((path, calibration)) = sources.device_file {
        let mut words = format!("Device file {path}");
        if let Some(date) = &calibration.date {
            words.push_str(&format!(" of {date}"));
        }
        if let Some(command) = &calibration.command {
            words.push_str(&format!(", found by `{command}`"));
        }
        if let Some(axis) = &calibration.axis {
            words.push_str(&format!(", along {axis}"));
        }
        said.push(words + ".");
    }
    if let Some((path, _)) = &sources.calibration_run {
        said.push(format!("Report of the calibration {path}."));
    }
    said
}
