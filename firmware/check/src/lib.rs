#![forbid(unsafe_code)]
//! Runs the firmware in an emulator, and compares, counts and draws its results.

pub mod counted;
#[cfg(feature = "figure")]
pub mod drawn;
pub mod qemu;
pub mod ran;
pub mod trace;
