//! Guarantees of the core; each test is named by its property.
#![allow(clippy::print_stdout)] // what a test measured is part of its answer

mod adversary;
mod changes;
mod common;
mod coupled;
mod damper;
mod desk;
mod faults;
mod geometry;
mod guard;
mod guard_attack;
mod hfcr;
mod ledger;
mod limits;
mod line;
mod measured_period;
mod modified_force;
mod outside;
mod parameters;
mod popc;
mod pressed;
mod readings;
mod resting;
mod rivals;
mod seh;
mod sensor_noise;
#[cfg(feature = "serde")]
mod serde_forms;
mod side_by_side;
mod state;
mod timing;
mod transitions;
