#![doc = include_str!("../README.md")]
//!
//! # Overview
//!
//! The sampled loop in simulation, studies of methods over many runs of it, and reports of runs and recordings.
//!
//! [`sim`] runs a scene in closed loop, on recorded motion or in a recorded hand; [`device_loop`] runs a loop on a
//! device. Each study takes scenes ([`palpate_scene`]) and methods, runs them on the bench of [`sim`], and returns
//! the numbers; a study takes scenes of both renderers ([`studied`]). [`tune`] varies a method's damping, [`heights`] the start height, and [`sweep`] one quantity of a
//! scene. [`suite`] evaluates methods on random plants. [`map`] computes which contacts can be rendered, and
//! [`advise`] whether one device can render one contact, and [`impedance`] what a hand
//! feels in it. [`claims`] checks the numbers of the paper. [`calibrate`]
//! measures the parameters of a device, [`calibrated`] calibrates the device of a scene, and [`hand_replay`] replays a
//! recorded hand under another force.
//!
//! Reports are types: [`report::Report`] of runs, [`compare::Comparison`] of runs on several scenes, the reports of
//! the studies (for example `tune::report`), [`recording::report`] of a recording, [`calibration`] of a calibration,
//! and [`card`] of a device. Each has its numbers as fields, a text for a terminal (`Display`), and a JSON with a
//! name and a version ([`json()`]), whose JSON Schema is in `docs/schema`. The feature `schema` makes these schemas
//! (`schemars::JsonSchema`).

pub mod advise;
pub mod calibrate;
pub mod calibrated;
pub mod calibration;
pub mod card;
pub mod claims;
pub mod compare;
pub mod device_loop;
pub mod hand_replay;
pub mod heights;
pub mod impedance;
mod json;
pub mod map;
pub mod recording;
pub mod report;
#[cfg(test)]
mod schemas;
pub mod seeded;
pub mod sim;
pub mod spread;
pub mod studied;
pub mod suite;
pub mod sweep;
pub mod table;
pub mod text;
pub mod tune;
pub mod world;

pub use json::json;
