#![doc = include_str!("../README.md")]
//!
//! # Overview
//!
//! Drivers of haptic devices for a palpate loop. The module `emulator`, with the
//! feature of that name, contains an emulator of each; [`prepared`] prepares devices for a loop.

#[cfg(feature = "emulator")]
pub mod emulator;
pub mod inverse3;
pub mod prepared;
pub mod two_diy;
