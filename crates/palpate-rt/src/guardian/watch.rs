//! What a guardian does, from its orders to its end.

use std::io::{self, ErrorKind, Read, Write};
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;

use super::{CUT, DISMISSED, FORCE, NONE, Orders, TRIES_FOR, WORD, monotonic};

/// A board answers within this, or its answer is lost.
const ANSWERS_WITHIN: Duration = Duration::from_millis(50);
/// Nothing is on its way any more when nothing has come for this long.
const QUIET: Duration = Duration::from_millis(10);
/// The longest between two looks at the driver's words while they come. Room for them is limited, and there
/// are eight in a millisecond at 4 kHz: a guardian that slept for a limit of hundreds of periods would be
/// taken for one that does not listen.
const LISTENS_WITHIN: Duration = Duration::from_millis(10);
/// Bytes that are thrown away at a time.
const MANY: usize = 256;

/// How a guardian's work ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The driver has closed the device as it should.
    Dismissed,
    /// The loop has ended without a word, and no force was commanded.
    Released {
        /// Whether a force may have been on.
        was_on: bool,
        /// Whether the board has answered since.
        is_confirmed: bool,
    },
    /// The port is gone, and then the loop was.
    PortGone,
}

/// What the driver has said.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Heard {
    Nothing,
    Words,
    Dismissed,
    Gone,
}

/// What happened at the port.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Gone;

/// A guardian at work.
#[derive(Debug)]
pub struct Watch {
    socket: UnixStream,
    port: OwnedFd,
    orders: Orders,
    /// The beginning of a word.
    begun: Vec<u8>,
    /// When the driver has spoken last of a force, if one may be on.
    spoken: Option<Duration>,
    /// What the driver had said last when no force was commanded.
    cut: Option<Duration>,
    /// When that was begun to be sent last.
    sent: Duration,
    /// When it was looked last whether the driver is silent.
    looked: Duration,
    /// How much of the release has gone out, if a part of it has.
    part: usize,
    /// Whether the board has said anything since.
    is_answered: bool,
}

impl Watch {
    /// A guardian of the driver at the other end of `socket`, with a handle of the port.
    ///
    /// # Errors
    /// The system refuses.
    pub fn new(socket: UnixStream, port: OwnedFd, orders: Orders) -> io::Result<Self> {
        socket.set_nonblocking(true)?;
        Ok(Self {
            socket,
            port,
            orders,
            begun: Vec::with_capacity(WORD),
            spoken: None,
            cut: None,
            sent: Duration::ZERO,
            looked: Duration::ZERO,
            part: 0,
            is_answered: true,
        })
    }

    /// Watches until it is dismissed, or the loop is gone.
    #[must_use]
    pub fn run(mut self) -> Outcome {
        let mut heard = Heard::Nothing;
        loop {
            let is_port_gone = self.wait(heard);
            heard = self.listen();
            match heard {
                Heard::Dismissed => return Outcome::Dismissed,
                Heard::Gone => return self.release_for_good(),
                Heard::Nothing | Heard::Words => {}
            }
            if is_port_gone || self.look().is_err() {
                return self.outlive_the_port();
            }
        }
    }

    /// Sleeps until there is something to look at; whether the port has hung up. The end of the loop
    /// wakes it at once. The driver's words do not while a force is on: they come twice a period, and
    /// say when they were said.
    fn wait(&self, heard: Heard) -> bool {
        let limit = self.orders.limit;
        let (events, longest) = match self.spoken {
            // From now on, or this would never sleep.
            Some(_) if self.cut.is_some() => (PollFlags::empty(), Some(self.looked + limit)),
            Some(spoken) => (PollFlags::empty(), Some(spoken + limit)),
            // Words without a force; a force may follow.
            None if heard == Heard::Words => (PollFlags::empty(), Some(monotonic() + limit / 2)),
            None => (PollFlags::IN, None),
        };
        let timeout =
            longest.map(|until| timespec(until.saturating_sub(monotonic()).min(LISTENS_WITHIN)));
        let mut fds = [
            PollFd::new(&self.socket, events),
            PollFd::new(&self.port, PollFlags::empty()),
        ];
        // One that is interrupted is a short one.
        let _ = poll(&mut fds, timeout.as_ref());
        let [_, port] = &fds;
        let hung_up = PollFlags::HUP | PollFlags::ERR | PollFlags::NVAL;
        port.revents().intersects(hung_up)
    }

