//! Opening of a device of another program.

use std::fmt::Write;
use std::io;
use std::net::{SocketAddr, ToSocketAddrs};
use std::time::Duration;

use palpate_device::DeviceError;
use palpate_device::clock::Clock;
#[cfg(unix)]
use palpate_rt::watchdog::{Orders, Watchdog, WatchdogError};

use super::account::{Account, answers_within};
use super::channel::{Channel, Closed};
use super::driver::{External, Inbox, Tell};
use super::protocol::{self, Introduction, LONGEST};
#[cfg(unix)]
use crate::prepared::Guard;

/// Time for the first answer: a program may load libraries before.
const STARTS_WITHIN: Duration = Duration::from_secs(20);
/// Time after which a refused packet ends the opening: the program may be starting.
const REFUSES_WITHIN: Duration = Duration::from_secs(1);
/// Time for the first sample after it.
const SAMPLES_WITHIN: Duration = Duration::from_secs(2);
/// Interval at which the first message to an address is repeated.
const REPEATS_EVERY: Duration = Duration::from_millis(50);
/// Number of samples that measure the round trip at opening.
const TRIALS: usize = 20;

/// Location of the program of a device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// The words of a command that starts it.
    #[cfg(unix)]
    Process(Vec<String>),
    /// An address to which it listens.
    Udp(SocketAddr),
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            #[cfg(unix)]
            Self::Process(words) => write!(f, "process:{}", words.join(" ")),
            Self::Udp(address) => write!(f, "udp:{address}"),
        }
    }
}

impl Place {
    /// Returns the device at an address and a port.
    ///
    /// # Errors
    /// The resolver's, or the port is 0.
    pub fn udp(at: impl ToSocketAddrs) -> io::Result<Self> {
        let mut found = at.to_socket_addrs()?;
        match found.next() {
            Some(address) if address.port() == 0 => {
                Err(io::Error::other("the port is 0, but must be 1 to 65535"))
            }
            Some(address) => Ok(Self::Udp(address)),
            None => Err(io::Error::other("the name has no address")),
        }
    }

    /// Returns a name of the device that is the same for two devices at one place. `None`: each start makes another.
    #[must_use]
    pub fn identity(&self) -> Option<String> {
        match self {
            #[cfg(unix)]
            Self::Process(_) => None,
            Self::Udp(_) => Some(self.to_string()),
        }
    }
}

/// Reason why a device of another program could not be opened.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OpenError {
    /// The program cannot be started.
    #[error("{program} cannot be started: {error}")]
    Start {
        /// First word of the command.
        program: String,
        /// Reason.
        error: io::Error,
    },
    /// A socket cannot be opened.
    #[error("the socket for {address} cannot be opened: {error}")]
    Socket {
        /// Address of the device.
        address: SocketAddr,
        /// Reason.
        error: io::Error,
    },
    /// The program ended.
    #[error("the program of {0} has ended before it answered `hello`: {1}")]
    Ended(Place, String),
    /// No answer.
    #[error("{place} has not answered `hello` within {} s", .1.as_secs(), place = .0)]
    Silent(Place, Duration),
    /// No program has the port.
    #[error("{0} refuses packets: no program listens there; start it first")]
    Refused(Place),
    /// A wrong answer.
    #[error("{0}")]
    Introduction(String),
    /// No sample followed.
    #[error("{place} has sent no valid sample within {} s: {why}", .1.as_secs(), place = .0, why = .2)]
    NoSample(Place, Duration, String),
    /// The device failed at once.
    #[error("{error}{}", .reason.as_ref().map_or_else(String::new, |reason| format!(": {reason}")))]
    Device {
        /// Failure.
        error: DeviceError,
        /// The device's own words.
        reason: Option<String>,
    },
    /// The watchdog process cannot be started.
    #[cfg(unix)]
    #[error("the watchdog process: {0}")]
    Watchdog(WatchdogError),
}

impl<C: Clock> External<C> {
    /// Opens the device at `place` for a loop of `period`, which commands it at least every `silence` while a force is
    /// on. `tell` receives the reason if its program ends before the loop.
    ///
    /// # Errors
    /// The program does not start or answer, or its answer is wrong.
    pub fn open(
        place: &Place,
        (period, silence): (Duration, Duration),
        clock: C,
        tell: impl FnOnce(String) + Send + 'static,
    ) -> Result<Self, OpenError> {
        let mut starting = start(place)?;
        let mut inbox = Inbox::new();
        let hello = protocol::hello(period, silence);
        let made = introduce(place, &starting.channel, &mut inbox, hello.bytes(), &clock);
        #[cfg(unix)]
        let made = made.map_err(|error| match error {
            OpenError::Ended(place, how) => OpenError::Ended(
                place,
                starting
                    .program
                    .take()
                    .and_then(|program| program.end())
                    .unwrap_or(how),
            ),
            other => other,
        });
        let made = made?;
        let loses = starting.channel.has_packets();
        let mut device = Self {
            heard_at: clock.now(),
            clock,
            capabilities: made.capabilities,
            channel: starting.channel,
            period,
            account: Account::new(period, made.sends_every, loses),
            inbox,
            rest: None,
            is_gone: false,
            reason: String::with_capacity(LONGEST),
            #[cfg(unix)]
            watchdog: None,
            #[cfg(unix)]
            unguarded: None,
            #[cfg(unix)]
            program: starting.program,
            tell: None,
            has_begun: false,
            unreadable: None,
        };
        // Until a watchdog process runs, the loop's own end is the only one that may leave a force.
        device.capabilities.holds_last_force = true;
        device.first_samples(place, answers_within(period, made.sends_every))?;
        device.tell = Some(Tell(Box::new(tell)));
        Ok(device)
    }

