#![no_std]
#![no_main]
#![forbid(unsafe_code)]
//! Renders the committed trace by both methods and prints every tick's bits, over semihosting.

mod emulator;

use cortex_m_rt::entry;
use emulator::{Lines, exit};

#[entry]
fn main() -> ! {
    let seen = palpate_firmware_trace::replay_all(&mut Lines::default());
    exit(seen.is_ok())
}
