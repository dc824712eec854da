//! Receiver thread of the service's frames.

use std::sync::Arc;
use std::thread::Thread;
use std::time::{Duration, Instant};

use palpate_device::clock::Clock;
use triple_buffer::Input;
use tungstenite::{Error, Message, WebSocket};

use super::super::fitness::Unfit;
use super::super::frame::{Frame, FrameError};
use super::address::Half;
use super::link::{Arrival, AtomicCounts, Cause, Fits, Link};

/// Number of successive invalid frames after which the connection is reported as unreadable.
const TOO_MANY: u32 = 100;

/// Reads frames, adds the time of arrival, and passes samples to the loop.
pub(super) struct Reader<C> {
    pub socket: WebSocket<Half>,
    pub clock: C,
    pub device_id: String,
    pub reply_timeout: Duration,
    pub link: Arc<Link>,
    pub samples: Input<Arrival>,
    pub writer: Thread,
    pub handed: u64,
    pub unreadable: u32,
}

impl<C: Clock> Reader<C> {
    /// Reads until the connection ends.
    pub fn run(mut self) {
        let cause = loop {
            match self.socket.read() {
                Ok(Message::Text(text)) => self.take(Some(&text)),
                Ok(Message::Binary(_)) => self.take(None),
                Ok(Message::Close(_)) | Err(Error::ConnectionClosed | Error::AlreadyClosed) => {
                    break Cause::Closed;
                }
                Ok(_) => {}
                Err(Error::Io(error)) if super::is_a_pause(&error) => {}
                Err(_) => break Cause::Cut,
            }
            self.writer.unpark();
        };
        if !self.link.is_ending() {
            self.link.lose(cause);
        }
        self.writer.unpark();
    }

    fn take(&mut self, text: Option<&str>) {
        let (now, time) = (Instant::now(), self.clock.now());
        let counts = &self.link.counts;
        let age = match self.link.comes(now) {
            Fits::Answers(age) => age,
            Fits::Surplus => return AtomicCounts::add(&counts.surplus),
        };
        // The time at which a late answer's position was measured is unknown.
        if age > self.reply_timeout {
            return AtomicCounts::add(&counts.late);
        }
        match text.map(|text| self.read(text)) {
            Some(Ok(Some(position))) => {
                AtomicCounts::add(&counts.fresh);
                counts.round_trip(age);
                self.unreadable = 0;
                self.handed += 1;
                self.samples.write(Arrival {
                    number: self.handed,
                    position,
                    time,
                });
            }
            Some(Ok(None)) => self.link.lose(Cause::DeviceGone),
            Some(Err(_)) | None => {
                AtomicCounts::add(&counts.garbage);
                self.unreadable += 1;
                if self.unreadable == TOO_MANY {
                    self.link.set_unfit(Some(Cause::Unreadable));
                }
            }
        }
    }

    /// Returns the position, or `None` if the frame does not contain the device.
    fn read(&self, text: &str) -> Result<Option<[f64; 3]>, FrameError> {
        let frame = Frame::parse(text)?;
        let Some(device) = frame.device(&self.device_id) else {
            return Ok(None);
        };
        let unfit = Unfit::new(&device.status).map(Cause::from);
        if unfit.is_some() {
            // The position may be missing in this state; report the reason nevertheless.
            self.link.set_unfit(unfit);
        }
        let sample = device.sample()?;
        self.link.set_unfit(unfit);
        Ok(Some(sample.position))
    }
}
