//! Studies: what methods do over many runs of the sampled loop.
//!
//! Each study takes scenes ([`palpate_scene`]) and methods, runs them on the bench of [`palpate_sim`], and
//! returns the numbers. [`tune`] asks how a method's damping changes its errors, [`heights`] how the start
//! height does, [`suite`] judges methods on plants drawn at random, and [`map`] asks what can be rendered
//! at all. [`sweep`] varies one quantity of a scene, and [`claims`] checks the numbers of the paper.

pub mod advise;
pub mod claims;
pub mod compare;
pub mod heights;
mod json;
pub mod map;
pub mod recording;
pub mod report;
pub mod suite;
pub mod sweep;
pub mod text;
pub mod tune;

pub use json::json;
