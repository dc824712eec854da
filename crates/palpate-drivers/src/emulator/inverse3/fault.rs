//! Injected faults of an emulated service.

use std::collections::VecDeque;
use std::fmt;
use std::time::Duration;

/// Fault of one reply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Fault {
    /// The reply is lost.
    Dropped,
    /// The reply is sent twice.
    Twice,
    /// The reply is sent just before the reply to the next message.
    Late,
    /// The service stalls for this time before it answers.
    Stall(Duration),
    /// The reply is not JSON.
    Garbage,
    /// The reply ends in the middle of its JSON.
    HalfFrame,
    /// Half of the bytes of the WebSocket frame are sent, and the connection is cut.
    HalfBytes,
    /// The connection is cut without a closing handshake.
    Disconnect,
    /// The connection is closed with a WebSocket closing handshake.
    Close,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Dropped => "the next answer is lost",
            Self::Twice => "the next answer is sent twice",
            Self::Late => "the next answer is sent together with its successor",
            Self::Stall(lasts) => {
                return write!(f, "the service stalls for {} s", lasts.as_secs_f64());
            }
            Self::Garbage => "the next answer is not JSON",
            Self::HalfFrame => "the next answer ends in the middle of its JSON",
            Self::HalfBytes => "the connection is cut in the middle of the next answer",
            Self::Disconnect => "the connection is cut",
            Self::Close => "the connection is closed",
        })
    }
}

/// Pending faults; each reply takes at most one.
#[derive(Debug, Default)]
pub(super) struct Faults(VecDeque<Fault>);

impl Faults {
    pub fn push(&mut self, fault: Fault) {
        self.0.push_back(fault);
    }

    pub fn next(&mut self) -> Option<Fault> {
        self.0.pop_front()
    }
}

/// Latency of a message through the service: a constant plus a uniform jitter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Latency {
    /// Constant part.
    pub least: Duration,
    /// Largest jitter.
    pub jitter: Duration,
}

impl Latency {
    /// No added latency.
    pub const NONE: Self = Self {
        least: Duration::ZERO,
        jitter: Duration::ZERO,
    };

    /// Draws a latency with `random`.
    pub(super) fn draw(self, random: &mut SplitMix64) -> Duration {
        self.least + self.jitter.mul_f64(random.unit())
    }
}

/// Generator of Steele, Lea and Flood: the same seed gives the same jitter.
#[derive(Debug)]
pub(super) struct SplitMix64(pub u64);

impl SplitMix64 {
    /// Returns a uniform number from 0 to 1.
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^= z >> 31;
        (z >> 11) as f64 / (1_u64 << 53) as f64
    }
}
