//! Pseudo-terminal pair: one end belongs to the emulated board, the other is a path that a driver can open.

use std::fs;
use std::io;
use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{Mode, OFlags};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, ioctl_tiocnxcl, tcgetattr, tcsetattr};

/// The board's end, and the host's end, which is kept open so that a reopened port is unchanged.
#[derive(Debug)]
pub struct Pty {
    board: OwnedFd,
    host: OwnedFd,
    path: PathBuf,
    link: Option<PathBuf>,
}

impl Pty {
    /// Creates a pair; `link` becomes a symbolic link to the host's end and replaces an older one.
    ///
    /// # Errors
    /// The error of the operating system; also if `link` exists and is not a symbolic link.
    pub fn open(link: Option<&Path>) -> io::Result<Self> {
        let flags = OpenptFlags::RDWR | OpenptFlags::NOCTTY;
        // macOS has no such flag here; it is set afterwards.
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
                .map_err(|_| io::Error::other("the terminal has no name"))?,
        );
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
        let host = rustix::fs::open(&path, flags, Mode::empty())?;
        let mut mode = tcgetattr(&host)?;
        mode.make_raw();
        tcsetattr(&host, OptionalActions::Now, &mode)?;
        let flags = rustix::fs::fcntl_getfl(&board)?;
        rustix::fs::fcntl_setfl(&board, flags | OFlags::NONBLOCK)?;
        if let Some(link) = link {
            // Replace only a symbolic link.
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

    /// Returns the path that the host opens.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.link.as_deref().unwrap_or(&self.path)
    }

    /// Adds the bytes received at the board's end to `bytes` without waiting.
    pub fn read(&self, bytes: &mut impl Extend<u8>) {
        let mut buffer = [0; 256];
        while let Ok(read) = rustix::io::read(&self.board, &mut buffer) {
            bytes.extend(buffer.iter().take(read).copied());
            if read < buffer.len() {
                break;
            }
        }
    }

    /// Sends `bytes` to the host; bytes that do not fit are lost, as on USB.
    pub fn write(&self, bytes: &[u8]) {
        let _ = rustix::io::write(&self.board, bytes);
    }

    /// Waits for bytes at the board's end, at most `limit`.
    pub fn wait(&self, limit: Duration) {
        let limit = Timespec {
            tv_sec: limit.as_secs().try_into().unwrap_or(i64::MAX),
            tv_nsec: limit.subsec_nanos().into(),
        };
        let mut fds = [PollFd::new(&self.board, PollFlags::IN)];
        let _ = poll(&mut fds, Some(&limit));
    }

    /// Returns the number of unread bytes at the host's end.
    ///
    /// # Errors
    /// The error of the operating system.
    pub fn unread(&self) -> io::Result<u64> {
        Ok(rustix::io::ioctl_fionread(&self.host)?)
    }

    /// Returns the number of unread bytes at the board's end.
    ///
    /// # Errors
    /// The error of the operating system.
    pub fn arrived(&self) -> io::Result<u64> {
        Ok(rustix::io::ioctl_fionread(&self.board)?)
    }

    /// Lets the next driver open the host's end, even if a killed driver left it in exclusive mode.
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
