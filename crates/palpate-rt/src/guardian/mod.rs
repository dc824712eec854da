//! A process beside the loop that takes the force off a device when the loop can not.
//!
//! Some boards hold the last force that they were told until they are told another one. If the
//! program that told them is killed (SIGKILL), stopped (SIGSTOP) or aborts, no thread of that program
//! can take the force off. A *guardian* can: a small process of its own, with a second handle of the
//! port to the board. It hears from the driver before every packet that carries a force. After
//! [`Orders::limit`] of silence, and as soon as the program is gone, the guardian sends
//! [`Orders::release`] itself.
//!
//! ```text
//! driver --- packets ------------> port <------- release --- guardian
//!    \                                                         /
//!     +------ "a force may be on, at 12.345 s" --------------->
//!      <----- "I have commanded no force" --------------------
//! ```
//!
//! What the driver tells and hears goes over a pair of connected sockets, neither of which ever waits.
//! These calls are part of the driver's own sending: a loop on a device without a guardian makes none.
//!
//! [`serve`] is the guardian's side, and all that its process does. [`Guardian`] is the driver's.

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

/// How long a guardian may take to start, on a machine that is busy.
const STARTS_WITHIN: Duration = Duration::from_secs(30);
/// How long a guardian that was dismissed may take to end before it is killed.
const ENDS_WITHIN: Duration = Duration::from_secs(2);
/// For how long a guardian tries to let a board know that it should hold no force, once the loop is
/// gone: longer than a board is busy with itself, and an end.
const TRIES_FOR: Duration = Duration::from_secs(10);
/// The priority that a guardian asks for: before any loop and its supervisor. It sleeps all the time.
const PRIORITY: u8 = 99;

/// No silence is shorter: a guardian that looks all the time would keep a processor busy.
const SHORTEST: Duration = Duration::from_micros(100);

/// A force may be on from here on.
const FORCE: u8 = b'F';
/// No force is on.
const NONE: u8 = b'0';
/// The device has been closed as it should: the guardian is not needed any more.
const DISMISSED: u8 = b'E';
/// What a guardian says when it has started; a byte follows that says whether it has its priority.
const READY: u8 = b'R';
/// What it says when it is about to command no force.
const CUT: u8 = b'C';
/// Length of what a driver says: one of the bytes above, and when, in nanoseconds of the machine's
/// monotonic clock.
const WORD: usize = 9;

/// What a guardian does, told once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Orders {
    /// How long the driver may be silent while a force may be on.
    pub limit: Duration,
    /// What takes off the force, even if the driver has left the board in the middle of a packet.
    pub release: Vec<u8>,
    /// A packet that commands no force and is answered.
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

/// What guardians have done so far, for reports. One account may be shared by several that follow each
/// other.
#[derive(Debug, Default)]
pub struct GuardianAccount {
    cuts: AtomicU64,
    lost: OnceLock<Unguarded>,
    is_first: AtomicBool,
}

impl GuardianAccount {
    /// How often a guardian has commanded no force, as far as the driver has heard.
    #[must_use]
    pub fn cuts(&self) -> u64 {
        self.cuts.load(Ordering::Acquire)
    }

    /// How a guardian was lost that was not dismissed, if one was: the first of several.
    #[must_use]
    pub fn lost(&self) -> Option<Unguarded> {
        self.lost.get().copied()
    }

    /// Whether the machine serves the guardian before everybody else.
    #[must_use]
    pub fn is_first(&self) -> bool {
        self.is_first.load(Ordering::Acquire)
    }
}

/// Why there is no guardian.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GuardianError {
    /// The system does not start it.
    #[error("its process cannot be started: {0}")]
    Spawn(io::Error),
    /// It started, and has not said so.
    #[error("its process has started and does not answer: {0}")]
    Silent(io::Error),
}

/// Why nobody would take off a force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unguarded {
    /// The guardian's process has ended.
    Ended,
    /// It is there, and has not listened for more than a hundred periods: it was stopped, or the machine
    /// gives it no time.
    NotListening,
}

