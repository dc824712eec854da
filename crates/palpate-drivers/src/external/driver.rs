//! Driver of a device that another program moves.

use std::time::Duration;

use palpate_device::clock::Clock;
use palpate_device::{
    Capabilities, Connection, Device, DeviceError, DeviceErrorKind, Pose, Wrench, ZeroWriter,
};
#[cfg(unix)]
use palpate_rt::watchdog::{Unguarded, Watchdog};

use super::account::{Account, Taken};
use super::channel::{Channel, Closed};
use super::protocol::{self, Heard, LONGEST, Text};
use crate::prepared::on_axes;

/// Time without a sample after which the device counts as gone.
const GIVES_UP_AFTER: Duration = Duration::from_secs(1);
/// Number of lines that one read of the loop takes.
const MAX_LINES: usize = 256;
/// Longest reason of a refusal that is kept `[byte]`.
const LONGEST_REASON: usize = 200;

/// A device that another program moves: it takes lines with wrenches and answers with lines of samples.
///
/// `read` requests a sample and waits for it for half a period, or takes the newest sample of a device that sends by
/// itself. `write` sends the wrench. Neither allocates nor waits for anything else.
///
/// **Zero.** When this is dropped, the last commands are zero force and the end. If the loop stalls, its supervisor
/// sends zero. If this program is killed or stopped, only the watchdog process or the device itself removes the force.
#[derive(Debug)]
pub struct External<C: Clock> {
    pub(super) clock: C,
    pub(super) capabilities: Capabilities,
    pub(super) channel: Channel,
    pub(super) period: Duration,
    pub(super) account: Account,
    pub(super) inbox: Inbox,
    /// End of a line that found no room.
    pub(super) rest: Option<(Text, usize)>,
    pub(super) heard_at: Duration,
    /// Whether the loop has read it.
    pub(super) has_begun: bool,
    /// First unreadable line before the loop has begun, for an error of the opening.
    pub(super) unreadable: Option<String>,
    pub(super) is_gone: bool,
    /// First reason of a refusal.
    pub(super) reason: String,
    #[cfg(unix)]
    pub(super) watchdog: Option<Watchdog>,
    #[cfg(unix)]
    pub(super) unguarded: Option<Unguarded>,
    #[cfg(unix)]
    pub(super) program: Option<super::process::Program>,
    /// Receives the reason of the end, if the device ended by itself or refused.
    pub(super) tell: Option<Tell>,
}

/// Receiver of messages for the user.
pub struct Tell(pub Box<dyn FnOnce(String) + Send>);

impl std::fmt::Debug for Tell {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Tell")
    }
}

/// Received bytes, in lines.
#[derive(Debug)]
pub struct Inbox {
    bytes: [u8; 8 * LONGEST],
    filled: usize,
    /// Whether the rest of a line that is too long is discarded.
    skips: bool,
}

impl Inbox {
    pub fn new() -> Self {
        Self {
            bytes: [0; 8 * LONGEST],
            filled: 0,
            skips: false,
        }
    }

    /// Copies the next line without its newline into `line` and returns its length. `None`: no line is complete, or so
    /// many bytes have no newline that the caller must look at its time. `Some(None)`: it is too long.
    pub fn next(
        &mut self,
        channel: &Channel,
        line: &mut [u8; LONGEST],
    ) -> Result<Option<Option<usize>>, Closed> {
        if channel.has_packets() {
            let read = channel.receive(&mut self.bytes)?;
            return Ok((read > 0).then(|| copy(self.bytes.get(..read), line)));
        }
        loop {
            let filled = self.bytes.get(..self.filled).unwrap_or(&[]);
            if let Some(end) = filled.iter().position(|byte| *byte == b'\n') {
                let found = copy(self.bytes.get(..end), line);
                self.bytes.copy_within(end + 1..self.filled, 0);
                self.filled -= end + 1;
                if std::mem::take(&mut self.skips) {
                    return Ok(Some(None));
                }
                return Ok(Some(found));
            }
            if self.filled == self.bytes.len() {
                self.skips = true;
                self.filled = 0;
                return Ok(None);
            }
            let room = self.bytes.get_mut(self.filled..).unwrap_or(&mut []);
            match channel.receive(room)? {
                0 => return Ok(None),
                read => self.filled += read,
            }
        }
    }
}

/// Copies a line, if it is not too long, and returns its length.
fn copy(from: Option<&[u8]>, to: &mut [u8; LONGEST]) -> Option<usize> {
    let from = from?;
    to.get_mut(..from.len())?.copy_from_slice(from);
    Some(from.len())
}

fn gone() -> DeviceError {
    DeviceError::new(
        DeviceErrorKind::Disconnected,
        "the program of the device has ended",
    )
}

/// Error for what ends with its cause.
fn interrupted(what: &'static str) -> DeviceError {
    DeviceError::new(DeviceErrorKind::Interrupted, what)
}

