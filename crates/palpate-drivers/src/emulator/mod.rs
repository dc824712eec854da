//! Emulators of devices, which test the drivers of `palpate-drivers` without a device.
//!
//! An emulator speaks the device's protocol on a pseudo-terminal or on loopback sockets, or is its manufacturer's library,
//! and moves a simulated device in real time. It is a separate crate, so a program for a real device contains no simulator.

#[cfg(unix)]
pub mod drive;
#[cfg(unix)]
pub mod force_dimension;
pub mod inverse3;
#[cfg(unix)]
pub mod port;
#[cfg(unix)]
pub mod two_diy;