/// A guardian, as the driver of a device has it.
#[derive(Debug)]
pub struct Guardian {
    socket: Option<UnixStream>,
    /// None for a guardian that is a thread of this program.
    child: Option<Child>,
    account: Arc<GuardianAccount>,
}

impl Guardian {
    /// Starts the process of `command`, which has to call [`serve`] and to leave its standard input
    /// and output alone. It gets a second handle of `port`. No force may be on yet.
    ///
    /// # Errors
    /// The process does not start, or does not say within 30 s that it has.
    pub fn start(
        mut command: Command,
        port: BorrowedFd<'_>,
        orders: &Orders,
        account: Arc<GuardianAccount>,
    ) -> Result<Self, GuardianError> {
        let port = port.try_clone_to_owned().map_err(GuardianError::Spawn)?;
        let (socket, theirs) = UnixStream::pair().map_err(GuardianError::Spawn)?;
        let child = command
            .stdin(Stdio::from(std::os::fd::OwnedFd::from(theirs)))
            .stdout(Stdio::from(port))
            .spawn()
            .map_err(GuardianError::Spawn)?;
        // The handles that were the child's.
        drop(command);
        let mut guardian = Self {
            socket: Some(socket),
            child: Some(child),
            account,
        };
        guardian.brief(orders).map_err(GuardianError::Silent)?;
        Ok(guardian)
    }

    /// The driver's side of a guardian that somebody else runs, by a [`Watch`].
    ///
    /// # Errors
    /// The system refuses.
    pub fn beside(socket: UnixStream, account: Arc<GuardianAccount>) -> io::Result<Self> {
        socket.set_nonblocking(true)?;
        Ok(Self {
            socket: Some(socket),
            child: None,
            account,
        })
    }

    /// Tells it its orders, and waits until it is ready.
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
            return Err(io::Error::other("it is another program"));
        }
        self.account
            .is_first
            .store(is_first == 1, Ordering::Release);
        socket.set_nonblocking(true)
    }

    /// Process id, if it is a process.
    #[must_use]
    pub fn id(&self) -> Option<u32> {
        self.child.as_ref().map(Child::id)
    }

    /// Tells it that a force may be on from now on. To be told before each packet that carries one.
    ///
    /// # Errors
    /// Nobody listens: no force may go out.
    pub fn force(&self) -> Result<(), Unguarded> {
        self.say(FORCE)
    }

    /// Tells it that no force is on. To be told after the packet that commands none.
    ///
    /// # Errors
    /// Nobody listens.
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
            // A full socket, or one that takes a part: nobody listens.
            Some(Ok(_)) => Err(self.lose(Unguarded::NotListening)),
            Some(Err(error)) if error.kind() == ErrorKind::WouldBlock => {
                Err(self.lose(Unguarded::NotListening))
            }
            _ => Err(self.lose(Unguarded::Ended)),
        }
    }

    fn lose(&self, how: Unguarded) -> Unguarded {
        // The account keeps the first of several guardians.
        let _ = self.account.lost.set(how);
        how
    }

    /// Whether it has commanded no force since the last time this was asked.
    ///
    /// # Errors
    /// It is gone.
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

    /// Ends it: the device has been closed, and is known to hold no force. Waits until its process is
    /// gone, and with it the second handle of the port.
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
        // Whatever keeps it: nothing of this program stays behind, nor a port that is held open.
        let _ = child.kill();
        let _ = child.wait();
    }
}

impl Drop for Guardian {
    /// Leaves it to the guardian to take off a force, and waits for 2 s until it has.
    fn drop(&mut self) {
        self.end();
    }
}

/// The machine's monotonic clock, which all of its processes share.
fn monotonic() -> Duration {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    Duration::new(
        u64::try_from(time.tv_sec).unwrap_or(0),
        u32::try_from(time.tv_nsec).unwrap_or(0),
    )
}
