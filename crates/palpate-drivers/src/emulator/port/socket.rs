//! Unix socket that replaces a serial port, for one driver at a time.

use std::fs;
use std::io::{self, ErrorKind, Read, Write};
use std::os::unix::fs::FileTypeExt;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};

/// The board's end: the listener, and the connected driver.
#[derive(Debug)]
pub struct Socket {
    listener: UnixListener,
    driver: Option<UnixStream>,
    path: PathBuf,
}

impl Socket {
    /// Creates a socket at `path`, and replaces an abandoned one.
    ///
    /// # Errors
    /// The error of the operating system; also if `path` is not a socket, or is a socket with a listener.
    pub fn open(path: &Path) -> io::Result<Self> {
        let is_left_behind = fs::symlink_metadata(path).is_ok_and(|it| it.file_type().is_socket())
            && UnixStream::connect(path)
                .is_err_and(|error| error.kind() == ErrorKind::ConnectionRefused);
        if is_left_behind {
            fs::remove_file(path)?;
        }
        let listener = UnixListener::bind(path)?;
        listener.set_nonblocking(true)?;
        Ok(Self {
            listener,
            driver: None,
            path: path.to_owned(),
        })
    }

    /// Returns the path to which a driver connects.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Adds the received bytes to `bytes` without waiting. A second driver is rejected.
    pub fn read(&mut self, bytes: &mut impl Extend<u8>) {
        // Accept before reading the first driver: a driver that closed its socket and reconnects is not a second one.
        let next = self.listener.accept().ok().map(|(stream, _)| stream);
        if let Some(driver) = &mut self.driver
            && is_closed_after(driver, bytes)
        {
            self.driver = None;
        }
        if self.driver.is_none()
            && let Some(mut next) = next
            && next.set_nonblocking(true).is_ok()
            && !is_closed_after(&mut next, bytes)
        {
            self.driver = Some(next);
        }
    }

    /// Sends `bytes` to the driver; bytes that do not fit are lost, as on USB.
    pub fn write(&mut self, bytes: &[u8]) {
        if let Some(driver) = &mut self.driver {
            let _ = driver.write(bytes);
        }
    }

    /// Waits for bytes or a driver, at most `limit`.
    pub fn wait(&self, limit: Duration) {
        let limit = Timespec {
            tv_sec: limit.as_secs().try_into().unwrap_or(i64::MAX),
            tv_nsec: limit.subsec_nanos().into(),
        };
        let comes = PollFd::new(&self.listener, PollFlags::IN);
        let _ = match &self.driver {
            Some(driver) => poll(
                &mut [comes, PollFd::new(driver, PollFlags::IN)],
                Some(&limit),
            ),
            None => poll(&mut [comes], Some(&limit)),
        };
    }
}

/// Adds the received bytes to `bytes`, and returns whether the driver has closed its end.
fn is_closed_after(driver: &mut UnixStream, bytes: &mut impl Extend<u8>) -> bool {
    let mut buffer = [0; 256];
    loop {
        match driver.read(&mut buffer) {
            Ok(0) => return true,
            Ok(read) => bytes.extend(buffer.iter().take(read).copied()),
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return error.kind() != ErrorKind::WouldBlock,
        }
    }
}

impl Drop for Socket {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.path);
    }
}
