//! How the loop kept time.

use std::time::Duration;

use hdrhistogram::Histogram;
use palpate_record::recording::LoopTime;

/// Longest time that is told apart: 10 s.
const LONGEST: u64 = 10_000_000_000;

/// A histogram of durations that never allocates once it is made: three digits of every duration
/// up to 10 s, and what is longer counts as that.
#[derive(Clone, Debug)]
pub struct Durations(Histogram<u64>);

impl Durations {
    /// None yet.
    #[must_use]
    #[allow(clippy::expect_used, reason = "it depends on constants only")]
    pub fn new() -> Self {
        Self(Histogram::new_with_bounds(1, LONGEST, 3).expect("the bounds are in order"))
    }

    /// Counts one more.
    pub fn add(&mut self, duration: Duration) {
        let nanoseconds = u64::try_from(duration.as_nanos()).unwrap_or(LONGEST);
        self.0.saturating_record(nanoseconds);
    }

    /// How many there are.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.0.len()
    }

    /// The duration that `part` of all do not exceed, 0 to 1.
    #[must_use]
    pub fn quantile(&self, part: f64) -> Duration {
        Duration::from_nanos(self.0.value_at_quantile(part))
    }

    /// The longest.
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

/// How the loop kept time, since its start.
#[derive(Clone, Debug)]
pub struct LoopStatistics {
    /// Ticks.
    pub ticks: u64,
    /// Deadlines that were missed, and skipped.
    pub missed_deadlines: u64,
    /// Ticks that found no fresh sample.
    pub without_sample: u64,
    /// Ticks whose sample the renderer has refused by a [fault](palpate::Fault): it asked for no force.
    pub refused: u64,
    /// How many of them there were in a row when the last tick ended.
    pub refused_at_end: u64,
    /// Ticks at whose end a trip of the safety kept the motors off.
    pub motors_off: u64,
    /// How long it ran, and for how much of that no force was delivered: a stall, in which there are no
    /// ticks, counts too.
    pub time: LoopTime,
    /// For how long no force had been delivered when the last tick ended, without a break.
    pub off_at_end: Duration,
    /// How long after its deadline a tick began.
    pub lateness: Durations,
    /// How long a tick took, from the sample's arrival to the force's.
    pub tick: Durations,
    /// How long the device took to give its sample.
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
            motors_off: 0,
            time: LoopTime::default(),
            off_at_end: Duration::ZERO,
            lateness: Durations::new(),
            tick: Durations::new(),
            round_trip: Durations::new(),
        }
    }

    /// Periods that are over, with a tick or without.
    #[must_use]
    pub fn periods(&self) -> u64 {
        self.ticks.saturating_add(self.missed_deadlines)
    }
}
