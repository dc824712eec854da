//! Watchdog process: it removes the force of a device if the loop cannot.
//!
//! Some boards hold the last commanded force until the next command. If the commanding program is killed (SIGKILL),
//! stopped (SIGSTOP) or aborts, none of its threads can remove the force. The *watchdog process* is a separate small
//! process with a second handle of the port to the board. The driver sends it a message before every packet that
//! carries a force. After [`Orders::limit`] without a message, and as soon as the program ends, it sends
//! [`Orders::release`] itself.
//!
//! ```text
//! driver --- packets ------------> port <------- release --- watchdog
//!    \                                                         /
//!     +------ "a force may be on, at 12.345 s" --------------->
//!      <----- "I have commanded no force" --------------------
//! ```
//!
//! The messages use a pair of connected non-blocking sockets. The driver sends them as part of its packets: a loop on
//! a device without a watchdog makes no such calls.
//!
//! [`serve`] is the main function of the watchdog process. [`Watchdog`] is the driver's side.

mod process;
mod watch;

use std::io::{self, ErrorKind, Read, Write};
use std::os::fd::BorrowedFd;
use std::os::unix::net::UnixStream;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use palpate_device::clock::{Clock, MonotonicClock};

pub use process::serve;
pub use watch::{Outcome, Watch};

/// Maximum start-up time of a watchdog process on a busy machine.
const STARTS_WITHIN: Duration = Duration::from_secs(30);
/// Maximum time that a dismissed watchdog process may take to end before it is killed.
const ENDS_WITHIN: Duration = Duration::from_secs(2);
/// Time for which a watchdog process retries its zero command after the loop has ended. It exceeds the time for which
/// a board can be busy, and it is finite.
const TRIES_FOR: Duration = Duration::from_secs(10);
/// Requested priority of a watchdog process: above all loops and their supervisors. It sleeps most of the time.
const PRIORITY: u8 = 99;

/// Minimum limit: continuous polling would occupy a processor.
const SHORTEST: Duration = Duration::from_micros(100);

/// Message: a force may be on from now on.
const FORCE: u8 = b'F';
/// Message: no force is on.
const NONE: u8 = b'0';
/// Message: the device was closed in order, and the watchdog is no longer needed.
const DISMISSED: u8 = b'E';
/// Reply: the watchdog has started. The next byte reports whether it has its priority.
const READY: u8 = b'R';
/// Reply: the watchdog is about to command zero force.
const CUT: u8 = b'C';
/// Length of a message: one of the bytes above and the time in nanoseconds of the machine's monotonic clock.
const WORD: usize = 9;

/// Parameters of a watchdog process, sent once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Orders {
    /// Maximum time between messages while a force may be on.
    pub limit: Duration,
    /// Packet that removes the force, also after an incomplete packet of the driver.
    pub release: Vec<u8>,
    /// Packet that commands zero force and requests an answer.
    pub probe: Vec<u8>,
    /// Length of the answer to the probe.
    pub answer: usize,
}

impl Orders {
    /// Longest packet.
    const LONGEST: usize = 255;

    fn write(&self, to: &mut impl Write) -> io::Result<()> {
        let limit = u64::try_from(self.limit.as_nanos()).unwrap_or(u64::MAX);
        let mut bytes = limit.to_le_bytes().to_vec();
        for packet in [&self.release, &self.probe] {
            let length = u8::try_from(packet.len()).map_err(|_| {
                io::Error::other(format!(
                    "a packet is {} bytes long; allowed: up to {}",
                    packet.len(),
                    Self::LONGEST
                ))
            })?;
            bytes.push(length);
            bytes.extend(packet);
        }
        let answer = u32::try_from(self.answer).unwrap_or(u32::MAX);
        bytes.extend(answer.to_le_bytes());
        to.write_all(&bytes)
    }

