//! The commands, one file each.

pub mod compare;
pub mod completions;
pub mod demo;
pub mod figure;
pub mod pipe;
pub mod render;
pub mod simulate;
pub mod tune;
