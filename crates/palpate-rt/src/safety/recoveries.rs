//! A loop that loses its force again and again, and gets it back softly each time, is not one that works.

/// An outage counts where it lasts for as long beyond the two periods that each outage has `[s]`: those of machines that are
/// busy with other programs are shorter.
const BRIEF: f64 = 0.02;

/// How many recoveries are remembered; no more may be let pass.
pub(super) const REMEMBERED: usize = 32;

/// When a loop recovers too often.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecoveryParams {
    /// So many recoveries within the [`window`](Self::window) keep the motors off, 2 to 32; `None`: any number is let pass.
    /// A recovery from an outage of less than 20 ms and two periods, or shorter than what counts as a stall
    /// ([`SafetyParams::stall_after`](crate::safety::SafetyParams::stall_after)), does not count.
    pub too_many: Option<u32>,
    /// Time over which recoveries are counted `[s]`. Where ten soft starts are longer, they count: a loop whose force never
    /// comes back all the way is found, however softly it comes.
    pub window: f64,
}

impl Default for RecoveryParams {
    /// 8 within 2 s. Created energy is not counted while a force comes back, which takes up to 0.2 s: so a force that is
    /// never all there trips.
    fn default() -> Self {
        Self {
            too_many: Some(8),
            window: 2.0,
        }
    }
}

/// Soft starts in which recoveries are counted at least.
const SOFT_STARTS: f64 = 10.0;

/// The recoveries of late.
#[derive(Clone, Debug)]
pub(super) struct Recoveries {
    too_many: Option<usize>,
    window: f64,
    /// Shortest outage that counts `[s]`.
    least: f64,
    /// Time up to the last sample `[s]`.
    now: f64,
    /// For how long there has been no force `[s]`.
    outage: f64,
    /// When the last recoveries were that count `[s]`, the newest first.
    at: [f64; REMEMBERED],
}

impl Recoveries {
    /// For a loop of `period` `[s]` whose force comes in within `soft_start` `[s]`, and that may stand still for `stall_after` `[s]`.
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

    /// A sample came `elapsed` `[s]` after the one before. `was_out`: from that one on there was no force, or the loop stood
    /// still; `is_out`: there is none yet. Whether it is one recovery too many.
    pub fn watch(&mut self, elapsed: f64, was_out: bool, is_out: bool) -> bool {
        self.now += elapsed;
        if was_out {
            self.outage += elapsed;
        }
        // Half a nanosecond for what decimal time stamps lack.
        if is_out || std::mem::take(&mut self.outage) < self.least - 5e-10 {
            return false;
        }
        self.at.rotate_right(1);
        let [newest, ..] = &mut self.at;
        *newest = self.now;
        let oldest = self.too_many.and_then(|most| self.at.get(most - 1));
        oldest.is_some_and(|oldest| self.now - oldest <= self.window)
    }

    /// Forgets what was.
    pub fn forget(&mut self) {
        self.outage = 0.0;
        self.at = [f64::NEG_INFINITY; REMEMBERED];
    }
}
