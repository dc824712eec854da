//! Lines on a serial port.

use std::path::Path;
use std::time::{Duration, Instant};

use rustix::io::Errno;

use super::text::Text;
use crate::serial::{Gone, Serial};

/// Longest line that a drive sends.
const LONGEST: usize = 256;

/// Reason for not sending.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unsent {
    /// The port accepts no bytes.
    Full,
    /// The port is gone.
    Gone,
}

/// A serial port with lines of text in both directions.
#[derive(Debug)]
pub struct Wire {
    serial: Serial,
    /// A received line without its end.
    line: [u8; LONGEST],
    length: usize,
    /// Whether the beginning of the line is unknown or did not fit.
    is_torn: bool,
    outgoing: Text,
    /// Number of its bytes that were sent.
    sent: usize,
}

impl Wire {
    pub(super) fn open(path: &Path) -> Result<Self, Errno> {
        Ok(Self {
            serial: Serial::open(path)?,
            line: [0; LONGEST],
            length: 0,
            is_torn: false,
            outgoing: Text::default(),
            sent: 0,
        })
    }

    /// Sends the lines that `write` writes. Lines that were begun are completed first; if the port does not accept them,
    /// the new ones are dropped.
    pub(super) fn send(&mut self, write: impl FnOnce(&mut Text)) -> Result<(), Unsent> {
        self.send_rest()?;
        self.outgoing = Text::default();
        self.sent = 0;
        write(&mut self.outgoing);
        match self.send_rest() {
            // The next call sends the rest.
            Err(Unsent::Full) if self.sent > 0 => Ok(()),
            sent => {
                if sent.is_err() {
                    self.outgoing = Text::default();
                    self.sent = 0;
                }
                sent
            }
        }
    }

    fn send_rest(&mut self) -> Result<(), Unsent> {
        loop {
            let rest = self.outgoing.since(self.sent);
            if rest.is_empty() {
                return Ok(());
            }
            match self.serial.write(rest) {
                Ok(0) => return Err(Unsent::Full),
                Ok(written) => self.sent += written,
                Err(Gone) => return Err(Unsent::Gone),
            }
        }
    }

    /// Sends what was begun, for at most `limit`. Not for use in the loop.
    pub(super) fn flush(&mut self, limit: Duration) -> Result<(), Unsent> {
        let begun = Instant::now();
        loop {
            match self.send_rest() {
                Err(Unsent::Full) if begun.elapsed() < limit => {
                    self.serial.wait_writable(Duration::from_millis(1));
                }
                sent => return sent,
            }
        }
    }

    /// Waits for input, at most `limit`.
    pub(super) fn wait(&self, limit: Duration) {
        self.serial.wait_readable(limit);
    }

    /// Passes all complete received lines to `take`.
    pub(super) fn lines(&mut self, mut take: impl FnMut(&[u8])) -> Result<(), Gone> {
        let mut bytes = [0; 256];
        // Bounded, whatever the other end sends.
        for _ in 0..32 {
            let read = self.serial.read(&mut bytes)?;
            for byte in bytes.iter().take(read) {
                if matches!(byte, b'\r' | b'\n') {
                    let line = self.line.get(..self.length).unwrap_or_default();
                    if self.is_torn {
                        take(b"?");
                    } else if !line.is_empty() {
                        take(line);
                    }
                    self.length = 0;
                    self.is_torn = false;
                } else if let Some(place) = self.line.get_mut(self.length) {
                    *place = *byte;
                    self.length += 1;
                } else {
                    self.is_torn = true;
                }
            }
            if read < bytes.len() {
                break;
            }
        }
        Ok(())
    }

    /// Sends lines, and waits for one that `take` accepts, for at most `limit`. `Ok(None)`: there was none. Not for use
    /// in the loop.
    ///
    /// # Errors
    /// The port is gone.
    pub fn exchange<T>(
        &mut self,
        write: impl FnOnce(&mut Text),
        limit: Duration,
        mut take: impl FnMut(&[u8]) -> Option<T>,
    ) -> Result<Option<T>, PortGone> {
        let begun = Instant::now();
        if self.flush(limit) == Err(Unsent::Gone) || self.send(write) == Err(Unsent::Gone) {
            return Err(PortGone);
        }
        loop {
            if self.flush(limit) == Err(Unsent::Gone) {
                return Err(PortGone);
            }
            let mut found = None;
            let heard = self.lines(|line| {
                if found.is_none() {
                    found = take(line);
                }
            });
            if heard.is_err() {
                return Err(PortGone);
            }
            if found.is_some() || begun.elapsed() >= limit {
                return Ok(found);
            }
            self.wait(Duration::from_millis(5));
        }
    }
}

/// The port is gone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PortGone;
