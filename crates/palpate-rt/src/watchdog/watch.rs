//! Main loop of a watchdog process.

use std::io::{self, ErrorKind, Read, Write};
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use rustix::net::sockopt::socket_error;

use super::{CUT, DISMISSED, FORCE, NONE, Orders, TRIES_FOR, WORD, monotonic};

/// Maximum response time of a board; a later answer counts as lost.
const ANSWERS_WITHIN: Duration = Duration::from_millis(50);
/// Time without received bytes after which no further bytes are expected.
const QUIET: Duration = Duration::from_millis(10);
/// Maximum time between reads of the driver's messages. The socket buffer is limited, and at 4 kHz there are eight
/// messages per millisecond. Without this bound, a limit of hundreds of periods would let the buffer fill, and the
/// driver would report a watchdog that does not read.
const LISTENS_WITHIN: Duration = Duration::from_millis(10);
/// Number of bytes discarded at a time.
const MANY: usize = 256;

/// Result of a watchdog's work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The driver has closed the device in order.
    Dismissed,
    /// The loop has ended without a message, and zero force was commanded.
    Released {
        /// Whether a force may have been on.
        was_on: bool,
        /// Whether the board has answered since.
        is_confirmed: bool,
    },
    /// The port disappeared, and the loop ended later.
    PortGone,
}

/// Messages received from the driver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Heard {
    Nothing,
    Words,
    Dismissed,
    Gone,
}

/// Loss of the port.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Gone;

/// A running watchdog.
#[derive(Debug)]
pub struct Watch {
    socket: UnixStream,
    port: OwnedFd,
    orders: Orders,
    /// First bytes of a message.
    begun: Vec<u8>,
    /// Time of the driver's last force message, if a force may be on.
    spoken: Option<Duration>,
    /// Time of the driver's last message before zero force was commanded.
    cut: Option<Duration>,
    /// Start of the last transmission of that command.
    sent: Duration,
    /// Time of the last check of the driver's silence.
    looked: Duration,
    /// Number of bytes already sent of an incomplete release packet.
    part: usize,
    /// Whether the board has sent anything since.
    is_answered: bool,
}

impl Watch {
    /// Creates a watchdog of the driver at the other end of `socket`, with a handle of the port.
    ///
    /// # Errors
    /// An error of the system.
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

    /// Supervises the loop until the driver's dismissal or the end of the loop.
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

    /// Sleeps until the next check. Returns whether the port has hung up. The end of the loop wakes it immediately.
    /// While a force is on, messages do not wake it: they arrive twice per period and carry their time.
    fn wait(&self, heard: Heard) -> bool {
        let limit = self.orders.limit;
        let (events, longest) = match self.spoken {
            // The deadline counts from the last check, or the wait would never sleep.
            Some(_) if self.cut.is_some() => (PollFlags::empty(), Some(self.looked + limit)),
            Some(spoken) => (PollFlags::empty(), Some(spoken + limit)),
            // The driver sends messages without a force; a force may follow.
            None if heard == Heard::Words => (PollFlags::empty(), Some(monotonic() + limit / 2)),
            None => (PollFlags::IN, None),
        };
        let timeout =
            longest.map(|until| timespec(until.saturating_sub(monotonic()).min(LISTENS_WITHIN)));
        let mut fds = [
            PollFd::new(&self.socket, events),
            PollFd::new(&self.port, PollFlags::empty()),
        ];
        // An interrupted wait only ends earlier.
        let _ = poll(&mut fds, timeout.as_ref());
        let [_, port] = &fds;
        self.is_lost(port.revents())
    }

    /// Returns whether these events mean that the port is lost. A refused packet does not.
    fn is_lost(&self, events: PollFlags) -> bool {
        if events.intersects(PollFlags::HUP | PollFlags::NVAL) {
            return true;
        }
        events.contains(PollFlags::ERR)
            && match socket_error(&self.port) {
                Ok(Ok(())) => false,
                Ok(Err(error)) => !is_of_a_packet(error),
                // No socket.
                Err(_) => true,
            }
    }

    /// Reads the messages of the driver.
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

