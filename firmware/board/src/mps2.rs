//! The timers and the watchdog of the MPS2 boards (Arm's CMSDK APB timer and APB watchdog), at 25 MHz, and the
//! interrupt priorities.
#![allow(unsafe_code)] // it writes to registers

use cortex_m::interrupt::InterruptNumber;
use cortex_m::peripheral::scb::SystemHandler;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{NVIC, Peripherals, SYST};

/// Counts per second of every timer and of the watchdog.
pub const CLOCK: u32 = 25_000_000;
const TIMER_0: usize = 0x4000_0000;
const TIMER_1: usize = 0x4000_1000;
const WATCHDOG: usize = 0x4000_8000;

/// The timers' interrupts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Timer {
    /// Advances the emulated world.
    World,
    /// Monitors the loop.
    Supervisor,
}

// SAFETY: the numbers are those of the boards' manual, and constant for each value.
unsafe impl InterruptNumber for Timer {
    fn number(self) -> u16 {
        match self {
            Self::World => 8,
            Self::Supervisor => 9,
        }
    }
}

/// Priority that masks supervisor and loop, but not the world.
pub const MASK_OF_ALL: u8 = 0x40;

fn write(base: usize, offset: usize, value: u32) {
    let register = core::ptr::with_exposed_provenance_mut::<u32>(base + offset);
    // SAFETY: called in this module only, with registers of the boards' timers and watchdog, which are not memory.
    unsafe { register.write_volatile(value) };
}

impl Timer {
    fn base(self) -> usize {
        match self {
            Self::World => TIMER_0,
            Self::Supervisor => TIMER_1,
        }
    }

    /// Starts the interrupt with `rate` per second, first after a period plus `phase` counts.
    fn start(self, rate: u32, phase: u32) {
        let (control, value, reload) = (0x0, 0x4, 0x8);
        write(self.base(), reload, CLOCK / rate - 1);
        write(self.base(), value, CLOCK / rate - 1 + phase);
        // Enables counting and interrupts.
        write(self.base(), control, 0b1001);
    }

    /// Clears the interrupt, in its handler.
    pub fn acknowledge(self) {
        write(self.base(), 0xC, 1);
    }

    /// Returns the timer of an interrupt.
    pub fn new(interrupt: i16) -> Option<Self> {
        [Self::World, Self::Supervisor]
            .into_iter()
            .find(|timer| i16::try_from(timer.number()) == Ok(interrupt))
    }
}

/// Starts all interrupts in order of priority: world, supervisor, and the loop by the system timer. `loop_rate` is in
/// Hz. The phases, in counts of the timer, delay the first tick of the loop and the first check of the supervisor.
pub fn start(mut core: Peripherals, loop_rate: u32, loop_phase: u32, supervisor_phase: u32) {
    // SAFETY: no code here relies on a critical section by priorities.
    unsafe {
        core.NVIC.set_priority(Timer::World, 0x00);
        core.NVIC.set_priority(Timer::Supervisor, MASK_OF_ALL);
        core.SCB.set_priority(SystemHandler::SysTick, 0x80);
    }
    Timer::World.start(20_000, 0);
    Timer::Supervisor.start(loop_rate / 2, supervisor_phase);
    core.SYST.set_clock_source(SystClkSource::Core);
    core.SYST.set_reload(CLOCK / loop_rate - 1 + loop_phase);
    core.SYST.clear_current();
    core.SYST.enable_interrupt();
    core.SYST.enable_counter();
    // The counter loads a new reload value when it wraps, so only the first period has the phase.
    while SYST::get_current() == 0 {}
    core.SYST.set_reload(CLOCK / loop_rate - 1);
    // SAFETY: their handlers exist, and their shared data is not in use yet.
    unsafe {
        NVIC::unmask(Timer::World);
        NVIC::unmask(Timer::Supervisor);
    }
}

/// The watchdog: the first timeout raises a non-maskable interrupt, the second one resets the chip.
pub mod watchdog {
    use super::{CLOCK, WATCHDOG, write};

    const UNLOCK: u32 = 0x1ACC_E551;

    /// Starts the watchdog, with a timeout of 2 ms.
    pub fn start() {
        let (load, control, lock) = (0x0, 0x8, 0xC00);
        write(WATCHDOG, lock, UNLOCK);
        write(WATCHDOG, load, CLOCK / 500);
        // Interrupt and reset.
        write(WATCHDOG, control, 0b11);
        write(WATCHDOG, lock, 0);
    }

    /// Stops the watchdog: at the end of a run the emulated world prints for longer than a timeout.
    pub fn stop() {
        let (control, lock) = (0x8, 0xC00);
        write(WATCHDOG, lock, UNLOCK);
        write(WATCHDOG, control, 0);
        write(WATCHDOG, lock, 0);
    }

    /// Restarts the timeout.
    pub fn feed() {
        let (clear, lock) = (0xC, 0xC00);
        write(WATCHDOG, lock, UNLOCK);
        write(WATCHDOG, clear, 1);
        write(WATCHDOG, lock, 0);
    }
}
