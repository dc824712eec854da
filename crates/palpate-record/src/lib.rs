#![doc = include_str!("../README.md")]
//!
//! # Overview
//!
//! Recordings and tables of loops and renderings, recorded motions, and file output.
//!
//! - `recording`, with the feature of that name, writes and reads recordings of a device loop, tick by tick, while
//!   the loop runs.
//! - [`run`] writes and reads run files: the samples of a rendering with its configuration.
//! - [`trace`] reads a recorded motion: positions of a device over time. [`mod@unit`] contains the units of positions
//!   and checks whether a motion is plausible for a hand.
//! - [`files`] writes files completely or not at all, and keeps journals of work in progress.
//! - [`map`]: the stability of each method over plants, in parts or as a whole.
//!
//! All quantities are in SI units; a column's name contains its unit (`t_s`, `position_m`). Readers take any
//! [`std::io::Read`] and a name for messages. An error in the text has a [`TextPosition`]: file, line, column, byte
//! span and the surrounding text.

pub mod files;
pub mod map;
#[cfg(feature = "parquet")]
mod parquet_table;
mod place;
#[cfg(feature = "recording")]
pub mod recording;
pub mod run;
pub mod trace;
pub mod unit;

pub use place::TextPosition;
