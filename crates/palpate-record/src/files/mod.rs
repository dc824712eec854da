//! File output and input, independent of the content.
//!
//! - [`atomic`] writes a file completely or not at all; [`outputs`] checks all output files of a command before its
//!   work starts.
//! - [`journal`] keeps work in progress for one program at a time and detects incomplete lines.
//! - [`bounded`] reads a file up to a maximum length; [`inputs`] registers the files that were read.
//! - [`checksum`] detects changed files.

pub mod atomic;
pub mod bounded;
pub mod checksum;
pub mod inputs;
pub mod journal;
mod lock;
pub mod outputs;