/// Error for what lasts.
fn refused(what: &'static str) -> DeviceError {
    DeviceError::new(DeviceErrorKind::Refused, what)
}

impl<C: Clock> External<C> {
    /// Returns the first reason of a refusal in the device's words, if there was one.
    #[must_use]
    pub fn reason(&self) -> Option<&str> {
        (!self.reason.is_empty()).then_some(self.reason.as_str())
    }

    /// Sends a line, after the end of an earlier one. Returns whether it found room.
    pub(super) fn send(&mut self, text: Text) -> Result<bool, Closed> {
        if let Some((before, from)) = self.rest.take() {
            let left = before.bytes().get(from..).unwrap_or(&[]);
            let sent = self.channel.send(left)?;
            if sent < left.len() {
                self.rest = Some((before, from + sent));
                return Ok(false);
            }
        }
        let sent = self.channel.send(text.bytes())?;
        if sent > 0 && sent < text.bytes().len() {
            self.rest = Some((text, sent));
        }
        Ok(sent > 0)
    }

    /// Takes all lines that have arrived. Returns the newest fresh sample.
    fn take_lines(&mut self) -> Result<Option<Pose>, DeviceError> {
        let mut line = [0; LONGEST];
        let (mut fresh, mut fault) = (None, None);
        for _ in 0..MAX_LINES {
            let length = match self.inbox.next(&self.channel, &mut line) {
                Ok(None) => break,
                Ok(Some(length)) => length,
                Err(Closed) => {
                    self.is_gone = true;
                    return Err(gone());
                }
            };
            let line = length.and_then(|length| line.get(..length));
            match line.map_or(Heard::Unreadable, |line| {
                protocol::heard(line, &self.capabilities)
            }) {
                Heard::Nothing => {}
                Heard::Unreadable => {
                    self.account.garbage();
                    // Before the loop it may allocate.
                    if !self.has_begun && self.unreadable.is_none() {
                        self.unreadable = Some(protocol::quoted(line));
                    }
                }
                Heard::Error(why) => {
                    if self.reason.is_empty() {
                        // Its capacity is reserved.
                        let kept = why.chars().take(LONGEST_REASON / 4);
                        self.reason.extend(kept);
                    }
                    fault.get_or_insert(interrupted("the device reports an error"));
                }
                Heard::Sample(sample) => {
                    let now = self.clock.now();
                    match self.account.takes(&sample, now) {
                        Taken::Missing => {}
                        Taken::NotSeconds => {
                            fault = Some(refused(
                                "the device's clock does not run in seconds; without such a clock it sends - for the time",
                            ));
                        }
                        Taken::Fresh(time) => {
                            self.heard_at = now;
                            fresh = Some(Pose {
                                position: sample.position,
                                orientation: sample.orientation,
                                time,
                            });
                        }
                    }
                }
            }
        }
        fault.map_or(Ok(fresh), Err)
    }

    /// Discards what has arrived between the opening and the loop.
    fn forget(&mut self) -> Result<(), DeviceError> {
        // Bounded, for a device that never stops.
        for _ in 0..MAX_LINES {
            if self.take_lines()?.is_none() {
                break;
            }
        }
        self.account.begins();
        self.heard_at = self.clock.now();
        Ok(())
    }

    /// Requests a sample, and waits for the answer of a device that answers requests, at most `limit`.
    pub(super) fn sample(&mut self, limit: Duration) -> Result<Option<Pose>, DeviceError> {
        let begun = self.clock.now();
        if let Some(number) = self.account.asks(begun) {
            match self.send(protocol::read(number)) {
                Ok(true) => {}
                Ok(false) => self.account.untaken(),
                Err(Closed) => {
                    self.is_gone = true;
                    return Err(gone());
                }
            }
        }
        loop {
            if let Some(pose) = self.take_lines()? {
                return Ok(Some(pose));
            }
            let waited = self.clock.now().saturating_sub(begun);
            if !self.account.is_waiting() || waited >= limit {
                return Ok(None);
            }
            self.channel.wait(limit.saturating_sub(waited));
        }
    }

    /// Checks that a watchdog process, if there is one, still runs.
    fn check_watchdog(&self) -> Result<(), DeviceError> {
        #[cfg(unix)]
        match self.unguarded {
            Some(Unguarded::Ended) => return Err(refused("the watchdog process has ended")),
            Some(Unguarded::NotListening) => {
                return Err(refused("the watchdog process does not respond"));
            }
            None => {}
        }
        Ok(())
    }

    /// Tells the watchdog process whether a force is on.
    fn tell_watchdog(&mut self, is_on: bool) {
        #[cfg(unix)]
        if let Some(watchdog) = &self.watchdog {
            let told = if is_on {
                watchdog.force()
            } else {
                watchdog.none()
            };
            if let Err(how) = told {
                self.unguarded.get_or_insert(how);
            }
        }
        #[cfg(not(unix))]
        let _ = is_on;
    }

