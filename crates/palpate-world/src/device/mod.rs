//! Devices of a world: samples, tracking of the tool, prediction, commands, and the guard.

pub(crate) mod commands;
pub(crate) mod guard;
pub(crate) mod observer;
pub(crate) mod params;
pub(crate) mod sample;
pub(crate) mod tracking;
pub(crate) mod turning_observer;
