//! A pair of terminals: one end is the emulated board's, the other a path that a driver can open.

use std::fs;
use std::io;
use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{Mode, OFlags};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, ioctl_tiocnxcl, tcgetattr, tcsetattr};

/// The board's end, and the other one held open: who closes and opens it again finds it as it was.
#[derive(Debug)]
pub struct Pty {
    board: OwnedFd,
    host: OwnedFd,
    path: PathBuf,
    link: Option<PathBuf>,
}

impl Pty {
    /// A new pair; `link` is made a symbolic link to the host's end, in place of an older one.
    ///
    /// # Errors
    /// What the operating system says; also where `link` is something else than a symbolic link.
    pub fn open(link: Option<&Path>) -> io::Result<Self> {
        let flags = OpenptFlags::RDWR | OpenptFlags::NOCTTY;
        // macOS knows no such flag here, and is told afterwards.
        #[cfg(not(target_vendor = "apple"))]
        let flags = flags | OpenptFlags::CLOEXEC;
        let board = openpt(flags)?;
        #[cfg(target_vendor = "apple")]
        rustix::io::fcntl_setfd(&board, rustix::io::FdFlags::CLOEXEC)?;
        grantpt(&board)?;
        unlockpt(&board)?;
        let name = ptsname(&board, Vec::new())?;
        let path = PathBuf::from(
            name.into_string()
                .map_err(|_| io::Error::other("a terminal without a name"))?,
        );
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
        let host = rustix::fs::open(&path, flags, Mode::empty())?;
        let mut mode = tcgetattr(&host)?;
        mode.make_raw();
        tcsetattr(&host, OptionalActions::Now, &mode)?;
        let flags = rustix::fs::fcntl_getfl(&board)?;
        rustix::fs::fcntl_setfl(&board, flags | OFlags::NONBLOCK)?;
        if let Some(link) = link {
            // Only ever a link of ours is replaced.
            if link.is_symlink() {
                fs::remove_file(link)?;
            }
            std::os::unix::fs::symlink(&path, link)?;
        }
        Ok(Self {
            board,
            host,
            path,
            link: link.map(Path::to_owned),
        })
    }

    /// Where the host opens it.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.link.as_deref().unwrap_or(&self.path)
    }

    /// Adds what has arrived at the board's end to `bytes`; does not wait.
    pub fn read(&self, bytes: &mut impl Extend<u8>) {
        let mut buffer = [0; 256];
        while let Ok(read) = rustix::io::read(&self.board, &mut buffer) {
            bytes.extend(buffer.iter().take(read).copied());
            if read < buffer.len() {
                break;
            }
        }
    }

    /// Sends `bytes` to the host; what finds no room is lost, as on USB.
    pub fn write(&self, bytes: &[u8]) {
        let _ = rustix::io::write(&self.board, bytes);
    }

    /// Waits until bytes have arrived at the board's end, at most `limit`.
    pub fn wait(&self, limit: Duration) {
        let limit = Timespec {
            tv_sec: limit.as_secs().try_into().unwrap_or(i64::MAX),
            tv_nsec: limit.subsec_nanos().into(),
        };
        let mut fds = [PollFd::new(&self.board, PollFlags::IN)];
        let _ = poll(&mut fds, Some(&limit));
    }

    /// Number of bytes that have arrived at the host's end and were not read there.
    ///
    /// # Errors
    /// What the operating system says.
    pub fn unread(&self) -> io::Result<u64> {
        Ok(rustix::io::ioctl_fionread(&self.host)?)
    }

    /// Number of bytes that have arrived at the board's end and were not read there.
    ///
    /// # Errors
    /// What the operating system says.
    pub fn arrived(&self) -> io::Result<u64> {
        Ok(rustix::io::ioctl_fionread(&self.board)?)
    }

    /// Lets the next one open the host's end, though a killed one has left it shut.
    pub fn let_in(&self) {
        let _ = ioctl_tiocnxcl(&self.host);
    }
}

impl Drop for Pty {
    fn drop(&mut self) {
        if let Some(link) = &self.link
            && fs::read_link(link).is_ok_and(|to| to == self.path)
        {
            let _ = fs::remove_file(link);
        }
    }
}