    /// Processes a complete message and returns its kind.
    fn take_word(&mut self) -> u8 {
        let (what, time) = parts(&self.begun);
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

    /// The driver continues. It completes or starts packets itself, whatever this process has sent.
    fn come_back(&mut self) {
        self.cut = None;
        self.part = 0;
    }

    /// Commands zero force if the driver has been silent for too long, and repeats it during the silence: a stalled
    /// loop may have left a packet with a force in transmission.
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
            // Report before acting, so a driver that returns detects the cut. The socket has capacity for the byte,
            // or the driver has read none of the earlier reports.
            let _ = self.socket.write(&[CUT]);
            self.is_answered = true;
        }
        if self.part == 0 {
            // The answers belong to this process's packets, or no other process reads them.
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

    /// Sends the release packet or its remainder, as far as the port accepts it.
    fn release(&mut self) -> Result<(), Gone> {
        let rest = self.orders.release.get(self.part..).unwrap_or(&[]);
        self.part += self.write(rest)?;
        if self.part >= self.orders.release.len() {
            self.part = 0;
        }
        Ok(())
    }

    fn write(&self, bytes: &[u8]) -> Result<usize, Gone> {
        let mut is_repeated = false;
        loop {
            return match rustix::io::write(&self.port, bytes) {
                Ok(written) => Ok(written),
                Err(Errno::AGAIN) => Ok(0),
                Err(Errno::INTR) => continue,
                // The error belongs to an earlier packet; this one was not sent.
                Err(error) if is_of_a_packet(error) && !is_repeated => {
                    is_repeated = true;
                    continue;
                }
                // No way to the board at present: the packet counts as lost, and is repeated as one without an answer.
                Err(error) if is_of_a_packet(error) => Ok(bytes.len()),
                Err(_) => Err(Gone),
            };
        }
    }

    /// Discards received bytes and returns their number.
    fn discard(&self) -> Result<usize, Gone> {
        let mut bytes = [0; MANY];
        let mut all = 0;
        // Bounded, so a continuous sender cannot block the watchdog.
        for _ in 0..MANY {
            match rustix::io::read(&self.port, &mut bytes) {
                Ok(0) | Err(Errno::AGAIN) => break,
                Ok(read) => all += read,
                Err(Errno::INTR) => {}
                Err(error) if is_of_a_packet(error) => {}
                Err(_) => return Err(Gone),
            }
        }
        Ok(all)
    }

    /// Commands zero force until the board has answered. The loop has ended, so no other process writes to the port.
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

    /// Commands zero force; returns whether the board has confirmed it.
    fn try_to_release(&self, until: Duration) -> Result<bool, Gone> {
        if !self.send(&self.orders.release, until)? {
            return Ok(false);
        }
        // The probe's answer follows the answers to the loop's packets.
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

    /// Sends a complete packet; returns whether the port accepted it.
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

    /// Waits for events of the port; returns whether they occurred.
    fn wait_for(&self, events: PollFlags, limit: Duration) -> Result<bool, Gone> {
        let mut fds = [PollFd::new(&self.port, events)];
        let _ = poll(&mut fds, Some(&timespec(limit)));
        let [port] = &fds;
        let happened = port.revents();
        if self.is_lost(happened) {
            return Err(Gone);
        }
        Ok(happened.intersects(events))
    }

    /// Closes a lost port, so that it can reappear under its name, and waits for the end of the loop, which detects
    /// the loss itself. If it has not within the limit, its next force has no watchdog: the end of this process tells it.
    fn outlive_the_port(self) -> Outcome {
        let Self {
            mut socket,
            port,
            orders,
            mut begun,
            ..
        } = self;
        drop(port);
        let until = monotonic() + orders.limit;
        let _ = socket.set_nonblocking(false);
        let mut bytes = [0; WORD];
        loop {
            let room = bytes.get_mut(begun.len()..).unwrap_or(&mut []);
            match socket.read(room) {
                Ok(0) => return Outcome::PortGone,
                Ok(read) => begun.extend(room.iter().take(read)),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(_) => return Outcome::PortGone,
            }
            if begun.len() == WORD {
                let (what, time) = parts(&begun);
                begun.clear();
                // A final message may be the dismissal.
                if what == FORCE && time > until {
                    return Outcome::PortGone;
                }
            }
        }
    }
}

/// Returns kind and time of a complete message.
fn parts(word: &[u8]) -> (u8, Duration) {
    let mut time = [0; 8];
    for (place, byte) in time.iter_mut().zip(word.iter().skip(1)) {
        *place = *byte;
    }
    let what = word.first().copied().unwrap_or(NONE);
    (what, Duration::from_nanos(u64::from_le_bytes(time)))
}

/// Returns whether an error of a socket belongs to an earlier packet without a receiver. The socket remains usable.
fn is_of_a_packet(error: Errno) -> bool {
    matches!(
        error,
        Errno::CONNREFUSED | Errno::HOSTUNREACH | Errno::NETUNREACH
    )
}

fn timespec(duration: Duration) -> Timespec {
    Timespec {
        tv_sec: duration.as_secs().try_into().unwrap_or(i64::MAX),
        tv_nsec: duration.subsec_nanos().into(),
    }
}
