//! Devices of other programs, with their watchdog process, and of shared libraries, also of a manufacturer.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use palpate_device::Device;
use palpate_device::clock::MonotonicClock;
use palpate_drivers::external::{External, Place};
use palpate_drivers::force_dimension::{ForceDimension, OpenError, Options, Part};
use palpate_drivers::plugin::Plugin;
use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;

use super::ended::{AtTheEnd, Closed};
use crate::names::refused;

/// Arguments of the devices `process` and `udp`.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct ExternalGiven {
    /// Words of the command; None: the device is at the address.
    command: Option<Vec<String>>,
    /// Address and port.
    address: Option<(String, u16)>,
    allow_remote: bool,
    /// Command of the watchdog process; None: no watchdog process.
    watchdog: Option<Vec<String>>,
}

impl ExternalGiven {
    fn place(&self) -> PyResult<Place> {
        if let Some(words) = &self.command {
            #[cfg(unix)]
            return Ok(Place::Process(words.clone()));
            #[cfg(not(unix))]
            return Err(refused(format!(
                "{}: a Process needs Linux or macOS; use Udp",
                words.join(" ")
            )));
        }
        let (host, port) = self.address.clone().unwrap_or_default();
        let place = Place::udp((host.as_str(), port)).map_err(|error| {
            refused(format!(
                "address is \"{host}:{port}\", but must be an address and a port: {error}"
            ))
        })?;
        if let Place::Udp(address) = &place
            && !address.ip().is_loopback()
            && !self.allow_remote
        {
            return Err(refused(format!(
                "address is {address}, which is on another machine; allow_remote=True permits it, for packets that are \
                 neither encrypted nor authenticated"
            )));
        }
        Ok(place)
    }
}

/// Arguments of the device `plugin`.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct PluginGiven {
    library: PathBuf,
    argument: String,
}

/// Opens the device of a shared library and returns it with its identity.
pub fn plugin(
    given: &PluginGiven,
    clock: MonotonicClock,
    closed: &Closed,
) -> PyResult<(Box<dyn Device>, Option<String>)> {
    let closed = Arc::clone(closed);
    let tell = move |why| {
        let _ = closed.set(AtTheEnd::Said(why));
    };
    let library = given.library.display();
    let device = Plugin::open(&given.library, &given.argument, clock, tell)
        .map_err(|error| PyOSError::new_err(format!("the plug-in {library}: {error}")))?;
    Ok((
        Box::new(device),
        Some(format!("plugin:{library},{}", given.argument)),
    ))
}

/// Arguments of the device `force-dimension`.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct ForceDimensionGiven {
    library: Option<PathBuf>,
    serial: Option<i32>,
    gripper: bool,
    gravity_compensation: bool,
}

/// Opens a device of Force Dimension and returns it with its identity.
pub fn force_dimension(
    given: &ForceDimensionGiven,
    clock: MonotonicClock,
    period: Duration,
    silence: Duration,
    closed: &Closed,
) -> PyResult<(Box<dyn Device>, Option<String>)> {
    let closed = Arc::clone(closed);
    let tell = move |why| {
        let _ = closed.set(AtTheEnd::Said(why));
    };
    let options = Options {
        library: given.library.clone(),
        serial: given.serial,
        part: if given.gripper {
            Part::Gripper
        } else {
            Part::Handle
        },
        gravity_compensation: given.gravity_compensation,
        ..Options::new(period, silence)
    };
    let device = ForceDimension::open(&options, clock, tell).map_err(|error| match error {
        OpenError::NoGripper(_) | OpenError::TooSlow { .. } => refused(error.to_string()),
        _ => PyOSError::new_err(error.to_string()),
    })?;
    let identity = format!("device {} of Force Dimension's library", device.id());
    Ok((Box::new(device), Some(identity)))
}

/// Opens a device of another program with the given watchdog process and returns it with its identity.
pub fn external(
    given: &ExternalGiven,
    clock: MonotonicClock,
    period: Duration,
    silence: Duration,
    closed: &Closed,
) -> PyResult<(Box<dyn Device>, Option<String>)> {
    let place = given.place()?;
    let identity = place.identity();
    let closed = Arc::clone(closed);
    let tell = move |why| {
        let _ = closed.set(AtTheEnd::Said(why));
    };
    let not_opened =
        |error: palpate_drivers::external::OpenError| PyOSError::new_err(error.to_string());
    let device = External::open(&place, (period, silence), clock, tell).map_err(not_opened)?;
    #[cfg(unix)]
    if let Some(words) = given.watchdog.as_deref() {
        let guard = super::two_diy::guard_of(words, silence)?;
        let device = device.guarded_by(guard).map_err(not_opened)?;
        return Ok((Box::new(device), identity));
    }
    #[cfg(not(unix))]
    let _ = &given.watchdog;
    Ok((Box::new(device), identity))
}
