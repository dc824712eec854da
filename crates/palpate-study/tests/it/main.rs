//! All integration tests of palpate-study, in one binary.

#[path = "../../../palpate-sim/tests/it/common/mod.rs"]
mod common;
mod coupled;
mod decisive;
mod map;
mod paper;
mod real_actuators;
mod suite;
mod tune;
