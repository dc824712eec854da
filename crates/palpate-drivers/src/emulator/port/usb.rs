//! Transmission times between a driver and its board.

use std::time::Duration;

/// Transmission times between a driver and its board, in either direction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Usb {
    /// Bytes are sent at the beginning of a frame of this length, as by a host controller that polls a device once per
    /// millisecond. Zero: at any time.
    pub frame: Duration,
    /// Processing time of a packet, before it waits for a frame.
    pub latency: Duration,
}

impl Usb {
    /// Returns the arrival time of bytes sent at `sent`; both are times since the start of the first frame.
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