    /// Takes in what the driver has said.
    fn listen(&mut self) -> Heard {
        let mut heard = Heard::Nothing;
        let mut bytes = [0; MANY];
        loop {
            match self.socket.read(&mut bytes) {
                Ok(0) => return Heard::Gone,
                Ok(read) => {
                    for byte in bytes.iter().take(read) {
                        self.begun.push(*byte);
                        if self.begun.len() == WORD {
                            heard = Heard::Words;
                            if self.take_word() == DISMISSED {
                                return Heard::Dismissed;
                            }
                        }
                    }
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) if error.kind() == ErrorKind::WouldBlock => return heard,
                Err(_) => return Heard::Gone,
            }
        }
    }

    /// Takes a whole word; what it is.
    fn take_word(&mut self) -> u8 {
        let mut time = [0; 8];
        for (place, byte) in time.iter_mut().zip(self.begun.iter().skip(1)) {
            *place = *byte;
        }
        let what = self.begun.first().copied().unwrap_or(NONE);
        let time = Duration::from_nanos(u64::from_le_bytes(time));
        self.begun.clear();
        match what {
            FORCE => {
                self.spoken = Some(time);
                if self.cut.is_some_and(|cut| cut != time) {
                    self.come_back();
                }
            }
            NONE => {
                self.spoken = None;
                self.come_back();
            }
            _ => {}
        }
        what
    }

    /// The driver goes on by itself. It completes or begins packets anew, whatever has gone out here.
    fn come_back(&mut self) {
        self.cut = None;
        self.part = 0;
    }

    /// Commands no force if the driver has been silent for too long, and again while that lasts: a
    /// packet with a force may have been on its way out of a loop that then stood still.
    fn look(&mut self) -> Result<(), Gone> {
        let now = monotonic();
        self.looked = now;
        let Some(spoken) = self.spoken else {
            return Ok(());
        };
        if now < spoken + self.orders.limit {
            return Ok(());
        }
        if self.cut.is_none() {
            self.cut = Some(spoken);
            // Told before it is done: a driver that comes back finds that it was cut. It has room for
            // this, or has not listened to any of the cuts before.
            let _ = self.socket.write(&[CUT]);
            self.is_answered = true;
        }
        if self.part == 0 {
            // The answers are to packets of ours, or nobody reads them.
            self.is_answered |= self.discard()? > 0;
            let is_lost = now >= self.sent + ANSWERS_WITHIN;
            if !self.is_answered && !is_lost {
                return Ok(());
            }
            self.is_answered = false;
        }
        self.sent = now;
        self.release()
    }

    /// Sends the release, or the rest of it, as far as the port takes it.
    fn release(&mut self) -> Result<(), Gone> {
        let rest = self.orders.release.get(self.part..).unwrap_or(&[]);
        self.part += self.write(rest)?;
        if self.part >= self.orders.release.len() {
            self.part = 0;
        }
        Ok(())
    }

    fn write(&self, bytes: &[u8]) -> Result<usize, Gone> {
        loop {
            return match rustix::io::write(&self.port, bytes) {
                Ok(written) => Ok(written),
                Err(Errno::AGAIN) => Ok(0),
                Err(Errno::INTR) => continue,
                Err(_) => Err(Gone),
            };
        }
    }

