//! The Haply 2DIY on a serial port: found, opened with its guardian, and let go of in the end.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::time::Duration;

use palpate_device::clock::Clock;
use palpate_device::{
    Capabilities, Device, DeviceError, DeviceErrorKind, Pose, Wrench, ZeroWriter,
};
use palpate_haply::two_diy::{Board, Calibration, Generation, Options, TwoDiy, ports};
use palpate_rt::guardian::{GuardianAccount, GuardianError};

use crate::Axis;

/// The axis of the contact on a 2DIY, if nobody says otherwise: away from the base, along the middle line.
#[must_use]
pub fn usual_axis(generation: Generation) -> Axis {
    let [x, y] = generation.usual_origin();
    ([x, y, 0.0], [0.0, 1.0, 0.0])
}

/// Which 2DIY it is: one port by two names is one.
#[must_use]
pub fn identity(port: &Path) -> String {
    let own = port.canonicalize();
    own.as_deref().unwrap_or(port).display().to_string()
}

/// Which 2DIY, and how its arm stands while it is opened.
#[derive(Clone, Debug)]
pub struct Setup {
    /// Its serial port; `None`: the only one that looks like a 2DIY.
    pub port: Option<PathBuf>,
    /// Its generation.
    pub generation: Generation,
    /// Its board; `None`: found out from the first answer, where that tells.
    pub board: Option<Board>,
    /// Where the arm is.
    pub calibration: Calibration,
}

/// The guardian that a 2DIY gets: the board holds its last torque, and nobody else takes that off when the program is
/// killed or stopped.
#[derive(Debug)]
pub struct Guard {
    /// Starts [`palpate_rt::guardian::serve`].
    pub command: Command,
    /// How long the loop may be silent while a force is on.
    pub limit: Duration,
    /// What the guardian has done.
    pub account: Arc<GuardianAccount>,
}

/// Why no port can be taken for that of a 2DIY. The caller says how a port is named.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PortError {
    /// The ports cannot be listed.
    #[error("{0}")]
    System(String),
    /// None is likely.
    #[error("no serial port looks like a Haply board; `palpate devices` lists them")]
    NoneLikely,
    /// Several are likely.
    #[error("several boards may be a 2DIY: {}", .0.join(", "))]
    SeveralLikely(Vec<String>),
}

/// Why a 2DIY is not ready. It holds no torque. The caller says how a port is named and a guardian left out.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The start pose is none, or is not published.
    #[error("{0}")]
    StartPose(palpate_haply::two_diy::OpenError),
    /// There is no port to take.
    #[error("{0}")]
    Port(PortError),
    /// The port cannot be had, or what answers there is no such device.
    #[error("{0}")]
    Device(palpate_haply::two_diy::OpenError),
    /// It has no guardian.
    #[error(
        "no guardian: {0}. If this program is killed or stopped, only a guardian takes the force off this device, which \
         holds it"
    )]
    Guardian(GuardianError),
}

impl Setup {
    /// The port that is named, or the only one that looks like a 2DIY.
    ///
    /// # Errors
    /// None is named, and none or several look like one.
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

    /// Opens it for a loop of `period`. **The arm has to be in its start pose, and still**: the board counts from there.
    ///
    /// # Errors
    /// It is not there, is another one, or has no guardian where `guard` asks for one.
    pub fn open<C: Clock>(
        &self,
        period: Duration,
        clock: C,
        guard: Option<Guard>,
    ) -> Result<TwoDiy<C>, OpenError> {
        let options =
            Options::of(self.generation, self.calibration, period).map_err(OpenError::StartPose)?;
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
            .map_err(OpenError::Guardian)
    }
}

/// A 2DIY whose board has not answered in the end that it holds no torque.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct NotLetGo {
    /// Why.
    pub error: DeviceError,
    /// Whether its port had gone before.
    pub was_gone: bool,
}

/// A 2DIY that is let go of when it is dropped, and tells where its board has not said that it holds no torque.
pub struct LetGo<C> {
    capabilities: Capabilities,
    /// There until it is closed.
    device: Option<TwoDiy<C>>,
    tell: Option<Tell>,
    is_gone: bool,
}

type Tell = Box<dyn FnOnce(NotLetGo) + Send>;

impl<C: Clock> LetGo<C> {
    /// The same device; `tell` hears in the end of a board that has not said that it holds no torque.
    pub fn new(device: TwoDiy<C>, tell: impl FnOnce(NotLetGo) + Send + 'static) -> Self {
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

impl<C: Clock> Device for LetGo<C> {
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

impl<C> Drop for LetGo<C> {
    fn drop(&mut self) {
        let closed = self.device.take().map_or(Ok(()), TwoDiy::close);
        if let (Err(error), Some(tell)) = (closed, self.tell.take()) {
            tell(NotLetGo {
                error,
                was_gone: self.is_gone,
            });
        }
    }
}
