//! How long bytes travel between a driver and its board.

use std::time::Duration;

/// How long bytes travel between a driver and its board, in either direction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Usb {
    /// Bytes go with the beginning of a frame of this length, as a host controller may do that visits a
    /// device once in 1 ms. None: at any time.
    pub frame: Duration,
    /// What a packet takes until it has been understood, before the frame is waited for.
    pub latency: Duration,
}

impl Usb {
    /// When bytes arrive that were sent at `sent`; both are times since the start of the first frame.
    #[must_use]
    pub fn arrival(&self, sent: Duration) -> Duration {
        let ready = sent + self.latency;
        let Some(frame) = Some(self.frame.as_nanos()).filter(|frame| *frame > 0) else {
            return ready;
        };
        let into = ready.as_nanos() % frame;
        let wait = if into == 0 { 0 } else { frame - into };
        ready + Duration::from_nanos(u64::try_from(wait).unwrap_or(u64::MAX))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_wait_for_their_latency_and_then_for_a_frame() {
        let us = Duration::from_micros;
        let arrival = |frame, latency, sent| {
            let (frame, latency) = (us(frame), us(latency));
            Usb { frame, latency }.arrival(us(sent))
        };
        assert_eq!(arrival(0, 0, 1234), us(1234));
        assert_eq!(arrival(0, 100, 1234), us(1334));
        assert_eq!(arrival(1000, 100, 1234), us(2000));
        assert_eq!(arrival(1000, 0, 2000), us(2000));
        assert_eq!(arrival(1000, 1, 2000), us(3000));
    }
}
