//! The benchmark scenes and the random scenes of worlds.
#![allow(clippy::print_stdout)] // what was measured

mod benchmarks;
mod sampled_spring;
