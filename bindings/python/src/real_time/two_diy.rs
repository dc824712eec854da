//! The Haply 2DIY of a loop, with its guardian.

use std::path::PathBuf;
use std::process::Command;
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use palpate_device::clock::MonotonicClock;
use palpate_device::{
    Capabilities, Device, DeviceError, DeviceErrorKind, Pose, Wrench, ZeroWriter,
};
use palpate_haply::two_diy::{Board, Calibration, Generation, Options, TwoDiy, ports};
use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;

use super::devices::{Axis, StartPose, TwoDiyGiven};
use crate::names::refused;

/// Opens a 2DIY, with the guardian that it is to have.
pub fn two_diy(
    given: &TwoDiyGiven,
    clock: MonotonicClock,
    period: Duration,
    silence: Duration,
    closed: &Arc<OnceLock<String>>,
) -> PyResult<(Box<dyn Device>, Axis)> {
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
    let options = Options::of(generation, calibration, period)
        .map_err(|error| refused(format!("start_pose: {error}")))?;
    let path = match &given.port {
        Some(port) => port.clone(),
        None => likely_port()?,
    };
    let said = |error: &dyn std::fmt::Display| PyOSError::new_err(error.to_string());
    let device =
        TwoDiy::open(&path, &Options { board, ..options }, clock).map_err(|error| said(&error))?;
    let device = match given.guardian.as_deref() {
        None => device,
        Some([program, arguments @ ..]) => {
            let mut command = Command::new(program);
            command.args(arguments);
            let guarded = device.guarded_by(command, silence, Arc::default());
            guarded.map_err(|error| {
                PyOSError::new_err(format!(
                    "no guardian: {error}. If this program is killed or stopped, only a guardian takes the force \
                     off this device, which holds it; guardian=False goes without one"
                ))
            })?
        }
        Some([]) => {
            return Err(refused(
                "sys.executable names no Python to run the guardian; guardian=False goes without one",
            ));
        }
    };
    let [x, y] = generation.usual_origin();
    let usual = ([x, y, 0.0], [0.0, 1.0, 0.0]);
    let device = Closing {
        capabilities: device.capabilities().clone(),
        device: Some(device),
        closed: Arc::clone(closed),
    };
    Ok((Box::new(device), usual))
}

fn likely_port() -> PyResult<PathBuf> {
    let ports = ports().map_err(PyOSError::new_err)?;
    let likely: Vec<_> = ports.iter().filter(|port| port.guess.is_likely()).collect();
    match likely[..] {
        [port] => Ok(port.path.clone().into()),
        [] => Err(PyOSError::new_err(
            "no serial port looks like a Haply board; `palpate devices` lists them, port names one",
        )),
        _ => {
            let paths: Vec<_> = likely.iter().map(|port| port.path.as_str()).collect();
            Err(refused(format!(
                "several boards may be a 2DIY: {}; port names one",
                paths.join(", ")
            )))
        }
    }
}

/// A 2DIY that says in the end whether its board holds no torque.
struct Closing {
    capabilities: Capabilities,
    /// There until it is closed.
    device: Option<TwoDiy<MonotonicClock>>,
    closed: Arc<OnceLock<String>>,
}

impl Closing {
    fn with<T>(
        &mut self,
        ask: impl FnOnce(&mut TwoDiy<MonotonicClock>) -> Result<T, DeviceError>,
    ) -> Result<T, DeviceError> {
        let closed = DeviceError::new(DeviceErrorKind::Disconnected, "the 2DIY is closed");
        self.device.as_mut().ok_or(closed).and_then(ask)
    }
}

impl Device for Closing {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn read(&mut self) -> Result<Pose, DeviceError> {
        self.with(Device::read)
    }

    fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError> {
        self.with(|device| device.write(wrench))
    }

    fn zero_writer(&mut self) -> Option<Box<dyn ZeroWriter>> {
        self.device.as_mut()?.zero_writer()
    }

    fn was_cut(&mut self) -> bool {
        self.device.as_mut().is_some_and(Device::was_cut)
    }
}

impl Drop for Closing {
    fn drop(&mut self) {
        if let Some(Err(error)) = self.device.take().map(TwoDiy::close) {
            let _ = self.closed.set(error.to_string());
        }
    }
}

/// Serves as the guardian of a device that holds its last force; standard input is the loop's socket.
#[pyfunction]
pub fn guard() -> PyResult<()> {
    palpate_rt::guardian::serve().map_err(|error| PyOSError::new_err(error.to_string()))
}
