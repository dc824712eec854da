#![forbid(unsafe_code)]
//! What runs the firmware in an emulator, and what is compared, counted and drawn.

pub mod counted;
#[cfg(feature = "figure")]
pub mod drawn;
pub mod qemu;
pub mod ran;
pub mod trace;
