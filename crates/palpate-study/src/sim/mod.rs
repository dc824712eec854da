//! The sampled-data loop, and replay of recorded motion.
//!
//! This module runs the renderers of [`palpate_core`] on the testbed of [`palpate_testbed`]. It runs a scene
//! ([`palpate_scene`]) in closed loop ([`closed_loop`]), on recorded motion ([`replay`]) or in a recorded hand
//! ([`hand_replay`]) by any method ([`palpate_scene::method`]), and returns the evaluation with the run.
//! [`acausal`] has the force of Eq. (7), which no loop can have, and [`integrated`] other integrators of the object.
//! [`VirtualDevice`] is a scene's device for a loop outside this crate. [`device`] provides it, and a device in a
//! pointer's hand, for real-time loops. [`sampled_loop`] has the single steps of the loop, [`ticks`] its ticks.

pub mod acausal;
pub mod closed_loop;
mod delivery;
pub mod device;
pub mod hand_replay;
pub mod integrated;
mod loop_error;
mod loop_record;
mod own_device;
mod plant;
pub mod replay;
pub mod run;
pub mod sampled_loop;
pub mod ticks;
mod virtual_device;
pub mod world;

pub use own_device::OwnDevice;
pub use virtual_device::VirtualDevice;
