#![doc = include_str!("../README.md")]

pub mod figure;
#[cfg(feature = "results")]
mod results;

#[cfg(feature = "results")]
pub use results::*;
