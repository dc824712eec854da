//! Map of renderable contacts: energy growth, force error and rest of every method over (kappa, Kc) = (K T²/m, K
//! T²/M).
//!
//! A cell of the map is a [`Bounce`]: an object falls onto the device and bounces. Every method runs it from
//! [`PHASES`] start heights. Then the same object and device start near their equilibrium, and [`Stay`] measures
//! whether the contact comes to rest. The loop stores no samples, so a tick allocates nothing and a map of a million
//! runs takes a minute or two. Its steps are those of [`Bench`](crate::sim::closed_loop::Bench).
//!
//! A cell's scene follows from its index alone. There are no random numbers, so a map is independent of the number of
//! threads and of shards.

mod bounce;
pub mod bounds;
mod cell;
mod compute;
mod grid;
mod growth;
mod job;
mod limits;
pub mod metadata;
mod reach;
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

/// Number of start heights of every cell, evenly spaced.
pub const PHASES: usize = 16;

/// The outermost start heights, relative to the scene's own gap between device and object.
pub const PHASE_RANGE: f64 = 0.05;

/// Number of collisions of the ideal for the energy growth.
pub const GROWTH_COLLISIONS: usize = 20;

/// Number of collisions of the ideal for the force error.
pub const ERROR_COLLISIONS: usize = 3;
