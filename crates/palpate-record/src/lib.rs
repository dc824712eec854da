//! What a loop did, as recordings and tables, and the motions it is given.
//!
//! - `recording`, with the feature of that name, writes and reads what a device really did, tick by
//!   tick, as it happens.
//! - [`run`] writes and reads run files: what a rendering did, sample by sample, with the
//!   configuration that made it.
//! - [`trace`] reads a recorded motion: when the device was where; [`mod@unit`] knows the units of its
//!   positions, and whether a hand can have made it.
//! - [`map`]: what each method can render, in parts or as a whole.
//!
//! Everything is SI; the unit of a column stands in its name (`t_s`, `position_m`). Readers take
//! any [`std::io::Read`] and the name to call it by; a fault in the text is reported with its
//! [`TextPosition`]: file, line, column, byte span and the text around it.

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

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
