//! The commands, one file or folder each.

pub mod advise;
pub mod calibrate;
pub mod compare;
pub mod completions;
pub mod convert;
pub mod demo;
pub mod devices;
pub mod doctor;
mod hand_replay;
pub mod info;
pub mod live;
pub mod map;
pub mod paper;
pub mod pipe;
pub mod render;
pub mod replay;
pub mod report;
pub mod run;
pub mod simulate;
pub mod suite;
pub mod sweep;
pub mod tune;
pub mod watchdog;
