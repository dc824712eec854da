//! Non-blocking serial port.

use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::os::unix::fs::FileTypeExt;
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{FlockOperation, Mode, OFlags, flock, open};
use rustix::io::Errno;
use rustix::net::{SendFlags, send};
use rustix::termios::{
    OptionalActions, QueueSelector, SpecialCodeIndex, ioctl_tiocexcl, ioctl_tiocnxcl, tcflush,
    tcgetattr, tcsetattr,
};

/// On native USB any rate works except 1200 baud, which puts the board into its boot loader.
const BAUD: u32 = 115_200;

/// The other end is gone: unplugged or closed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gone;

/// Maximum number of bytes to discard if the system has no call for it.
const MAX_FORGOTTEN: usize = 1 << 16;

/// An open port with exclusive access: a terminal in raw mode, or a Unix socket of a program that serves a board, such
/// as an emulator.
#[derive(Debug)]
pub struct Serial {
    descriptor: OwnedFd,
    is_socket: bool,
}

impl Serial {
    /// Opens the port at `path` and discards earlier input.
    pub fn open(path: &Path) -> Result<Self, Errno> {
        if std::fs::metadata(path).is_ok_and(|it| it.file_type().is_socket()) {
            Self::connect(path)
        } else {
            Self::open_terminal(path)
        }
    }

    /// The server of the socket accepts one driver at a time.
    fn connect(path: &Path) -> Result<Self, Errno> {
        let system = |error: std::io::Error| Errno::from_io_error(&error).unwrap_or(Errno::IO);
        let stream = UnixStream::connect(path).map_err(system)?;
        stream.set_nonblocking(true).map_err(system)?;
        Ok(Self {
            descriptor: stream.into(),
            is_socket: true,
        })
    }

    fn open_terminal(path: &Path) -> Result<Self, Errno> {
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
        let descriptor = open(path, flags, Mode::empty())?;
        // Fails if it is not a terminal.
        let mut mode = tcgetattr(&descriptor)?;
        // The kernel lets a privileged user open a terminal in exclusive use; a lock works for every program that
        // requests it. The watchdog process shares the lock with its loop.
        flock(&descriptor, FlockOperation::NonBlockingLockExclusive).map_err(
            |error| match error {
                Errno::WOULDBLOCK => Errno::BUSY,
                other => other,
            },
        )?;
        ioctl_tiocexcl(&descriptor)?;
        mode.make_raw();
        mode.set_speed(BAUD)?;
        mode.special_codes[SpecialCodeIndex::VMIN] = 0;
        mode.special_codes[SpecialCodeIndex::VTIME] = 0;
        tcsetattr(&descriptor, OptionalActions::Now, &mode)?;
        let serial = Self {
            descriptor,
            is_socket: false,
        };
        serial.forget_input();
        Ok(serial)
    }

    /// Discards unread input.
    pub fn forget_input(&self) {
        // A failure shows in the next read.
        if !self.is_socket {
            let _ = tcflush(&self.descriptor, QueueSelector::IFlush);
            return;
        }
        let mut bytes = [0; 256];
        let mut forgotten = 0;
        while forgotten < MAX_FORGOTTEN {
            match self.read(&mut bytes) {
                Ok(0) | Err(Gone) => return,
                Ok(read) => forgotten += read,
            }
        }
    }

    /// Reads the available bytes; returns 0 if there are none.
    pub fn read(&self, into: &mut [u8]) -> Result<usize, Gone> {
        loop {
            return match rustix::io::read(&self.descriptor, &mut *into) {
                Ok(0) if self.has_hung_up() => Err(Gone),
                Ok(read) => Ok(read),
                Err(Errno::AGAIN) => Ok(0),
                Err(Errno::INTR) => continue,
                Err(_) => Err(Gone),
            };
        }
    }

    /// Writes as many bytes as the port accepts; returns 0 if it is full.
    pub fn write(&self, bytes: &[u8]) -> Result<usize, Gone> {
        loop {
            return match self.put(bytes) {
                Ok(written) => Ok(written),
                Err(Errno::AGAIN) => Ok(0),
                Err(Errno::INTR) => continue,
                Err(_) => Err(Gone),
            };
        }
    }

    fn put(&self, bytes: &[u8]) -> Result<usize, Errno> {
        if !self.is_socket {
            return rustix::io::write(&self.descriptor, bytes);
        }
        // Writing to a closed socket raises a signal, which ends a program that does not ignore it. On Apple systems
        // this is disabled when the socket is created.
        #[cfg(target_vendor = "apple")]
        let flags = SendFlags::empty();
        #[cfg(not(target_vendor = "apple"))]
        let flags = SendFlags::NOSIGNAL;
        send(&self.descriptor, bytes, flags)
    }

    /// Waits until input is available, at most `limit`.
    pub fn wait_readable(&self, limit: Duration) {
        self.wait(PollFlags::IN, limit);
    }

    /// Waits until the port accepts bytes, at most `limit`.
    pub fn wait_writable(&self, limit: Duration) {
        self.wait(PollFlags::OUT, limit);
    }

    fn wait(&self, events: PollFlags, limit: Duration) -> PollFlags {
        let limit = Timespec {
            tv_sec: limit.as_secs().try_into().unwrap_or(i64::MAX),
            tv_nsec: limit.subsec_nanos().into(),
        };
        let mut fds = [PollFd::new(&self.descriptor, events)];
        // An interrupted wait is only shorter.
        let _ = poll(&mut fds, Some(&limit));
        let [fd] = fds;
        fd.revents()
    }

    /// A terminal that has hung up reads as end of file, or as empty in raw mode.
    fn has_hung_up(&self) -> bool {
        self.wait(PollFlags::IN, Duration::ZERO)
            .intersects(PollFlags::HUP | PollFlags::ERR | PollFlags::NVAL)
    }
}

impl AsFd for Serial {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.descriptor.as_fd()
    }
}

impl Drop for Serial {
    fn drop(&mut self) {
        if !self.is_socket {
            let _ = ioctl_tiocnxcl(&self.descriptor);
        }
    }
}
