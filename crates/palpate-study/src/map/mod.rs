//! What can be rendered: the energy growth, the force error and the rest of every method over
//! (kappa, Kc) = (K T²/m, K T²/M).
//!
//! A cell of the map is a [`Bounce`]: an object falls onto the device and bounces. It is run from
//! [`PHASES`] start heights by every method. Then the same object and device begin near their place of
//! rest, and [`Stay`] says whether the contact stays there. The loop keeps no record, so a tick
//! allocates nothing and a map of a million runs takes a minute or two; it takes its steps where
//! [`Bench`](palpate_sim::closed_loop::Bench) takes them.
//!
//! A cell's scene follows from its index alone. There are no random numbers, so a map is the same
//! on any number of threads and in any number of pieces.

mod bounce;
pub mod bounds;
mod cell;
mod compute;
mod grid;
mod growth;
mod job;
mod limits;
mod reach;
pub mod receipt;
pub mod report;
mod rows;
mod stay;
mod trial;

pub use bounce::default_settings;
pub use bounce::{Bounce, BounceDevice, BounceError, Forces, Plant};
pub use cell::{CellResult, Entry, MethodResult, Summary};
pub use compute::{Done, compute};
pub use grid::{Cell, MapParams, ParamsError};
pub use growth::{Class, STABLE_UP_TO, classify};
pub use job::{Computed, MapFollower, MapJob, MapJobError};
pub use limits::{Limit, SEARCHED};
pub use reach::{MethodReach, Reach};
pub use stay::{PRESSED_WITH, RESTS_BELOW, Stay};
pub use trial::Outcome;

/// Start heights of every cell, evenly spaced.
pub const PHASES: usize = 16;

/// The outermost start heights, relative to the scene's own gap between device and object.
pub const PHASE_RANGE: f64 = 0.05;

/// Collisions of the ideal over which the growth of energy is observed.
pub const GROWTH_COLLISIONS: usize = 20;

/// Collisions of the ideal over which the error of the force is observed.
pub const ERROR_COLLISIONS: usize = 3;
