//! What a driver opens to reach the emulated board.

use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::pty::Pty;
use super::socket::Socket;

/// What a driver opens to reach the emulated board.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PortSettings {
    /// A pseudo-terminal, as near to a serial port as a program can be. A worker of the kernel hands
    /// its bytes over. On a machine whose processors are all busy that takes up to a second.
    Terminal {
        /// A symbolic link to the terminal; the link's name stays when the device is plugged in again.
        link: Option<PathBuf>,
    },
    /// A Unix socket at this path. The kernel hands its bytes over at once, without a worker.
    Socket {
        /// The socket's path.
        path: PathBuf,
    },
}

/// The board's end.
#[derive(Debug)]
pub enum Port {
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

    /// Where a driver opens it.
    pub fn path(&self) -> &Path {
        match self {
            Self::Terminal(pty) => pty.path(),
            Self::Socket(socket) => socket.path(),
        }
    }

    /// Adds what has arrived to `bytes`; does not wait.
    pub fn read(&mut self, bytes: &mut impl Extend<u8>) {
        match self {
            Self::Terminal(pty) => pty.read(bytes),
            Self::Socket(socket) => socket.read(bytes),
        }
    }

    /// Sends `bytes` to the driver; what finds no room is lost, as on USB.
    pub fn write(&mut self, bytes: &[u8]) {
        match self {
            Self::Terminal(pty) => pty.write(bytes),
            Self::Socket(socket) => socket.write(bytes),
        }
    }

    /// Waits until bytes have arrived, at most `limit`.
    pub fn wait(&self, limit: Duration) {
        match self {
            Self::Terminal(pty) => pty.wait(limit),
            Self::Socket(socket) => socket.wait(limit),
        }
    }

    /// Lets the next driver open the port, though a killed one has left a terminal shut.
    pub fn let_in(&self) {
        if let Self::Terminal(pty) = self {
            pty.let_in();
        }
    }
}
