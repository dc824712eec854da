//! The commands, one file or folder each.

pub mod advise;
pub mod completions;
pub mod demo;
pub mod figure;
pub mod map;
pub mod pipe;
pub mod render;
pub mod simulate;
pub mod tune;
