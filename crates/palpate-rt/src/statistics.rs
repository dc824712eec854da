//! Timing statistics of a loop.

use std::time::Duration;

use hdrhistogram::Histogram;
use palpate_record::recording::LoopTime;

/// Upper end of the histogram: 10 s.
const LONGEST: u64 = 10_000_000_000;

/// A histogram of durations that does not allocate after construction. It has three digits up to 10 s; longer
/// durations count as 10 s.
#[derive(Clone, Debug)]
pub struct Durations(Histogram<u64>);

impl Durations {
    /// Creates an empty histogram.
    #[must_use]
    #[allow(clippy::expect_used, reason = "it depends on constants only")]
    pub fn new() -> Self {
        Self(Histogram::new_with_bounds(1, LONGEST, 3).expect("the bounds are in order"))
    }

    /// Adds a duration.
    pub fn add(&mut self, duration: Duration) {
        let nanoseconds = u64::try_from(duration.as_nanos()).unwrap_or(LONGEST);
        self.0.saturating_record(nanoseconds);
    }

    /// Returns the number of durations.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.0.len()
    }

    /// Returns the duration that the fraction `part` of all, 0 to 1, does not exceed.
    #[must_use]
    pub fn quantile(&self, part: f64) -> Duration {
        Duration::from_nanos(self.0.value_at_quantile(part))
    }

    /// Returns the longest duration.
    #[must_use]
    pub fn longest(&self) -> Duration {
        Duration::from_nanos(self.0.max())
    }
}

impl Default for Durations {
    fn default() -> Self {
        Self::new()
    }
}

/// Timing statistics of a loop since its start.
#[derive(Clone, Debug)]
pub struct LoopStatistics {
    /// Number of ticks.
    pub ticks: u64,
    /// Missed and skipped deadlines.
    pub missed_deadlines: u64,
    /// Ticks without a fresh sample.
    pub without_sample: u64,
    /// Ticks whose sample the renderer rejected with a [fault](palpate_core::Fault), which gives zero force.
    pub refused: u64,
    /// Number of consecutive ones at the end of the last tick.
    pub refused_at_end: u64,
    /// Ticks at which the renderer of a world ignored triangles or shell points for lack of room.
    pub crowded: u64,
    /// Ticks at whose end a safety stop kept the motors off.
    pub motors_off: u64,
    /// Duration of the loop, and the part of it without a delivered force. A stall without ticks counts too.
    pub time: LoopTime,
    /// Uninterrupted time without a delivered force at the end of the last tick.
    pub off_at_end: Duration,
    /// Delay of each tick after its deadline.
    pub lateness: Durations,
    /// Duration of each tick from the arrival of the sample to the command.
    pub tick: Durations,
    /// Time of reading the device.
    pub round_trip: Durations,
}

impl LoopStatistics {
    pub(crate) fn new() -> Self {
        Self {
            ticks: 0,
            missed_deadlines: 0,
            without_sample: 0,
            refused: 0,
            refused_at_end: 0,
            crowded: 0,
            motors_off: 0,
            time: LoopTime::default(),
            off_at_end: Duration::ZERO,
            lateness: Durations::new(),
            tick: Durations::new(),
            round_trip: Durations::new(),
        }
    }

    /// Returns the number of elapsed periods, with or without a tick.
    #[must_use]
    pub fn periods(&self) -> u64 {
        self.ticks.saturating_add(self.missed_deadlines)
    }
}
