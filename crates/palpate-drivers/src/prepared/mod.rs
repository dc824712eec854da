//! Ready-made devices for a loop: the position of a contact or a world in a device's workspace, a Haply 2DIY with its
//! watchdog process and an orderly shutdown, an Inverse3 that reports connection faults, and a wrapper that
//! reconnects a lost device.
//!
//! The caller defines the flags, their messages and the recipients of reports.

#[cfg(unix)]
mod guard;
pub mod inverse3;
mod on_axes;
mod placed;
mod reconnecting;
#[cfg(unix)]
pub mod trial;
#[cfg(unix)]
pub mod two_diy;

#[cfg(unix)]
pub use guard::Guard;
pub use on_axes::on_axes;
pub use placed::{Axis, FIRST_AXIS, PlaceError, Placed, WorldPlaceError, axis, world_frame};
pub use reconnecting::{Reconnecting, Reopen};
