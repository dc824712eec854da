//! Counts instructions by the system timer: with QEMU's `-icount shift=8` every instruction takes 256 ns, and the timer
//! of its MPS2 boards counts at 25 MHz.

use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;

/// Timer counts per instruction, times ten: 256 ns * 25 MHz * 10.
const TENTHS_PER_INSTRUCTION: u32 = 64;
/// The timer has 24 bits and counts down.
const MASK: u32 = 0x00ff_ffff;

/// The timer, and the count of an empty measurement.
pub struct Clock {
    empty: u32,
}

impl Clock {
    /// Starts the timer, which must have no other user.
    pub fn start(mut timer: SYST) -> Self {
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(MASK);
        timer.clear_current();
        timer.enable_counter();
        let mut clock = Self { empty: 0 };
        clock.empty = clock.instructions(|| {});
        clock
    }

    /// Returns the number of instructions of `call`, at most 2.6 million.
    #[inline(always)]
    pub fn instructions(&self, call: impl FnOnce()) -> u32 {
        let before = now();
        call();
        let after = now();
        let counts = before.wrapping_sub(after) & MASK;
        // The total error of two readings is less than one count, a sixth of an instruction.
        ((10 * counts + TENTHS_PER_INSTRUCTION / 2) / TENTHS_PER_INSTRUCTION)
            .saturating_sub(self.empty)
    }
}

/// Not inlined, so that each reading has the same cost.
#[inline(never)]
fn now() -> u32 {
    SYST::get_current()
}
