//! What an emulated service does wrong, when it is told to.

use std::collections::VecDeque;
use std::fmt;
use std::time::Duration;

/// Something that goes wrong with one reply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Fault {
    /// It is never sent.
    Dropped,
    /// It is sent twice.
    Twice,
    /// It is sent just before the reply to the next message.
    Late,
    /// The service stands still for this long before it answers.
    Stall(Duration),
    /// What is sent is no JSON.
    Garbage,
    /// It ends in the middle of its JSON.
    HalfFrame,
    /// Half of the bytes of the WebSocket's frame are sent, and the connection is cut.
    HalfBytes,
    /// The connection is cut without a word.
    Disconnect,
    /// The connection is closed as a WebSocket is.
    Close,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Dropped => "the next answer is lost",
            Self::Twice => "the next answer comes twice",
            Self::Late => "the next answer comes with the one after it",
            Self::Stall(lasts) => {
                return write!(f, "the service stands still for {} s", lasts.as_secs_f64());
            }
            Self::Garbage => "the next answer is not JSON",
            Self::HalfFrame => "the next answer ends in the middle of its JSON",
            Self::HalfBytes => "the connection is cut in the middle of the next answer",
            Self::Disconnect => "the connection is cut",
            Self::Close => "the connection is closed",
        })
    }
}

/// Faults that wait for their reply; of each one the next reply is not touched by those behind it.
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

/// How long a message takes through the service: a constant, and on top evenly up to a jitter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Latency {
    /// What every exchange takes.
    pub least: Duration,
    /// What may come on top.
    pub jitter: Duration,
}

impl Latency {
    /// As fast as the machine is.
    pub const NONE: Self = Self {
        least: Duration::ZERO,
        jitter: Duration::ZERO,
    };

    /// The next one, drawn by `random`.
    pub(super) fn draw(self, random: &mut SplitMix64) -> Duration {
        self.least + self.jitter.mul_f64(random.unit())
    }
}

/// Steele, Lea and Flood's generator: the same jitter from the same seed.
#[derive(Debug)]
pub(super) struct SplitMix64(pub u64);

impl SplitMix64 {
    /// Evenly in 0 to 1.
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^= z >> 31;
        (z >> 11) as f64 / (1_u64 << 53) as f64
    }
}
