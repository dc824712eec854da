//! `palpate calibrate`: a bounded excitation of a device in its loop, and what it says of the device.

mod arguments;
mod device;
mod motion;
mod picture;
mod report;
mod stream;

use std::time::Instant;

use palpate_calibrate::{Calibration, Measured, measure};
use palpate_files::outputs::Outputs;

pub use arguments::CalibrateArguments;
pub use report::CalibrationReport;

use crate::failure::{Failure, tell};
use crate::results::{draw, print};
use motion::Motion;
use palpate_study::json;

/// Excites a device, fits its motion, and writes what was found.
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
    results.picture.plan(&mut outputs)?;
    let motion = if arguments.pipe {
        stream::excite(params, arguments.time, arguments.device.unit)?
    } else {
        device::excite(arguments, params)?
    };
    deliver(arguments, &outputs, &motion)
}

/// Fits, writes, and says what was found.
fn deliver(
    arguments: &CalibrateArguments,
    outputs: &Outputs,
    motion: &Motion,
) -> Result<(), Failure> {
    let begun = Instant::now();
    let mut measured = measure(
        &arguments.params(),
        motion.excited(),
        &motion.positions,
        &motion.forces,
    )
    .map_err(|declined| Failure::Declined(format!("no calibration: {declined}")))?;
    let seconds = begun.elapsed().as_secs_f64();
    describe(&mut measured.fitted.calibration, arguments);
    let mut report =
        CalibrationReport::new(&measured.fitted.calibration, &motion.positions, seconds);
    write(arguments, outputs, motion, &measured, &mut report)?;
    let text = if arguments.results.json {
        json(&report) + "\n"
    } else {
        report.to_string()
    };
    // Standard output of a pipe has forces only.
    if arguments.pipe {
        tell(text.trim_end());
        return Ok(());
    }
    print(&text)
}

/// Says how it was found.
fn describe(calibration: &mut Calibration, arguments: &CalibrateArguments) {
    let flags = &arguments.excitation;
    let on = if arguments.pipe { "--pipe" } else { "--device" };
    calibration.command = Some(format!(
        "palpate calibrate {on} --period {} --largest-force {} --seconds {} --box {} --tremor {} --seed {}",
        arguments.period,
        flags.largest_force,
        flags.seconds,
        flags.excursion,
        flags.tremor,
        flags.seed
    ));
}

fn write(
    arguments: &CalibrateArguments,
    outputs: &Outputs,
    motion: &Motion,
    measured: &Measured,
    report: &mut CalibrationReport,
) -> Result<(), Failure> {
    if let Some(path) = &arguments.results.out {
        let text = measured.fitted.calibration.to_string();
        outputs.write(path, |writer| writer.write_all(text.as_bytes()))?;
        report.wrote(path);
    }
    let picture = &arguments.results.picture;
    if let Some(path) = &picture.plot {
        let figure = picture::figure(motion, measured, arguments.period);
        draw(outputs, path, &figure, picture.size)?;
        report.wrote(path);
    }
    Ok(())
}
