//! Real-time haptic loop.
//!
//! ```text
//! clock -> device -> renderer -> safety -> device
//!                        |          |
//!                        +-- tap ---+--> recorder
//! ```
//!
//! A [`ControlLoop`] ticks at absolute deadlines of a [`Clock`](palpate_device::clock::Clock), reads a
//! [`Device`](palpate_device::Device), renders, and commands the wrench limited by [`Safety`](safety::Safety). A
//! running loop does not allocate, lock or block. It sends ticks and events through a [`tap`], for example to a
//! [`Recorder`]. [`realtime`] requests real-time scheduling of the loop's thread and reports refusals. [`LoopThread`]
//! runs the loop on a thread with a supervisor, [`ForeignTicks`] on the thread of another scheduler.
//!
//! ```
//! use palpate_device::clock::SteppedClock;
//! use palpate_study::sim::device::SimulatedDevice;
//! use palpate_rt::safety::SafetyParams;
//! use palpate_rt::ControlLoop;
//! use palpate_scene::method::MethodName;
//! use palpate_scene::ContactFile;
//!
//! # let text = include_str!("../../../experiments/fig2.toml");
//! let scene = ContactFile::parse("fig2.toml", text)?.scene;
//! let clock = SteppedClock::new();
//! let device = SimulatedDevice::new(&scene, clock.clone())?;
//! let rendering = scene.rendering(MethodName::Coupled)?;
//! let mut control = ControlLoop::new(device, clock, rendering, SafetyParams::default())?;
//! for _ in 0..100 {
//!     let row = control.tick();
//!     assert!(row.contact.force_on_device.is_finite()); // [N]
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

// A tick neither panics nor prints; only set-up code may, with a stated reason.
#![warn(
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::print_stderr,
    clippy::unreachable,
    clippy::unwrap_used
)]

mod atomics;
mod bounded_local_world;
mod bounded_world;
mod control_loop;
mod created_energy;
mod deadlines;
mod delivered;
mod driven;
mod fade;
#[allow(
    clippy::disallowed_methods,
    reason = "starts and joins the supervisor; ticks are made in `control_loop`"
)]
mod foreign;
mod held;
mod lateness_watch;
mod metadata;
mod motors_off;
mod note;
#[allow(clippy::disallowed_methods, reason = "runs before the first tick")]
pub mod realtime;
#[allow(
    clippy::disallowed_methods,
    clippy::disallowed_types,
    clippy::panic,
    reason = "runs on its own thread, which may block"
)]
mod recorder;
mod rendering;
pub mod safety;
mod setup;
mod statistics;
mod stop;
mod tally;
mod tap;
#[allow(
    clippy::disallowed_methods,
    clippy::panic,
    reason = "starts and joins threads; ticks are made in `control_loop`"
)]
mod thread;
#[cfg(unix)]
#[allow(
    clippy::disallowed_methods,
    clippy::disallowed_types,
    reason = "starts a process and runs in it; a driver's messages in a tick do not block"
)]
pub mod watchdog;
mod wire;

pub use bounded_local_world::{BoundedLocalWorld, HeldLocal, bounded_local_world};
pub use bounded_world::{Answered, BoundedWorld, Held, WorldSafety};
pub use control_loop::ControlLoop;
pub use foreign::ForeignTicks;
pub use metadata::{NoFrame, OnDevice, frames_of_devices, metadata, metadata_of_devices};
pub use note::{Ending, LoopEvent, Note};
pub use recorder::{Account, Recorder};
pub use rendering::{
    Answer, CHANGE_DURATION, ChangeError, ChangingWorld, DeviceSample, DeviceSamples, FrameError,
    LocalWorld, LowRateSimulator, OneContact, Parameters, Rendered, RenderedWorld, Rendering,
    Renders, Turns, WorldAxis, WorldChangeError, WorldFrame, WorldRows, Worlds, changing_world,
    local_world, parameters,
};
pub use setup::SetupError;
pub use statistics::{Durations, LoopStatistics};
pub use stop::StopFlag;
pub use tap::{Counters, Listener, Message, Tap, tap};
pub use thread::{LoopEnd, LoopThread};
pub use wire::answered;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