    /// Waits for the first samples, which measure the round trip.
    fn first_samples(&mut self, place: &Place, patience: Duration) -> Result<(), OpenError> {
        let mut left = TRIALS;
        let begun = self.clock.now();
        while left > 0 {
            let sample = self.sample(patience);
            let sample = sample.map_err(|error| OpenError::Device {
                error,
                reason: self.reason().map(str::to_owned),
            })?;
            if sample.is_some() {
                left -= 1;
            } else if left == TRIALS && self.clock.now().saturating_sub(begun) > SAMPLES_WITHIN {
                let why = self.why_no_sample(patience);
                return Err(OpenError::NoSample(place.clone(), SAMPLES_WITHIN, why));
            } else if left < TRIALS && self.clock.now().saturating_sub(begun) > SAMPLES_WITHIN {
                break;
            } else {
                self.channel.wait(patience);
            }
        }
        Ok(())
    }

    /// Describes what has arrived in place of a sample; an answer has `patience`.
    fn why_no_sample(&self, patience: Duration) -> String {
        let found = self.account.connection();
        let mut why = format!("{} unreadable, {} late", found.unreadable, found.late);
        if let Some(line) = &self.unreadable {
            let _ = write!(
                why,
                "; the first unreadable line is \"{line}\", but needed is: {}",
                protocol::needed(&self.capabilities)
            );
        } else if let Some([median, ..]) = found.round_trip.filter(|_| found.late > 0) {
            let _ = write!(
                why,
                "; an answer takes {:.1} ms, and counts up to {:.1} ms, three periods: use a longer period, or a faster \
                 device",
                1e3 * median.as_secs_f64(),
                1e3 * patience.as_secs_f64()
            );
        } else {
            let _ = write!(why, "; needed is: {}", protocol::needed(&self.capabilities));
        }
        why
    }

    /// Starts a watchdog process, which commands zero force if this program ends, or if the driver sends nothing for the
    /// limit while a force is on. If it ends before the device is closed, the device commands only zero force and
    /// returns [`Refused`](palpate_device::DeviceErrorKind::Refused).
    ///
    /// # Errors
    /// The process does not start. The device is closed.
    #[cfg(unix)]
    pub fn guarded_by(mut self, guard: Guard) -> Result<Self, OpenError> {
        use std::os::fd::AsFd;
        let orders = Orders {
            limit: guard.limit,
            release: self.channel.zero().to_vec(),
            probe: protocol::PROBE.to_vec(),
            answer: protocol::SHORTEST_ANSWER,
        };
        let channel = self.channel.as_fd();
        let watchdog = Watchdog::start(guard.command, channel, &orders, guard.account);
        self.watchdog = Some(watchdog.map_err(OpenError::Watchdog)?);
        // The start has taken time.
        self.heard_at = self.clock.now();
        Ok(self)
    }

    /// Returns the median round trip so far.
    #[must_use]
    pub fn round_trip(&self) -> Option<Duration> {
        let [median, ..] = self.account.connection().round_trip?;
        Some(median)
    }
}

/// A channel, and the program at its other end.
struct Starting {
    channel: Channel,
    #[cfg(unix)]
    program: Option<super::process::Program>,
}

fn start(place: &Place) -> Result<Starting, OpenError> {
    match place {
        #[cfg(unix)]
        Place::Process(words) => {
            let started = super::process::Program::start(words);
            let (program, channel) = started.map_err(|error| OpenError::Start {
                program: words.first().cloned().unwrap_or_default(),
                error,
            })?;
            Ok(Starting {
                channel,
                program: Some(program),
            })
        }
        Place::Udp(address) => {
            let channel = Channel::to(*address).map_err(|error| OpenError::Socket {
                address: *address,
                error,
            })?;
            Ok(Starting {
                channel,
                #[cfg(unix)]
                program: None,
            })
        }
    }
}

/// Sends `hello` until the device introduces itself.
fn introduce<C: Clock>(
    place: &Place,
    channel: &Channel,
    inbox: &mut Inbox,
    hello: &[u8],
    clock: &C,
) -> Result<Introduction, OpenError> {
    let begun = clock.now();
    let mut said: Option<Duration> = None;
    let mut line = [0; LONGEST];
    loop {
        let now = clock.now();
        if now.saturating_sub(begun) > STARTS_WITHIN {
            return Err(OpenError::Silent(place.clone(), STARTS_WITHIN));
        }
        let mut is_refused = channel.is_refused();
        let is_due = said
            .is_none_or(|said| channel.has_packets() && now.saturating_sub(said) >= REPEATS_EVERY);
        if is_due {
            said = Some(now);
            // A refused packet is repeated; a stream has room for its first line.
            let _ = channel.send(hello);
            is_refused |= channel.is_refused();
        }
        if is_refused && now.saturating_sub(begun) > REFUSES_WITHIN {
            return Err(OpenError::Refused(place.clone()));
        }
        match inbox.next(channel, &mut line) {
            Ok(None) => channel.wait(REPEATS_EVERY),
            Ok(Some(length)) => {
                let heard = length.and_then(|length| line.get(..length));
                let heard = String::from_utf8_lossy(heard.unwrap_or(b"(a line that is too long)"));
                let heard = heard.trim();
                // Packets of an earlier session may still arrive.
                let is_old = channel.has_packets() && heard.starts_with("sample");
                if !heard.is_empty() && !is_old {
                    return Introduction::parse(heard).map_err(OpenError::Introduction);
                }
            }
            Err(Closed) => {
                let how = "its output is closed".to_owned();
                return Err(OpenError::Ended(place.clone(), how));
            }
        }
    }
}
