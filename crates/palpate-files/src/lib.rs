//! How files are put on disk, whatever stands in them.
//!
//! - [`atomic`] puts a file on disk whole or not at all; [`outputs`] checks the files of a command
//!   together, before its work starts.
//! - [`journal`] keeps work in progress, one program at a time, and knows which of its lines are whole.
//! - [`bounded`] reads a file up to a stated length; [`inputs`] knows which files were read.
//! - [`checksum`] tells a file that was changed from one that was not.

pub mod atomic;
pub mod bounded;
pub mod checksum;
pub mod inputs;
pub mod journal;
mod lock;
pub mod outputs;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