    /// Commands zero force and the end of the session, and waits for the end of its program.
    fn close(&mut self) {
        let zero = Wrench::NONE;
        let sent = self.write(zero);
        let left = self.rest.take();
        if let Some((text, from)) = left {
            let _ = self.channel.send(text.bytes().get(from..).unwrap_or(&[]));
        }
        let _ = self.channel.send(self.channel.zero());
        let _ = self.channel.send(protocol::END);
        self.channel.shut();
        let mut said = Vec::new();
        #[cfg(unix)]
        {
            let ended = self.program.take().and_then(super::process::Program::end);
            if let Some(watchdog) = self.watchdog.take() {
                // Otherwise it commands zero itself.
                if sent.is_ok() || ended.is_some() {
                    watchdog.dismiss();
                }
            }
            if let Some(how) = ended.filter(|_| self.is_gone) {
                said.push(format!("the program of the device has ended: {how}"));
            }
        }
        #[cfg(not(unix))]
        let _ = sent;
        if let Some(why) = self.reason() {
            said.push(format!("the device reported an error: {why}"));
        }
        if let Some(tell) = self.tell.take().filter(|_| !said.is_empty()) {
            (tell.0)(said.join("; "));
        }
    }
}

impl<C: Clock> Device for External<C> {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn read(&mut self) -> Result<Pose, DeviceError> {
        if self.is_gone {
            return Err(gone());
        }
        if !std::mem::replace(&mut self.has_begun, true) {
            self.forget()?;
        }
        let fresh = self.sample(self.period / 2)?;
        if self.clock.now().saturating_sub(self.heard_at) > GIVES_UP_AFTER.max(self.period * 4) {
            let what = if self.account.is_old_by_its_clock() {
                "the device's samples are too old by its clock; if that is wrong, it sends - for the time"
            } else {
                "the device has sent no valid sample for too long"
            };
            return Err(DeviceError::new(DeviceErrorKind::Disconnected, what));
        }
        self.check_watchdog()?;
        fresh.ok_or(DeviceError::new(
            DeviceErrorKind::NothingNew,
            "no new sample from the device",
        ))
    }

    fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError> {
        let given = on_axes(&self.capabilities, wrench);
        let is_on = given != Wrench::NONE;
        if is_on {
            self.check_watchdog()?;
            self.tell_watchdog(true);
            self.check_watchdog()?;
        }
        let number = self.account.sends(self.clock.now());
        let text = protocol::wrench(number, &given, &self.capabilities);
        match self.send(text) {
            Ok(true) => {}
            Ok(false) => {
                self.account.untaken();
                return Err(interrupted("the device does not read its commands"));
            }
            Err(Closed) => {
                self.is_gone = true;
                return Err(gone());
            }
        }
        if !is_on {
            self.tell_watchdog(false);
        }
        if !wrench.is_finite() {
            return Err(refused("the force is not finite"));
        }
        Ok(given)
    }

    fn zero_writer(&mut self) -> Option<Box<dyn ZeroWriter>> {
        struct Zero(Channel);
        impl ZeroWriter for Zero {
            fn write_zero(&mut self) {
                let _ = self.0.send(self.0.zero());
            }
        }
        let channel = self.channel.try_clone().ok()?;
        Some(Box::new(Zero(channel)))
    }

    fn was_cut(&mut self) -> bool {
        #[cfg(unix)]
        if let Some(watchdog) = &self.watchdog {
            return match watchdog.has_cut() {
                Ok(has_cut) => has_cut,
                Err(how) => {
                    self.unguarded.get_or_insert(how);
                    false
                }
            };
        }
        false
    }

    fn connection(&self) -> Option<Connection> {
        Some(self.account.connection())
    }
}

impl<C: Clock> Drop for External<C> {
    fn drop(&mut self) {
        self.close();
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn bytes_without_a_newline_are_taken_in_bounded_parts() {
        use std::io::Write;
        let (ours, mut theirs) = std::os::unix::net::UnixStream::pair().unwrap();
        ours.set_nonblocking(true).unwrap();
        theirs.write_all(&[b'x'; 20 * LONGEST]).unwrap();
        let channel = Channel::Stream(ours);
        let (mut inbox, mut line) = (Inbox::new(), [0; LONGEST]);
        assert_eq!(inbox.next(&channel, &mut line), Ok(None));
        // The rest waits for the next call.
        assert!(channel.receive(&mut [0; 8]).unwrap() > 0);
        theirs.write_all(b"\nread\n").unwrap();
        let found = std::iter::repeat_with(|| inbox.next(&channel, &mut line).unwrap());
        let found: Vec<_> = found.take(5).flatten().collect();
        assert_eq!(found, [None, Some(4)]);
    }
}