    fn read(from: &mut impl Read) -> io::Result<Self> {
        let mut limit = [0; 8];
        from.read_exact(&mut limit)?;
        let mut packet = || {
            let mut length = [0];
            from.read_exact(&mut length)?;
            let mut packet = vec![0; length[0].into()];
            from.read_exact(&mut packet)?;
            io::Result::Ok(packet)
        };
        let (release, probe) = (packet()?, packet()?);
        let mut answer = [0; 4];
        from.read_exact(&mut answer)?;
        Ok(Self {
            limit: Duration::from_nanos(u64::from_le_bytes(limit)).max(SHORTEST),
            release,
            probe,
            answer: u32::from_le_bytes(answer) as usize,
        })
    }
}

/// Record of the actions of watchdog processes, for reports. Consecutive processes may share one record.
#[derive(Debug, Default)]
pub struct WatchdogAccount {
    cuts: AtomicU64,
    lost: OnceLock<Unguarded>,
    is_first: AtomicBool,
}

impl WatchdogAccount {
    /// Returns how often a watchdog process has commanded zero force, as far as the driver has received.
    #[must_use]
    pub fn cuts(&self) -> u64 {
        self.cuts.load(Ordering::Acquire)
    }

    /// Returns the reason of the first unexpected loss of a watchdog process, if any.
    #[must_use]
    pub fn lost(&self) -> Option<Unguarded> {
        self.lost.get().copied()
    }

    /// Returns whether the watchdog process has real-time priority.
    #[must_use]
    pub fn is_first(&self) -> bool {
        self.is_first.load(Ordering::Acquire)
    }
}

/// Reason why a watchdog process is not available.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WatchdogError {
    /// The system cannot start the process.
    #[error("its process cannot be started: {0}")]
    Spawn(io::Error),
    /// The process has started and does not answer.
    #[error("its process has started but does not answer: {0}")]
    Silent(io::Error),
}

/// Reason why no watchdog process supervises a force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unguarded {
    /// The process has ended.
    Ended,
    /// The process exists and has read no message for more than a hundred periods: it is stopped, or the machine does
    /// not schedule it.
    NotListening,
}

/// The driver's side of a watchdog process.
#[derive(Debug)]
pub struct Watchdog {
    socket: Option<UnixStream>,
    /// `None` if the watchdog is a thread of this program.
    child: Option<Child>,
    account: Arc<WatchdogAccount>,
}

impl Watchdog {
    /// Starts the process of `command`, which must call [`serve`] and must not use its standard input and output. The
    /// process gets a second handle of `port`. No force may be on yet.
    ///
    /// # Errors
    /// The process does not start, or does not confirm its start within 30 s.
    pub fn start(
        mut command: Command,
        port: BorrowedFd<'_>,
        orders: &Orders,
        account: Arc<WatchdogAccount>,
    ) -> Result<Self, WatchdogError> {
        let port = port.try_clone_to_owned().map_err(WatchdogError::Spawn)?;
        let (socket, theirs) = UnixStream::pair().map_err(WatchdogError::Spawn)?;
        let child = command
            .stdin(Stdio::from(std::os::fd::OwnedFd::from(theirs)))
            .stdout(Stdio::from(port))
            .spawn()
            .map_err(WatchdogError::Spawn)?;
        // Close the parent's copies of the child's handles.
        drop(command);
        let mut watchdog = Self {
            socket: Some(socket),
            child: Some(child),
            account,
        };
        watchdog.brief(orders).map_err(WatchdogError::Silent)?;
        Ok(watchdog)
    }

    /// Creates the driver's side of a watchdog that the caller runs as a [`Watch`].
    ///
    /// # Errors
    /// An error of the system.
    pub fn beside(socket: UnixStream, account: Arc<WatchdogAccount>) -> io::Result<Self> {
        socket.set_nonblocking(true)?;
        Ok(Self {
            socket: Some(socket),
            child: None,
            account,
        })
    }

    /// Sends the parameters and waits until the watchdog is ready.
    fn brief(&mut self, orders: &Orders) -> io::Result<()> {
        let Some(socket) = &mut self.socket else {
            return Ok(());
        };
        socket.set_read_timeout(Some(STARTS_WITHIN))?;
        orders.write(socket)?;
        let mut ready = [0; 2];
        socket.read_exact(&mut ready)?;
        let [said, is_first] = ready;
        if said != READY {
            return Err(io::Error::other("another program was started"));
        }
        self.account
            .is_first
            .store(is_first == 1, Ordering::Release);
        socket.set_nonblocking(true)
    }

