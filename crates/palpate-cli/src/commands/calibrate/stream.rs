//! Calibration between standard input and standard output, with its exit codes.

use std::io;

use crate::pipe::{CalibratingError, Format, calibrate};
use palpate_rt::StopFlag;
use palpate_study::calibrate::ExcitationParams;
use palpate_study::calibration::ExcitedMotion;

use super::CalibrateArguments;
use crate::arguments::TraceFlags;
use crate::failure::Failure;

/// Excites a device whose positions arrive on standard input, until the excitation is complete.
///
/// # Errors
/// The excitation stopped, the input ended or is not a motion, a signal arrived, or the reader did not read. In each
/// case the last line is a force of 0.
pub fn excite(
    arguments: &CalibrateArguments,
    params: ExcitationParams,
) -> Result<ExcitedMotion, Failure> {
    let stop = StopFlag::on_signals()
        .map_err(|error| Failure::System(format!("cannot handle signals: {error}")))?;
    let unit = arguments.device.table.unit;
    let other = TraceFlags {
        unit: None,
        ..arguments.device.table.clone()
    };
    if let Some(flag) = other.given() {
        return Err(Failure::Arguments(format!(
            "{flag} is for a table; for standard input, use --unit"
        )));
    }
    let format = Format {
        time: arguments.time,
        unit: unit.unwrap_or_default(),
        is_unit_given: unit.is_some(),
        virtual_force: false,
    };
    let input = || io::stdin().lock();
    calibrate(params, format, input, Box::new(io::stdout()), &stop).map_err(|error| {
        let message = error.to_string();
        match error {
            CalibratingError::Params(_) => Failure::Arguments(message),
            CalibratingError::Line { .. } => Failure::input(message),
            CalibratingError::Ended { .. } | CalibratingError::Stopped(_) => {
                Failure::Declined(message)
            }
            CalibratingError::Signalled => Failure::Interrupted(message),
            CalibratingError::Thread(_)
            | CalibratingError::Unread(_)
            | CalibratingError::Unwritten(_)
            | CalibratingError::Panicked
            | CalibratingError::LastLine(_) => Failure::System(message),
        }
    })
}
