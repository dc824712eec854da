//! The Haply 2DIY of a loop, with its watchdog process.

use std::process::Command;
use std::sync::Arc;
use std::time::Duration;

use palpate_device::Device;
use palpate_device::clock::MonotonicClock;
use palpate_drivers::prepared::two_diy::{
    DisableOutput, OpenError, PortError, Setup, identity, usual_axis,
};
use palpate_drivers::prepared::{Axis, Guard};
use palpate_drivers::two_diy::{Board, Calibration, Generation};
use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;

use super::devices::{StartPose, TwoDiyGiven};
use super::ended::{AtTheEnd, Closed};
use crate::names::refused;

/// Opens a 2DIY with the given watchdog process and returns it with its default axis and its identity.
pub fn two_diy(
    given: &TwoDiyGiven,
    clock: MonotonicClock,
    period: Duration,
    silence: Duration,
    closed: &Closed,
) -> PyResult<(Box<dyn Device>, Axis, Option<String>)> {
    let generation = match given.generation {
        1 => Generation::One,
        2 => Generation::Two,
        3 => Generation::Three,
        other => {
            return Err(refused(format!(
                "generation is {other}, but must be 1, 2 or 3"
            )));
        }
    };
    let board = match given.board.as_deref() {
        None => None,
        Some("m0") => Some(Board::M0),
        Some("m3") => Some(Board::M3),
        Some("dev") => Some(Board::DevKit),
        Some(other) => {
            return Err(refused(format!(
                "board is \"{other}\", but must be \"m0\", \"m3\", \"dev\" or None"
            )));
        }
    };
    let calibration = match &given.start_pose {
        StartPose::Angles(angles) => Calibration::At(*angles),
        StartPose::Word(word) => match word.as_str() {
            "retracted" => Calibration::Retracted,
            "extended" => Calibration::Extended,
            other => {
                return Err(refused(format!(
                    "start_pose is \"{other}\", but must be \"retracted\", \"extended\" or two angles [degrees]"
                )));
            }
        },
    };
    let guard = given.watchdog.as_deref();
    let guard = guard.map(|words| guard_of(words, silence)).transpose()?;
    let mut setup = Setup {
        port: given.port.clone(),
        generation,
        board,
        calibration,
    };
    // If there is no port, `open` reports it.
    setup.port = setup.port().ok();
    let identity = setup.port.as_deref().map(identity);
    let device = setup.open(period, clock, guard).map_err(not_opened)?;
    let closed = Arc::clone(closed);
    let device = DisableOutput::new(device, move |not| {
        let _ = closed.set(AtTheEnd::NotDisabled(not.error.to_string()));
    });
    Ok((Box::new(device), usual_axis(generation), identity))
}

/// Returns a watchdog process of this command for at most `silence` between commands.
pub fn guard_of(words: &[String], silence: Duration) -> PyResult<Guard> {
    let [program, arguments @ ..] = words else {
        return Err(refused(
            "sys.executable is not set, so the watchdog cannot start; watchdog=False disables it",
        ));
    };
    let mut command = Command::new(program);
    command.args(arguments);
    Ok(Guard {
        command,
        limit: silence,
        account: Arc::default(),
    })
}

fn not_opened(error: OpenError) -> PyErr {
    match error {
        OpenError::StartPose(error) => refused(format!("start_pose: {error}")),
        OpenError::Port(error @ PortError::NoneLikely) => {
            PyOSError::new_err(format!("{error}; name one with port"))
        }
        OpenError::Port(error @ PortError::SeveralLikely(_)) => {
            refused(format!("{error}; name one with port"))
        }
        OpenError::Watchdog(_) => {
            PyOSError::new_err(format!("{error}; watchdog=False disables the watchdog"))
        }
        OpenError::Port(_) | OpenError::Device(_) => PyOSError::new_err(error.to_string()),
    }
}

/// Runs the watchdog process of a device that holds its last force; standard input is the loop's socket.
#[pyfunction]
pub fn guard() -> PyResult<()> {
    palpate_rt::watchdog::serve().map_err(|error| PyOSError::new_err(error.to_string()))
}
