//! Port of an emulated device on a serial line.

mod pty;
mod socket;
mod usb;

use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

pub use pty::Pty;
use socket::Socket;
pub use usb::Usb;

/// Port of the emulated device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PortSettings {
    /// A pseudo-terminal, the closest substitute of a serial port. A kernel worker transfers its bytes, which takes up
    /// to a second if all processors are busy.
    Terminal {
        /// A symbolic link to the terminal; it keeps its name when the device is plugged in again.
        link: Option<PathBuf>,
    },
    /// A Unix socket at this path. The kernel transfers its bytes immediately, without a worker.
    Socket {
        /// The socket's path.
        path: PathBuf,
    },
}

/// The device's end.
#[derive(Debug)]
pub(super) enum Port {
    Terminal(Pty),
    Socket(Socket),
}

impl Port {
    pub fn open(settings: &PortSettings) -> io::Result<Self> {
        match settings {
            PortSettings::Terminal { link } => Pty::open(link.as_deref()).map(Self::Terminal),
            PortSettings::Socket { path } => Socket::open(path).map(Self::Socket),
        }
    }

    /// Returns the path that a driver opens.
    pub fn path(&self) -> &Path {
        match self {
            Self::Terminal(pty) => pty.path(),
            Self::Socket(socket) => socket.path(),
        }
    }

    /// Adds the received bytes to `bytes` without waiting.
    pub fn read(&mut self, bytes: &mut impl Extend<u8>) {
        match self {
            Self::Terminal(pty) => pty.read(bytes),
            Self::Socket(socket) => socket.read(bytes),
        }
    }

    /// Sends `bytes` to the driver; bytes that do not fit are lost, as on USB.
    pub fn write(&mut self, bytes: &[u8]) {
        match self {
            Self::Terminal(pty) => pty.write(bytes),
            Self::Socket(socket) => socket.write(bytes),
        }
    }

    /// Waits for bytes, at most `limit`.
    pub fn wait(&self, limit: Duration) {
        match self {
            Self::Terminal(pty) => pty.wait(limit),
            Self::Socket(socket) => socket.wait(limit),
        }
    }

    /// Lets the next driver open the port, even if a killed driver left a terminal in exclusive mode.
    pub fn let_in(&self) {
        if let Self::Terminal(pty) = self {
            pty.let_in();
        }
    }
}
