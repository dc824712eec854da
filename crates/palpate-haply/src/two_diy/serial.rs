//! A serial port that never makes anybody wait.

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

/// On native USB any speed does, but for 1200 baud, which tells the board to wait for a new program.
const BAUD: u32 = 115_200;

/// The other end is gone: unplugged, or closed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gone;

/// Bytes that are thrown away at most where the system has no call for it.
const MOST_FORGOTTEN: usize = 1 << 16;

/// An open port, ours alone: a terminal in raw mode, or a Unix socket behind which a program serves a
/// board, as an emulator does.
#[derive(Debug)]
pub struct Serial {
    descriptor: OwnedFd,
    is_socket: bool,
}

impl Serial {
    /// Opens the port at `path` and throws away what came before.
    pub fn open(path: &Path) -> Result<Self, Errno> {
        if std::fs::metadata(path).is_ok_and(|it| it.file_type().is_socket()) {
            Self::connect(path)
        } else {
            Self::open_terminal(path)
        }
    }

    /// Who serves the socket lets in one driver at a time.
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
        // Also says whether it is a terminal at all.
        let mut mode = tcgetattr(&descriptor)?;
        // The kernel lets a privileged user open a terminal that is another's alone; a lock holds for
        // every program that asks for it. A guardian shares the lock with its loop.
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

    /// Throws away what has come and was not read.
    pub fn forget_input(&self) {
        // If that fails, whoever reads next finds out why.
        if !self.is_socket {
            let _ = tcflush(&self.descriptor, QueueSelector::IFlush);
            return;
        }
        let mut bytes = [0; 256];
        let mut forgotten = 0;
        while forgotten < MOST_FORGOTTEN {
            match self.read(&mut bytes) {
                Ok(0) | Err(Gone) => return,
                Ok(read) => forgotten += read,
            }
        }
    }

    /// Reads what is there; 0 bytes if nothing is.
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

    /// Writes what finds room; 0 bytes if nothing does.
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
        // A socket that the other side has closed raises a signal, which ends a program that does not
        // ignore it; Apple's systems were told when the socket was made.
        #[cfg(target_vendor = "apple")]
        let flags = SendFlags::empty();
        #[cfg(not(target_vendor = "apple"))]
        let flags = SendFlags::NOSIGNAL;
        send(&self.descriptor, bytes, flags)
    }

    /// Waits until there is something to read, at most `limit`.
    pub fn wait_readable(&self, limit: Duration) {
        self.wait(PollFlags::IN, limit);
    }

    /// Waits until there is room to write, at most `limit`.
    pub fn wait_writable(&self, limit: Duration) {
        self.wait(PollFlags::OUT, limit);
    }

    fn wait(&self, events: PollFlags, limit: Duration) -> PollFlags {
        let limit = Timespec {
            tv_sec: limit.as_secs().try_into().unwrap_or(i64::MAX),
            tv_nsec: limit.subsec_nanos().into(),
        };
        let mut fds = [PollFd::new(&self.descriptor, events)];
        // An interrupted wait is a short one.
        let _ = poll(&mut fds, Some(&limit));
        let [fd] = fds;
        fd.revents()
    }

    /// A terminal that has hung up reads as its end, in raw mode as one without bytes.
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
