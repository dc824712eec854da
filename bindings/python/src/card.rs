//! `report`: the device report as a page.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use palpate_record::recording::{Recording, RecordingError};
use palpate_study::card::{
    CalibrationRun, Card, CardError, MAX_RECORDINGS, Sources, file_name, utc,
};
use pyo3::exceptions::{PyOSError, PyTypeError};
use pyo3::prelude::*;

use crate::calibration::{NamedText, parse};
use crate::interrupt::interruptible;
use crate::methods::chosen;
use crate::names::refused;
use crate::studies::threads;

/// Sources of a device report.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct CardSources {
    recordings: Vec<PathBuf>,
    device_file: Option<NamedText>,
    calibration: Option<NamedText>,
    name: Option<String>,
    stiffness: Option<f64>,
    period: Option<f64>,
}

/// Reason for failing to make a device report.
enum Wrong {
    Recording(RecordingError),
    Card(CardError),
    Page(String),
}

/// Makes a device report: as JSON, as text, and as a page.
#[pyfunction]
pub fn report(
    py: Python<'_>,
    sources: CardSources,
    method: Option<&Bound<'_, PyAny>>,
) -> PyResult<(String, String, String)> {
    let methods = method.map_or_else(|| Ok(palpate_plot::SHOWN.to_vec()), chosen)?;
    if sources.recordings.is_empty() && sources.device_file.is_none() {
        return Err(PyTypeError::new_err(
            "a report needs a source: a recording, or device_file",
        ));
    }
    if sources.recordings.len() > MAX_RECORDINGS {
        return Err(refused(format!(
            "{} recordings are given, but a page has room for {MAX_RECORDINGS}",
            sources.recordings.len()
        )));
    }
    for (name, value) in [("stiffness", sources.stiffness), ("period", sources.period)] {
        if let Some(value) = value
            && !(value.is_finite() && value > 0.0)
        {
            return Err(refused(format!(
                "{name} is {value}, but must be finite and greater than 0"
            )));
        }
    }
    let device_file = match sources.device_file {
        None => None,
        Some(named) => {
            let file = parse(&named)?;
            Some((file_name(Path::new(&named.0)), file))
        }
    };
    let calibration = match sources.calibration {
        None => None,
        Some((name, text)) => match CalibrationRun::parse(&text) {
            Ok(run) => Some((file_name(Path::new(&name)), run)),
            Err(error) => return Err(refused(format!("{name}: {error}"))),
        },
    };
    let threads = threads()?;
    let made = interruptible(py, move |stop| {
        let recordings: Result<Vec<Recording>, _> = sources
            .recordings
            .iter()
            .map(|path| Recording::open(path))
            .collect();
        let recordings = recordings.map_err(Wrong::Recording)?;
        let of = Sources {
            name: sources.name.as_deref(),
            recordings: &recordings,
            device_file: device_file
                .as_ref()
                .map(|(name, file)| (name.as_str(), file)),
            calibration_run: calibration
                .as_ref()
                .map(|(name, run)| (name.as_str(), run.clone())),
            stiffness: sources.stiffness,
            period: sources.period,
            methods: &methods,
            made: utc(SystemTime::now()),
        };
        let card = threads.install(|| Card::new(&of, |_| stop.leave_if_raised()));
        let card = card.map_err(Wrong::Card)?;
        let page = palpate_plot::card::html(&card).map_err(|error| {
            Wrong::Page(format!("a figure of the page cannot be drawn: {error}"))
        })?;
        Ok((palpate_study::json(&card), card.to_string(), page))
    })?;
    made.map_err(|wrong| match wrong {
        Wrong::Recording(error @ RecordingError::Unreadable { .. })
        | Wrong::Card(CardError::Recording(error @ RecordingError::Unreadable { .. })) => {
            PyOSError::new_err(error.to_string())
        }
        Wrong::Recording(error) => refused(error),
        Wrong::Card(error) => refused(error),
        Wrong::Page(error) => refused(error),
    })
}
