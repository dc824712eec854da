//! The report card of a device: what is known of it, how its loop keeps time, and what can be rendered on it.
//!
//! Everything on a [`Card`] comes from recordings, from a calibrated device file, or from a simulation with their
//! numbers, and says which. What nothing says is not on it.

mod calibration;
mod checks;
mod contact;
mod date;
mod device;
mod reach;
mod text;
mod ticks;
mod timing;

use palpate_calibrate::Calibration;
use palpate_record::recording::{Recording, RecordingError};
use palpate_scene::Told;
use palpate_scene::method::MethodName;
use serde::Serialize;

pub use calibration::{CalibrationCard, CalibrationRun, FoundCard, MotionCard, NoCalibrationRun};
pub use checks::{Check, Outcome};
pub use contact::{ContactCard, Curve};
pub use date::utc;
pub use device::{DeviceCard, NumberCard};
pub use reach::{MethodReachCard, ReachCard};
pub use timing::{Distribution, Histogram, TimingCard};

use crate::calibrated;
use crate::map::BounceError;
use crate::recording;
use ticks::Ticks;

/// Name and version of the JSON report.
const FORMAT: &str = "palpate card 1";

/// Stiffness that is asked about where nothing says another `[N/m]`.
const USUAL_STIFFNESS: f64 = 1000.0;

/// Most recordings of a card.
pub const MOST_RECORDINGS: usize = 3;

/// What is to be said of a device, from real data with their source.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Card {
    /// Name and version of this JSON.
    #[cfg_attr(any(test, feature = "schema"), schemars(extend("const" = FORMAT)))]
    pub format: &'static str,
    /// Version of palpate that made it.
    pub palpate_version: String,
    /// When it was made, as UTC.
    pub made: String,
    /// How the data were obtained, a sentence each.
    pub obtained: Vec<String>,
    /// The device, and the numbers that are known of it.
    pub device: DeviceCard,
    /// How its loop kept time, one entry for each recording.
    pub timing: Vec<TimingCard>,
    /// The calibration; none without a device file.
    pub calibration: Option<CalibrationCard>,
    /// What can be rendered; none where a number for it is not known.
    pub reach: Option<ReachCard>,
    /// A contact, recorded or simulated; none where there is none.
    pub contact: Option<ContactCard>,
    /// Why there is no contact, or why it is not a recorded one.
    pub no_contact: Vec<String>,
    /// What was checked, warnings first.
    pub checks: Vec<Check>,
    /// Files that were written.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<String>,
}

/// What a card is made from.
#[derive(Debug)]
pub struct Sources<'a> {
    /// What the device is called, where somebody says so.
    pub name: Option<&'a str>,
    /// Recordings of its loop.
    pub recordings: &'a [Recording],
    /// A device file, with its [`file_name`].
    pub device_file: Option<(&'a str, &'a Calibration)>,
    /// The report of the calibration, with its [`file_name`].
    pub calibration_run: Option<(&'a str, CalibrationRun)>,
    /// Stiffness of the contact that is asked about `[N/m]`; that of the first recording where nothing says so.
    pub stiffness: Option<f64>,
    /// Period of the loop `[s]`, where nothing else says it.
    pub period: Option<f64>,
    /// Methods to compare.
    pub methods: &'a [MethodName],
    /// When it is made, as UTC.
    pub made: String,
}

/// How far the work on a card is.
#[derive(Clone, Copy, Debug)]
pub enum CardProgress<'a> {
    /// A part begins.
    Part(&'a str),
    /// A step is done, of the number that [`Card::steps`] says.
    Step,
}

/// Why there is no card.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CardError {
    /// A recording cannot be read to its end.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The recordings are of several devices.
    #[error(
        "{first} is of the device `{of_first}`, and {other} of `{of_other}`; a report is of one device"
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
    /// The numbers of the device are such that the map cannot be computed.
    #[error("what can be rendered cannot be computed with the numbers of this device: {0}")]
    Reach(#[from] BounceError),
}

impl Card {
    /// Number of [steps](CardProgress::Step) of the work, if the device's mass and period are known.
    #[must_use]
    pub fn steps(methods: usize) -> usize {
        methods * ReachCard::lines()
    }

    /// Makes the card; `progress` hears of the parts and steps of the work.
    ///
    /// # Errors
    /// A recording that cannot be read, recordings of several devices, and numbers that no map takes.
    pub fn of(
        sources: &Sources<'_>,
        progress: impl Fn(CardProgress<'_>) + Sync,
    ) -> Result<Self, CardError> {
        let begins = |part| progress(CardProgress::Part(part));
        begins("reading");
        let mut read = Vec::new();
        for recording in sources.recordings {
            read.push(Ticks::read(recording)?);
        }
        let device = DeviceCard::of(sources)?;
        let timing: Vec<TimingCard> = sources
            .recordings
            .iter()
            .zip(&read)
            .map(|(recording, ticks)| TimingCard::of(recording, ticks))
            .collect();
        let calibration = sources
            .device_file
            .map(|file| CalibrationCard::of(file, sources.calibration_run.as_ref()));
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
        begins("what can be rendered");
        let step = || progress(CardProgress::Step);
        let reach = ReachCard::of(&device, &deviations, stiffness, sources.methods, step)?;
        let mut card = Self {
            format: FORMAT,
            palpate_version: env!("CARGO_PKG_VERSION").to_owned(),
            made: sources.made.clone(),
            obtained: obtained(sources),
            device,
            timing,
            calibration,
            reach,
            contact,
            no_contact,
            checks: Vec::new(),
            files: Vec::new(),
        };
        card.checks = checks::of(&card, sources, &read);
        Ok(card)
    }

    /// Adds a file that was written.
    pub fn wrote(&mut self, path: &std::path::Path) {
        self.files.push(file_name(path));
    }

    /// The checks that ended in a warning.
    pub fn warnings(&self) -> impl Iterator<Item = &Check> {
        self.checks
            .iter()
            .filter(|check| check.outcome == Outcome::Warning)
    }
}

/// Deviations of the renderer's model: those of the device file, else those of the first recording.
fn deviations(sources: &Sources<'_>) -> Told {
    if let Some((_, calibration)) = sources.device_file {
        return calibrated::deviations(calibration, |_| true);
    }
    let told = sources.recordings.first().map(recording::report::told);
    let told = told.unwrap_or_default();
    let value = |key: &str| told.get(key).copied();
    let gain = value("gain").unwrap_or(1.0);
    Told {
        delay_deviation: value("delay_deviation_s"),
        lag_deviation: value("lag_deviation_s"),
        gain_deviation: value("gain_deviation").map(|deviation| deviation / gain),
        ..Told::default()
    }
}

/// Name of a file without its folder: the page is made to be sent.
#[must_use]
pub fn file_name(path: &std::path::Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}

/// How the data were obtained, a sentence for each source.
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
                recording.receipt.palpate_version
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