    /// Throws away what the board has sent; how many bytes these were.
    fn discard(&self) -> Result<usize, Gone> {
        let mut bytes = [0; MANY];
        let mut all = 0;
        // Bounded, whoever sends.
        for _ in 0..MANY {
            match rustix::io::read(&self.port, &mut bytes) {
                Ok(0) | Err(Errno::AGAIN) => break,
                Ok(read) => all += read,
                Err(Errno::INTR) => {}
                Err(_) => return Err(Gone),
            }
        }
        Ok(all)
    }

    /// The loop is gone: nobody else writes any more. Commands no force until the board has answered.
    fn release_for_good(self) -> Outcome {
        let was_on = self.spoken.is_some();
        let until = monotonic() + TRIES_FOR;
        loop {
            match self.try_to_release(until) {
                Ok(true) => {
                    return Outcome::Released {
                        was_on,
                        is_confirmed: true,
                    };
                }
                Ok(false) if monotonic() < until => {}
                Ok(false) => {
                    return Outcome::Released {
                        was_on,
                        is_confirmed: false,
                    };
                }
                Err(Gone) => return Outcome::PortGone,
            }
        }
    }

    /// Commands no force; whether the board has answered that it does.
    fn try_to_release(&self, until: Duration) -> Result<bool, Gone> {
        if !self.send(&self.orders.release, until)? {
            return Ok(false);
        }
        // Behind the answers to what the loop had sent there is one to the probe.
        let begun = monotonic();
        let mut quiet_since = begun;
        while monotonic() < quiet_since + QUIET && monotonic() < begun + ANSWERS_WITHIN {
            if self.wait_for(PollFlags::IN, QUIET)? && self.discard()? > 0 {
                quiet_since = monotonic();
            }
        }
        if !self.send(&self.orders.probe, until)? {
            return Ok(false);
        }
        let begun = monotonic();
        let mut answered = 0;
        while answered < self.orders.answer {
            if monotonic() >= begun + ANSWERS_WITHIN {
                return Ok(false);
            }
            self.wait_for(PollFlags::IN, ANSWERS_WITHIN)?;
            answered += self.discard()?;
        }
        Ok(true)
    }

    /// Sends a packet whole; whether the port took it.
    fn send(&self, packet: &[u8], until: Duration) -> Result<bool, Gone> {
        let mut sent = 0;
        while let Some(rest) = packet.get(sent..).filter(|rest| !rest.is_empty()) {
            sent += self.write(rest)?;
            if sent < packet.len() {
                if monotonic() >= until {
                    return Ok(false);
                }
                self.wait_for(PollFlags::OUT, QUIET)?;
            }
        }
        Ok(true)
    }

    /// Waits at the port; whether what was waited for is so.
    fn wait_for(&self, events: PollFlags, limit: Duration) -> Result<bool, Gone> {
        let mut fds = [PollFd::new(&self.port, events)];
        let _ = poll(&mut fds, Some(&timespec(limit)));
        let [port] = &fds;
        let happened = port.revents();
        if happened.intersects(PollFlags::HUP | PollFlags::ERR | PollFlags::NVAL) {
            return Err(Gone);
        }
        Ok(happened.intersects(events))
    }

    /// The port is gone: it is not held open, so that it can come back by its name. Nothing is left to
    /// be done but to end with the loop, which finds out by itself.
    fn outlive_the_port(self) -> Outcome {
        let Self {
            mut socket, port, ..
        } = self;
        drop(port);
        let _ = socket.set_nonblocking(false);
        let mut bytes = [0; MANY];
        loop {
            match socket.read(&mut bytes) {
                Ok(0) => return Outcome::PortGone,
                Err(error) if error.kind() != ErrorKind::Interrupted => return Outcome::PortGone,
                // The last of its words may be that it is not needed any more.
                _ => {}
            }
        }
    }
}

fn timespec(duration: Duration) -> Timespec {
    Timespec {
        tv_sec: duration.as_secs().try_into().unwrap_or(i64::MAX),
        tv_nsec: duration.subsec_nanos().into(),
    }
}
