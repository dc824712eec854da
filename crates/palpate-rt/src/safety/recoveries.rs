//! Detection of a loop that repeatedly loses its force and recovers with a soft start.

/// Minimum duration of an outage that counts, beyond the two periods of every outage `[s]`. Outages caused by other
/// programs on a busy machine are shorter.
const BRIEF: f64 = 0.02;

/// Number of stored recoveries; upper bound of the threshold.
pub(super) const REMEMBERED: usize = 32;

/// Threshold for frequent recoveries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecoveryParams {
    /// Number of recoveries within the [`window`](Self::window) that latches a safety stop, 2 to 32; `None`:
    /// unlimited. A recovery does not count if its outage was shorter than 20 ms plus two periods or than a stall
    /// ([`SafetyParams::stall_after`](crate::safety::SafetyParams::stall_after)).
    pub too_many: Option<u32>,
    /// Time over which recoveries are counted `[s]`, or ten soft-start times if these are longer. A loop whose force
    /// never reaches its full value is therefore detected for any soft-start time.
    pub window: f64,
}

impl Default for RecoveryParams {
    /// Returns 8 within 2 s. Generated energy does not count during a soft start, which takes up to 0.2 s, so a force
    /// that never reaches its full value causes a safety stop.
    fn default() -> Self {
        Self {
            too_many: Some(8),
            window: 2.0,
        }
    }
}

/// Minimum of the counting window, in soft-start times.
const SOFT_STARTS: f64 = 10.0;

/// Recent recoveries.
#[derive(Clone, Debug)]
pub(super) struct Recoveries {
    too_many: Option<usize>,
    window: f64,
    /// Shortest outage that counts `[s]`.
    least: f64,
    /// Time up to the last sample `[s]`.
    now: f64,
    /// Duration of the current outage `[s]`.
    outage: f64,
    /// Times of the last counted recoveries `[s]`, the newest first.
    at: [f64; REMEMBERED],
}

impl Recoveries {
    /// Creates the detector for a loop of `period` `[s]` with a ramp time of `soft_start` `[s]` and a stall limit of
    /// `stall_after` `[s]`.
    pub fn new(params: RecoveryParams, soft_start: f64, period: f64, stall_after: f64) -> Self {
        Self {
            too_many: params.too_many.and_then(|most| usize::try_from(most).ok()),
            window: params.window.max(SOFT_STARTS * soft_start),
            least: stall_after.max(BRIEF + 2.0 * period),
            now: 0.0,
            outage: 0.0,
            at: [f64::NEG_INFINITY; REMEMBERED],
        }
    }

    /// Processes a sample `elapsed` `[s]` after the previous one. `was_out`: no force since the previous sample, or
    /// the loop stalled; `is_out`: no force yet. Returns whether recoveries are too frequent.
    pub fn watch(&mut self, elapsed: f64, was_out: bool, is_out: bool) -> bool {
        self.now += elapsed;
        if was_out {
            self.outage += elapsed;
        }
        // Half a nanosecond allows for the rounding of decimal time stamps.
        if is_out || std::mem::take(&mut self.outage) < self.least - 5e-10 {
            return false;
        }
        self.at.rotate_right(1);
        let [newest, ..] = &mut self.at;
        *newest = self.now;
        let oldest = self.too_many.and_then(|most| self.at.get(most - 1));
        oldest.is_some_and(|oldest| self.now - oldest <= self.window)
    }

    /// Clears all recoveries.
    pub fn forget(&mut self) {
        self.outage = 0.0;
        self.at = [f64::NEG_INFINITY; REMEMBERED];
    }
}
