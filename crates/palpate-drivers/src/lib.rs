#![doc = include_str!("../README.md")]
//!
//! # Overview
//!
//! Drivers of haptic devices for a palpate loop. The module `emulator`, with the
//! feature of that name, contains an emulator of each; [`prepared`] prepares devices for a loop.

mod device_time;
#[cfg(unix)]
pub mod drive;
#[cfg(feature = "emulator")]
pub mod emulator;
pub mod external;
pub mod force_dimension;
pub mod inverse3;
pub mod plugin;
pub mod prepared;
#[cfg(unix)]
mod serial;
pub mod two_diy;
