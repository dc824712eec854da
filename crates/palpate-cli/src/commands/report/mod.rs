//! `palpate report`: a page about a device, for sharing.

mod arguments;
mod session;

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use palpate_record::files::bounded::DEVICE;
use palpate_record::recording::Recording;
use palpate_study::calibrate::Calibration;
use palpate_study::card::{
    CalibrationRun, Card, CardError, CardProgress, MAX_RECORDINGS, Sources, file_name, utc,
};

pub use arguments::ReportArguments;

use crate::commands::calibrate::read_device_file;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::recorded::{open, whole_or_said};
use crate::results::print_report;
use palpate_plot::{SHOWN, card};

/// Generates the device report and its page, after a session if there is one.
pub fn run(arguments: &ReportArguments) -> Result<(), Failure> {
    let kept = check(arguments)?;
    let mut outputs = arguments.overwriting.outputs();
    let inputs = [
        &arguments.device_file,
        &arguments.calibration,
        &arguments.scene,
        &arguments.device.arguments.motion,
    ];
    for input in arguments
        .recordings
        .iter()
        .chain(inputs.into_iter().flatten())
    {
        outputs.protect(input);
    }
    if let Some(out) = &arguments.out {
        outputs.plan("--out", out)?;
    }
    if let Some(recording) = &kept {
        if recording.exists() {
            return Err(Failure::System(format!(
                "{} exists, and recordings are never replaced; name another file with --record",
                recording.display()
            )));
        }
        outputs.plan("--record", recording)?;
    }
    let device_file = match &arguments.device_file {
        Some(path) => Some((file_name(path), read_device_file(path)?)),
        None => None,
    };
    let calibration = match &arguments.calibration {
        Some(path) => Some((file_name(path), read_calibration(path)?)),
        None => None,
    };
    let mut paths = arguments.recordings.clone();
    let mut outcome = Ok(());
    if let Some(recording) = kept {
        outcome = session::record(arguments, &recording)?;
        paths.push(recording);
    }
    let recordings: Vec<Recording> = paths
        .iter()
        .map(|path| open(path))
        .collect::<Result<_, _>>()?;
    let mut card = make(
        arguments,
        &recordings,
        device_file
            .as_ref()
            .map(|(path, file)| (path.as_str(), file)),
        calibration
            .as_ref()
            .map(|(path, run)| (path.as_str(), run.clone())),
    )?;
    if let Some(out) = &arguments.out {
        let text = card::html(&card).map_err(|error| {
            Failure::System(format!("a figure of the page cannot be drawn: {error}"))
        })?;
        outputs.write(out, |writer| writer.write_all(text.as_bytes()))?;
        card.wrote(out);
    }
    print_report(&card, arguments.json)?;
    outcome?;
    // The recording of a session has been checked.
    let given = recordings.iter().take(arguments.recordings.len());
    given.map(whole_or_said).fold(Ok(()), Result::and)
}

/// Rejects invalid combinations. Returns the path of the session's recording.
fn check(arguments: &ReportArguments) -> Result<Option<PathBuf>, Failure> {
    let wrong = |words: &str| Err(Failure::Arguments(words.to_owned()));
    if arguments.recordings.is_empty()
        && !arguments.device.is_named
        && arguments.device_file.is_none()
    {
        return wrong("a report needs a source: a recording, --device, or --device-file");
    }
    if arguments.recordings.len() > MAX_RECORDINGS {
        return Err(Failure::Arguments(format!(
            "{} recordings are given, but a page holds at most {MAX_RECORDINGS}",
            arguments.recordings.len()
        )));
    }
    if arguments.out.is_none() && !arguments.json {
        return wrong("no output: --out PAGE.html writes the page, --json prints the report");
    }
    for (flag, value) in [
        ("--stiffness", arguments.stiffness),
        ("--period", arguments.period),
    ] {
        if let Some(value) = value
            && !(value > 0.0 && value.is_finite())
        {
            return Err(Failure::Arguments(format!(
                "{flag} is {value}, but must be a finite number above 0"
            )));
        }
    }
    arguments.device.arguments.check()?;
    if !arguments.device.is_named {
        let given = [
            ("--scene", arguments.scene.is_some()),
            ("--record", arguments.record.is_some()),
            ("--fast", arguments.fast),
        ];
        return match given.iter().find(|(_, is_given)| *is_given) {
            Some((flag, _)) => wrong(&format!("{flag} is for a session; name its --device")),
            None => Ok(None),
        };
    }
    if !arguments.recordings.is_empty() {
        return wrong("a report covers recordings or a session on a --device, not both");
    }
    let beside = |out: &PathBuf| out.with_extension("mcap");
    match arguments
        .record
        .clone()
        .or_else(|| arguments.out.as_ref().map(beside))
    {
        Some(recording) => Ok(Some(recording)),
        None => {
            wrong("a session needs a recording file: name it with --record, or the page with --out")
        }
    }
}

fn make(
    arguments: &ReportArguments,
    recordings: &[Recording],
    device_file: Option<(&str, &Calibration)>,
    calibration_run: Option<(&str, CalibrationRun)>,
) -> Result<Card, Failure> {
    let methods = match &arguments.method {
        Some(methods) => methods.0.clone(),
        None => SHOWN.to_vec(),
    };
    let sources = Sources {
        name: arguments.name.as_deref(),
        recordings,
        device_file,
        calibration_run,
        stiffness: arguments.stiffness,
        period: arguments.period,
        methods: &methods,
        made: utc(SystemTime::now()),
    };
    let progress = Progress::new(Card::steps(methods.len()));
    let made = Card::new(&sources, |at| match at {
        CardProgress::Part(part) => progress.begin(part),
        CardProgress::Step => progress.advance(),
    });
    made.map_err(|error| match error {
        CardError::SeveralDevices { .. } => Failure::Arguments(error.to_string()),
        other => Failure::input(other),
    })
}

fn read_calibration(path: &Path) -> Result<CalibrationRun, Failure> {
    let name = path.display().to_string();
    let text = DEVICE
        .text(path)
        .map_err(|error| Failure::System(format!("{name}: {error}")))?;
    CalibrationRun::parse(&text).map_err(|error| Failure::input(format_args!("{name}: {error}")))
}