    /// Returns the process id, if the watchdog is a process.
    #[must_use]
    pub fn id(&self) -> Option<u32> {
        self.child.as_ref().map(Child::id)
    }

    /// Reports that a force may be on from now on. Call it before each packet that carries a force.
    ///
    /// # Errors
    /// The watchdog does not read its messages: no force may be sent.
    pub fn force(&self) -> Result<(), Unguarded> {
        self.say(FORCE)
    }

    /// Reports that no force is on. Call it after the packet that commands zero.
    ///
    /// # Errors
    /// The watchdog does not read its messages.
    pub fn none(&self) -> Result<(), Unguarded> {
        self.say(NONE)
    }

    fn say(&self, what: u8) -> Result<(), Unguarded> {
        let mut word = [what; WORD];
        let now = u64::try_from(monotonic().as_nanos()).unwrap_or(u64::MAX);
        for (place, byte) in word.iter_mut().skip(1).zip(now.to_le_bytes()) {
            *place = byte;
        }
        let written = self.socket.as_ref().map(|mut socket| socket.write(&word));
        match written {
            Some(Ok(WORD)) => Ok(()),
            // A full socket or a partial write: the watchdog does not read.
            Some(Ok(_)) => Err(self.lose(Unguarded::NotListening)),
            Some(Err(error)) if error.kind() == ErrorKind::WouldBlock => {
                Err(self.lose(Unguarded::NotListening))
            }
            _ => Err(self.lose(Unguarded::Ended)),
        }
    }

    fn lose(&self, how: Unguarded) -> Unguarded {
        // Keeps the first loss of several watchdogs.
        let _ = self.account.lost.set(how);
        how
    }

    /// Returns whether the watchdog has commanded zero force since the last call.
    ///
    /// # Errors
    /// The watchdog process has ended.
    pub fn has_cut(&self) -> Result<bool, Unguarded> {
        let mut said = [0; 16];
        let read = self
            .socket
            .as_ref()
            .map(|mut socket| socket.read(&mut said));
        match read {
            Some(Ok(count)) if count > 0 => {
                let cuts = said.iter().take(count).filter(|byte| **byte == CUT).count();
                self.account.cuts.fetch_add(cuts as u64, Ordering::AcqRel);
                Ok(cuts > 0)
            }
            Some(Err(error)) if error.kind() == ErrorKind::WouldBlock => Ok(false),
            Some(Err(error)) if error.kind() == ErrorKind::Interrupted => Ok(false),
            _ => Err(self.lose(Unguarded::Ended)),
        }
    }

    /// Ends the watchdog after the device was closed without a force. Waits until the process has ended and its
    /// handle of the port is closed.
    pub fn dismiss(mut self) {
        let _ = self.say(DISMISSED);
        self.end();
    }

    fn end(&mut self) {
        self.socket = None;
        let Some(mut child) = self.child.take() else {
            return;
        };
        let clock = MonotonicClock::new();
        while clock.now() < ENDS_WITHIN {
            match child.try_wait() {
                Ok(None) => clock.sleep_until(clock.now() + Duration::from_micros(200)),
                Ok(Some(_)) | Err(_) => return,
            }
        }
        // Neither the process nor its handle of the port may remain.
        let _ = child.kill();
        let _ = child.wait();
    }
}

impl Drop for Watchdog {
    /// Leaves the removal of a force to the watchdog process and waits up to 2 s for it.
    fn drop(&mut self) {
        self.end();
    }
}

/// Returns the time of the machine's monotonic clock, which all processes share.
fn monotonic() -> Duration {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    Duration::new(
        u64::try_from(time.tv_sec).unwrap_or(0),
        u32::try_from(time.tv_nsec).unwrap_or(0),
    )
}
