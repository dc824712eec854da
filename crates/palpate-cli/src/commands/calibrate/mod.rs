//! `palpate calibrate`: estimates the parameters of a device from a bounded excitation in its loop.

mod arguments;
mod device;
mod stream;

use std::path::Path;
use std::time::Instant;

use palpate_record::files::bounded::DEVICE;
use palpate_record::files::outputs::Outputs;
use palpate_study::calibrate::{Calibration, Measured, Quantity, measure};

pub use arguments::CalibrateArguments;
use arguments::KnownFlags;

use crate::failure::{Failure, tell};
use crate::results::{draw, print};
use palpate_study::calibration::{CalibrationReport, ExcitedMotion, GainFrom, shown};
use palpate_study::json;

/// Excites a device, fits its motion, and writes the results.
pub fn run(arguments: &CalibrateArguments) -> Result<(), Failure> {
    let params = arguments.params();
    params
        .check()
        .map_err(|error| Failure::Arguments(error.to_string()))?;
    let results = &arguments.results;
    let mut outputs = results.overwriting.outputs();
    if let Some(out) = &results.out {
        outputs.plan("--out", out)?;
    }
    if let Some(report) = &results.report {
        outputs.plan("--report", report)?;
    }
    results.picture.plan(&mut outputs)?;
    for input in [&arguments.scene, &arguments.device.motion]
        .into_iter()
        .flatten()
    {
        outputs.protect(input);
    }
    let before = arguments.model.before.as_deref();
    let before = before.map(read_device_file).transpose()?;
    outputs.spare_inputs()?;
    arguments.model.check()?;
    let motion = if arguments.pipe {
        stream::excite(arguments, params)?
    } else {
        device::excite(arguments, params)?
    };
    deliver(arguments, &outputs, &motion, before)
}

/// Reads a device file.
pub fn read_device_file(path: &Path) -> Result<Calibration, Failure> {
    let name = path.display().to_string();
    let text = DEVICE
        .text(path)
        .map_err(|error| Failure::System(format!("{name} cannot be read: {error}")))?;
    Calibration::parse(&name, &text).map_err(|error| {
        Failure::input_at(&error, &error.file, &error.source_text, error.span.clone())
    })
}

/// Returns the source of the gain besides the motion, if there is one.
fn gain_from<'a>(model: &KnownFlags, before: Option<&'a Calibration>) -> Option<GainFrom<'a>> {
    let given = model.gain.map(GainFrom::Given);
    let spring = model.spring.map(GainFrom::Spring);
    let added_mass = model.added_mass.zip(before);
    given
        .or(spring)
        .or(added_mass.map(|(mass, before)| GainFrom::AddedMass(mass, before)))
}

/// Fits the motion, then writes and prints the results.
fn deliver(
    arguments: &CalibrateArguments,
    outputs: &Outputs,
    motion: &ExcitedMotion,
    before: Option<Calibration>,
) -> Result<(), Failure> {
    // If the program keeps the time itself, it counts the missing samples.
    if arguments.pipe
        && let Some(why) = motion.uneven_pace()
    {
        return Err(Failure::Declined(format!("no calibration: {why}")));
    }
    let begun = Instant::now();
    let mut measured = measure(
        &arguments.params(),
        motion.excited(),
        &motion.positions,
        &motion.forces,
    )
    .map_err(|declined| {
        let by_loop = motion.loop_fault().map_or_else(String::new, |fault| {
            format!(". The loop may be the cause: {fault}; try again on an idle machine first")
        });
        Failure::Declined(format!("no calibration: {declined}{by_loop}"))
    })?;
    let seconds = begun.elapsed().as_secs_f64();
    let calibration = &mut measured.fitted.calibration;
    describe(calibration, arguments);
    if let Some(jitter) = motion.sample_jitter() {
        calibration.set(Quantity::SampleJitter, jitter);
    }
    if let Some(from) = gain_from(&arguments.model, before.as_ref()) {
        let gain = from.gain(calibration);
        calibration
            .set_gain(gain.map_err(|error| Failure::Declined(format!("no calibration: {error}")))?);
    }
    let mut report =
        CalibrationReport::new(&measured.fitted.calibration, &motion.positions, seconds);
    write(arguments, outputs, motion, &measured, &mut report)?;
    let text = if arguments.results.json {
        json(&report) + "\n"
    } else {
        report.to_string()
    };
    // Standard output of a pipe carries forces only.
    if arguments.pipe {
        tell(text.trim_end());
        if !arguments.time && !arguments.results.json {
            tell(format!(
                "Not checked: the sampling period of {} s (--period), because the lines have no\n\
                 time (--time). A period error of 1 % causes a mass error of 2 %.",
                arguments.period
            ));
        }
        return Ok(());
    }
    print(&text)
}

/// Records the origin of the calibration.
fn describe(calibration: &mut Calibration, arguments: &CalibrateArguments) {
    calibration.axis = arguments
        .device
        .normal
        .as_ref()
        .map(|normal| format!("--normal {normal}"));
    calibration.command = Some(command_line(std::env::args().skip(1)));
}

/// Returns the command line for repeating the run; files are named without their folders, devices in full.
fn command_line(arguments: impl Iterator<Item = String>) -> String {
    let words = arguments.map(|argument| {
        let (flag, value) = match argument.split_once('=') {
            Some((flag, value)) if flag.starts_with("--") => (format!("{flag}="), value),
            _ => (String::new(), argument.as_str()),
        };
        let path = Path::new(value);
        let value = match path.file_name() {
            Some(name) if path.is_absolute() && !path.starts_with("/dev") => name.to_string_lossy(),
            _ => value.into(),
        };
        let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,+@%".contains(c);
        if !value.is_empty() && value.chars().all(is_plain) {
            format!("{flag}{value}")
        } else {
            format!("{flag}'{}'", value.replace('\'', "'\\''"))
        }
    });
    std::iter::once("palpate".to_owned())
        .chain(words)
        .collect::<Vec<_>>()
        .join(" ")
}

fn write(
    arguments: &CalibrateArguments,
    outputs: &Outputs,
    motion: &ExcitedMotion,
    measured: &Measured,
    report: &mut CalibrationReport,
) -> Result<(), Failure> {
    if let Some(path) = &arguments.results.out {
        let text = measured.fitted.calibration.to_string();
        outputs.write(path, |writer| writer.write_all(text.as_bytes()))?;
        report.wrote(path);
    }
    let shown = shown(motion, measured, arguments.period);
    let picture = &arguments.results.picture;
    if let Some(path) = &picture.plot {
        let figure = palpate_plot::calibration(&shown, &measured.fitted.calibration);
        draw(outputs, path, &figure, &picture.look)?;
        report.wrote(path);
    }
    if let Some(path) = &arguments.results.report {
        let mut whole = report.clone();
        whole.motion = Some(shown);
        let text = json(&whole) + "\n";
        outputs.write(path, |writer| writer.write_all(text.as_bytes()))?;
        report.wrote(path);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::command_line;

    #[test]
    fn a_command_can_be_run_again_and_names_no_folder() {
        let words = [
            "calibrate",
            "--device",
            "two words",
            "--port=/dev/ttyACM0",
            "--normal",
            "1,0",
            "--out=/home/me/it's.toml",
            "--report",
            "/home/me/report.json",
        ];
        assert_eq!(
            command_line(words.into_iter().map(str::to_owned)),
            "palpate calibrate --device 'two words' --port=/dev/ttyACM0 --normal 1,0 --out='it'\\''s.toml' --report report.json"
        );
    }
}
