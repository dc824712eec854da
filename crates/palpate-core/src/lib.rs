#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]
//! Energy-consistent haptic contact rendering.
//!
//! A haptic device samples its position and holds a force between samples. A sampled spring therefore generates energy
//! if the virtual object is stiff or light. For each sample, this crate computes the contact force with a virtual
//! object of finite mass or a wall, by the methods of *Energy-Consistent Haptic Rendering of Contact Forces* (IROS
//! 2013, DOI 10.1109/IROS.2013.6697005; "the paper", whose equation numbers are used). An energy ledger records the
//! leak of each method.
//!
//! ```
//! use palpate_core::{Contact, HfcrParams, LoopParams, ObjectState, Renderer, Sample};
//!
//! let contact = Contact::object(400.0, 0.1); // [N/m], [kg]
//! let loop_params = LoopParams::new(0.001).with_force_limit(20.0); // [s], [N]
//! let renderer = Renderer::new(contact, loop_params, HfcrParams::default())?;
//! let mut state = renderer.start(ObjectState::at_rest(0.05))?;
//! for tick in 0..1000 {
//!     let device_position = 1e-4 * f64::from(tick); // read the device here [m]
//!     let output = renderer.step(&mut state, Sample::at(device_position));
//!     let _command_this = output.force_on_device; // [N]
//! }
//! println!("energy created: {} J", state.ledger().held_leak.accumulated);
//! # Ok::<(), palpate_core::ParameterError>(())
//! ```
//!
//! # Signs
//!
//! Everything is along one axis, in SI units. The object lies on the positive side of the device
//! unless [`Side::Negative`] says otherwise.
//!
//! ```text
//!            device xi            object eta
//!  ------------>|                    |==========>    + axis
//!               penetration p = xi - eta, contact while p > 0
//!               f > 0 pushes the object to the right; the device receives -f
//! ```
//!
//! # Parameters and state
//!
//! A [`Renderer`] is created once from checked parameters and never changes. A [`State`] is small and `Copy`.
//! [`Renderer::step`] is total: it does not panic, allocate, block, or loop without bound, and its output is finite for
//! any input.
//!
//! # Features
//!
//! `serde` makes every parameter type serialisable.

mod actuation;
mod actuator;
mod along_axis;
mod contact;
mod difficulty;
mod energy;
mod guard;
mod motion;
mod parameter;
mod relative_motion;
mod render;
mod rendering;
mod response;
mod sample;
mod scalar;
mod transition;

pub use actuation::{Actuation, Hold, LARGEST_DELAY, Transmission};
pub use actuator::{
    Actuator, Ahead, Command, Governed, Held, Impulse, Pending, Piece, UnderWay, Uneven,
};
pub use along_axis::AlongAxis;
pub use contact::{Contact, LoopParams, Mass, Side};
pub use difficulty::Difficulty;
pub use energy::{Leak, Ledger};
pub use guard::{Guard, GuardParams, HandBound, HandLimit};
pub use motion::{Displacement, ObjectMotion, ObjectState, Rule, Start};
pub use parameter::{
    Allowed, Parameter, ParameterError, ParameterName, ParameterValue, Range, Unit,
};
pub use render::*;
pub use rendering::{CHANGE_DURATION, Change, ChangeError, Rendering, Running};
pub use sample::{Fault, Limited, Output, Phase, Sample};
pub use scalar::Scalar;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
