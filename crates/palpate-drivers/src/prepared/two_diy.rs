//! The Haply 2DIY on a serial port: port detection, opening with its watchdog process, and orderly shutdown.

use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::two_diy::{Board, Calibration, Generation, Options, TwoDiy, ports};
use palpate_device::clock::Clock;
use palpate_device::{
    Capabilities, Device, DeviceError, DeviceErrorKind, Pose, Wrench, ZeroWriter,
};
use palpate_rt::watchdog::WatchdogError;

use crate::prepared::{Axis, Guard};

/// Returns the default axis of a contact on a 2DIY: away from the base, along the middle line.
#[must_use]
pub fn usual_axis(generation: Generation) -> Axis {
    let [x, y] = generation.usual_origin();
    ([x, y, 0.0], [0.0, 1.0, 0.0])
}

/// Returns a name of the 2DIY that is the same for two names of one port.
#[must_use]
pub fn identity(port: &Path) -> String {
    let own = port.canonicalize();
    own.as_deref().unwrap_or(port).display().to_string()
}

/// Selection of a 2DIY and the pose of its arm at opening.
#[derive(Clone, Debug)]
pub struct Setup {
    /// Serial port; `None`: the only port that looks like a 2DIY.
    pub port: Option<PathBuf>,
    /// Generation of the device.
    pub generation: Generation,
    /// Board; `None`: detected from the first answer, if that identifies it.
    pub board: Option<Board>,
    /// Pose of the arm at opening.
    pub calibration: Calibration,
}

/// Reason why no port can be selected for a 2DIY. The caller adds how to name a port.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PortError {
    /// The ports cannot be listed.
    #[error("{0}")]
    System(String),
    /// No port looks like a 2DIY.
    #[error("no serial port looks like a Haply board; `palpate devices` lists them")]
    NoneLikely,
    /// Several ports look like a 2DIY.
    #[error("several boards may be a 2DIY: {}", .0.join(", "))]
    SeveralLikely(Vec<String>),
}

/// Reason why a 2DIY could not be opened. It then holds no torque. The caller adds how to name a port and how to
/// disable the watchdog process.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The start pose is invalid, or no published pose exists.
    #[error("{0}")]
    StartPose(crate::two_diy::OpenError),
    /// No port can be selected.
    #[error("{0}")]
    Port(PortError),
    /// The port cannot be opened, or the answer is not that of a 2DIY.
    #[error("{0}")]
    Device(crate::two_diy::OpenError),
    /// The watchdog process could not be started.
    #[error(
        "no watchdog: {0}. This device holds its last force: if this program is killed or stopped, only a watchdog \
         sets it to 0"
    )]
    Watchdog(WatchdogError),
}

impl Setup {
    /// Returns the named port, or the only one that looks like a 2DIY.
    ///
    /// # Errors
    /// No port is named, and none or several look like a 2DIY.
    pub fn port(&self) -> Result<PathBuf, PortError> {
        if let Some(port) = &self.port {
            return Ok(port.clone());
        }
        let mut likely: Vec<_> = ports()
            .map_err(PortError::System)?
            .into_iter()
            .filter(|port| port.guess.is_likely())
            .map(|port| port.path)
            .collect();
        match likely.len() {
            0 => Err(PortError::NoneLikely),
            1 => Ok(likely.remove(0).into()),
            _ => Err(PortError::SeveralLikely(likely)),
        }
    }

    /// Opens the device for a loop of `period`. **The arm must be in its start pose and at rest**: the board counts
    /// from there.
    ///
    /// # Errors
    /// The device is missing, is of another kind, or its watchdog process cannot be started.
    pub fn open<C: Clock>(
        &self,
        period: Duration,
        clock: C,
        guard: Option<Guard>,
    ) -> Result<TwoDiy<C>, OpenError> {
        let options = Options::new(self.generation, self.calibration, period)
            .map_err(OpenError::StartPose)?;
        let options = Options {
            board: self.board,
            ..options
        };
        let port = self.port().map_err(OpenError::Port)?;
        let device = TwoDiy::open(&port, &options, clock).map_err(OpenError::Device)?;
        let Some(guard) = guard else {
            return Ok(device);
        };
        device
            .guarded_by(guard.command, guard.limit, guard.account)
            .map_err(OpenError::Watchdog)
    }
}

/// A failed shutdown: the board did not confirm that it holds no torque.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct OutputNotDisabled {
    /// Reason of the failure.
    pub error: DeviceError,
    /// Whether the port was lost before.
    pub was_gone: bool,
}

/// A 2DIY whose outputs are disabled on drop. It reports a board that does not confirm zero torque.
pub struct DisableOutput<C> {
    capabilities: Capabilities,
    /// `None` after closing.
    device: Option<TwoDiy<C>>,
    tell: Option<Tell>,
    is_gone: bool,
}

type Tell = Box<dyn FnOnce(OutputNotDisabled) + Send>;

impl<C: Clock> DisableOutput<C> {
    /// Wraps `device`. On drop, `tell` receives the failure if the board does not confirm that it holds no torque.
    pub fn new(device: TwoDiy<C>, tell: impl FnOnce(OutputNotDisabled) + Send + 'static) -> Self {
        Self {
            capabilities: device.capabilities().clone(),
            device: Some(device),
            tell: Some(Box::new(tell)),
            is_gone: false,
        }
    }

    fn with<T>(
        &mut self,
        ask: impl FnOnce(&mut TwoDiy<C>) -> Result<T, DeviceError>,
    ) -> Result<T, DeviceError> {
        let closed = DeviceError::new(DeviceErrorKind::Disconnected, "the 2DIY is closed");
        let answer = self.device.as_mut().ok_or(closed).and_then(ask);
        self.is_gone |= answer
            .as_ref()
            .is_err_and(|error| error.kind == DeviceErrorKind::Disconnected);
        answer
    }
}

impl<C: Clock> Device for DisableOutput<C> {
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

impl<C> Drop for DisableOutput<C> {
    fn drop(&mut self) {
        let closed = self.device.take().map_or(Ok(()), TwoDiy::close);
        if let (Err(error), Some(tell)) = (closed, self.tell.take()) {
            tell(OutputNotDisabled {
                error,
                was_gone: self.is_gone,
            });
        }
    }
}
