//! Emulators of Haply's devices, to try the drivers of `palpate-haply` without a device.
//!
//! An emulator speaks the device's protocol on a pseudo-terminal or on loopback sockets, and moves a
//! simulated device in real time. It is apart from the drivers, so that a program on a real device
//! contains no simulator.

pub mod inverse3;
#[cfg(unix)]
pub mod two_diy;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
