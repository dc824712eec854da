//! Counts instructions by the system timer: QEMU's `-icount shift=8` lets every instruction take 256 ns,
//! and the timer of its MPS2 boards counts 25 MHz.

use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;

/// Timer counts per instruction, times ten: 256 ns * 25 MHz * 10.
const TENTHS_PER_INSTRUCTION: u32 = 64;
/// The timer has 24 bits and counts down.
const MASK: u32 = 0x00ff_ffff;

/// The timer, and what a measurement of nothing counts.
pub struct Clock {
    empty: u32,
}

impl Clock {
    /// Starts the timer. Nothing else may use it.
    pub fn start(mut timer: SYST) -> Self {
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(MASK);
        timer.clear_current();
        timer.enable_counter();
        let mut clock = Self { empty: 0 };
        clock.empty = clock.instructions(|| {});
        clock
    }

    /// Instructions that `call` runs, at most 2.6 million.
    #[inline(always)]
    pub fn instructions(&self, call: impl FnOnce()) -> u32 {
        let before = now();
        call();
        let after = now();
        let counts = before.wrapping_sub(after) & MASK;
        // Two readings are off by less than one count together, a sixth of an instruction.
        ((10 * counts + TENTHS_PER_INSTRUCTION / 2) / TENTHS_PER_INSTRUCTION)
            .saturating_sub(self.empty)
    }
}

/// A call of its own, so that a reading costs the same wherever it stands.
#[inline(never)]
fn now() -> u32 {
    SYST::get_current()
}
