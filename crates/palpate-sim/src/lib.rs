//! Scene files, the sampled-data loop, and replay of recorded motion.
//!
//! This crate puts the renderers of [`palpate`] on the bench of [`palpate_testbed`]: it reads what
//! a scene is ([`scene`]), runs it closed loop ([`closed_loop`]), on recorded motion ([`replay`]) or
//! in a recorded hand ([`hand_replay`]) by any method ([`method`]), and hands the bench's judgement back
//! with the run. [`VirtualDevice`] is a scene's device for a loop outside this crate.
//! [`tune`] asks how a method's damping changes that judgement, [`heights`] how the start height
//! does, [`suite`] judges methods on plants drawn at random, and [`map`] asks what can be rendered
//! at all. [`sweep`] varies one quantity of a scene, and [`claims`] checks the numbers of the paper.

pub mod claims;
pub mod closed_loop;
pub mod hand_replay;
pub mod heights;
pub mod map;
pub mod method;
pub mod named_parameters;
mod plant;
pub mod replay;
pub mod run;
mod sampled_loop;
pub mod scene;
pub mod suite;
pub mod sweep;
pub mod tune;
mod virtual_device;

pub use virtual_device::VirtualDevice;
