//! Tests of the program with devices and clocks.

#[path = "../it/common/mod.rs"]
mod common;
mod force_dimension;
mod inverse3;
mod live;
mod motor_drive;
mod own;
mod run_several;
mod run_world;
mod running;
mod two_diy;
mod watchdog;
