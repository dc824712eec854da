#![no_std]
#![no_main]
//! Firmware of a knob with a wall, at 4 kHz, on a board whose motor, sensor, hand and host are emulated.
//!
//! ```text
//!  not to be masked  watchdog, 2 ms without food: outputs off; 4 ms: reset
//!  most urgent       the emulated world, 20 kHz (no part of the firmware)
//!  urgent            supervisor, 2 kHz: has the loop run? food for the watchdog, or outputs off
//!  less urgent       loop, 4 kHz: last duty to the timer, count in, next duty
//!  when idle         nothing: the knob needs no host; in scenes with a wall of the host, the emulated host
//! ```
#![allow(unsafe_code)] // an exception that may interrupt anything is declared unsafe

mod emulated;
mod emulator;
mod example;
#[path = "emulated/handle.rs"]
mod handle;
mod mps2;

use core::sync::atomic::{AtomicI32, AtomicU32, Ordering};

use cortex_m::peripheral::{SCB, SYST};
use cortex_m_rt::{entry, exception};
use emulated::{Host, LEAD, Pins, Stall};
use mps2::{Timer, watchdog};
use palpate::AnyParams;
use palpate_firmware_knob::{
    Answer, HostLine, Knob, LineHold, LineHoldParams, Supervisor, Verdict,
};

const LOOP_RATE: u32 = 4000;

/// Ticks begun by the loop, for the supervisor.
static TICKS: AtomicU32 = AtomicU32::new(0);
/// The duty for the next period, as in the preload register of a PWM timer.
static NEXT_DUTY: AtomicI32 = AtomicI32::new(0);

#[entry]
fn main() -> ! {
    let pins = Pins::get();
    // As after a reset of a chip: outputs off, duty 0.
    pins.is_on.store(false, Ordering::Relaxed);
    pins.duty.store(0, Ordering::Relaxed);
    pins.starts.fetch_add(1, Ordering::Relaxed);
    let Some(core) = cortex_m::Peripherals::take() else {
        emulator::exit(false)
    };
    pins.is_on.store(true, Ordering::Relaxed);
    watchdog::start();
    let [loop_phase, supervisor_phase] =
        [&pins.loop_phase, &pins.supervisor_phase].map(|phase| phase.load(Ordering::Relaxed));
    mps2::start(core, LOOP_RATE, loop_phase, supervisor_phase);
    let mut host = pins.scene().is_of_the_host().then(|| Host::new(pins));
    loop {
        if let Some(host) = &mut host {
            host.look(pins);
        }
        // A real board would sleep here (`wfi`). QEMU 7.2 loses timer interrupts when its core sleeps while
        // instructions are its clock.
        cortex_m::asm::nop();
    }
}

/// What determines the duty.
enum Motor {
    /// The board renders the wall.
    Knob(Knob<AnyParams<f32>>),
    /// The board holds the lines of a host.
    OfHost(LineHold),
}

impl Motor {
    fn new(pins: &Pins) -> Option<Self> {
        let (scene, params) = (pins.scene(), pins.scene().params());
        if !scene.is_of_the_host() {
            return Knob::new(params, scene.method()).ok().map(Self::Knob);
        }
        Some(Self::OfHost(LineHold::new(LineHoldParams {
            period: params.period,
            ticks: pins.host_ticks.load(Ordering::Relaxed),
            lead: LEAD,
            // 20 ms.
            silent_after: 80,
            soft_start: params.soft_start,
            drive: params.drive,
        })))
    }
}

