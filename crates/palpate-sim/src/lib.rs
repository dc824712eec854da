//! The sampled-data loop, and replay of recorded motion.
//!
//! This crate puts the renderers of [`palpate`] on the bench of [`palpate_testbed`]: it runs a scene
//! ([`palpate_scene`]) closed loop ([`closed_loop`]), on recorded motion ([`replay`]) or in a recorded
//! hand ([`hand_replay`]) by any method ([`palpate_scene::method`]), and hands the bench's judgement back
//! with the run. [`VirtualDevice`] is a scene's device for a loop outside this crate, and [`device`] has it, and one
//! in a pointer's hand, as devices of a loop that runs in time.
//! [`tune`] asks how a method's damping changes that judgement, [`heights`] how the start height
//! does, [`suite`] judges methods on plants drawn at random, and [`map`] asks what can be rendered
//! at all. [`sweep`] varies one quantity of a scene, and [`claims`] checks the numbers of the paper.

pub mod claims;
pub mod closed_loop;
pub mod device;
pub mod hand_replay;
pub mod heights;
pub mod map;
mod own_device;
mod plant;
pub mod replay;
pub mod run;
mod sampled_loop;
pub mod suite;
pub mod sweep;
pub mod tune;
mod virtual_device;

pub use own_device::OwnDevice;
pub use virtual_device::VirtualDevice;