/// The loop.
#[exception]
fn SysTick() {
    static mut MOTOR: Option<Motor> = None;
    static mut WORDS: u32 = 0;

    let pins = Pins::get();
    let duty = NEXT_DUTY.load(Ordering::Relaxed);
    pins.duty.store(duty, Ordering::Relaxed);
    let tick = TICKS.fetch_add(1, Ordering::Relaxed);
    pins.ticks.fetch_add(1, Ordering::Relaxed);
    stall_if_requested(pins);

    let duty = match MOTOR {
        Some(Motor::Knob(knob)) => render(pins, knob, WORDS),
        Some(Motor::OfHost(hold)) => hold_line(pins, hold, tick, WORDS),
        None => {
            // The first tick only creates the knob.
            *MOTOR = Motor::new(pins);
            if MOTOR.is_none() {
                emulator::exit(false);
            }
            return;
        }
    };
    NEXT_DUTY.store(i32::from(duty), Ordering::Relaxed);

    let took = mps2::CLOCK / LOOP_RATE - 1 - SYST::get_current();
    pins.longest.fetch_max(took, Ordering::Relaxed);
    if SCB::is_pendst_pending() {
        pins.overruns.fetch_add(1, Ordering::Relaxed);
    }
}

/// Renders the wall on the board. `seen`: number of the host's messages at the last tick.
fn render(pins: &Pins, knob: &mut Knob<AnyParams<f32>>, seen: &mut u32) -> i16 {
    #[allow(clippy::cast_possible_truncation)] // a counter of 16 bits
    let count = pins.count.load(Ordering::Relaxed) as u16;
    let words = pins.words.load(Ordering::Relaxed);
    let Answer { duty, status } = knob.tick(count, words != *seen);
    *seen = words;
    pins.status.store(status as u32, Ordering::Relaxed);
    duty
}

/// Holds the line of the host, and sends a sample once per period of the host. `seen`: sample of its last message.
fn hold_line(pins: &Pins, hold: &mut LineHold, tick: u32, seen: &mut u32) -> i16 {
    if tick.is_multiple_of(pins.host_ticks.load(Ordering::Relaxed)) {
        pins.sampled_count
            .store(pins.count.load(Ordering::Relaxed), Ordering::Relaxed);
        pins.sampled.store(tick, Ordering::Release);
    }
    let sampled = pins.line_of.load(Ordering::Acquire);
    if sampled != *seen {
        *seen = sampled;
        let [mean, slope] = [&pins.line_mean, &pins.line_slope]
            .map(|pin| f32::from_bits(pin.load(Ordering::Relaxed)));
        hold.take(HostLine {
            sampled,
            mean,
            slope,
        });
    }
    hold.tick(tick)
}

/// Stalls the loop if a test requests it.
fn stall_if_requested(pins: &Pins) {
    let stall = pins.stall.load(Ordering::Relaxed);
    if stall == Stall::Not as u32 {
        return;
    }
    if stall == Stall::Masked as u32 {
        // SAFETY: no critical section is in progress, so none is broken.
        unsafe { cortex_m::register::basepri::write(mps2::MASK_OF_ALL) };
    }
    loop {
        cortex_m::asm::nop();
    }
}

// SAFETY: the handler does not panic on an unknown interrupt, and shares only atomics.
#[exception]
unsafe fn DefaultHandler(interrupt: i16) {
    match Timer::new(interrupt) {
        Some(Timer::World) => {
            Timer::World.acknowledge();
            emulated::resume();
        }
        Some(Timer::Supervisor) => {
            Timer::Supervisor.acknowledge();
            supervise();
        }
        None => outputs_off(),
    }
}

fn supervise() {
    use core::cell::RefCell;
    use cortex_m::interrupt::Mutex;

    static SUPERVISOR: Mutex<RefCell<Supervisor>> = Mutex::new(RefCell::new(Supervisor::new()));
    let ticks = TICKS.load(Ordering::Relaxed);
    let verdict =
        cortex_m::interrupt::free(|token| SUPERVISOR.borrow(token).borrow_mut().look(ticks));
    match verdict {
        Verdict::Alive => watchdog::feed(),
        Verdict::Stalled => outputs_off(),
    }
}

/// Disables the output independently of the loop.
fn outputs_off() {
    Pins::get().is_on.store(false, Ordering::Relaxed);
}

// SAFETY: it shares only an atomic.
#[exception]
unsafe fn NonMaskableInt() {
    outputs_off();
}
