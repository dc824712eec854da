//! Devices made ready for a loop: where a contact or a world stands in them, a Haply 2DIY opened with its guardian and
//! let go of in the end, an Inverse3 that says how its connection was, a device that is waited for when it has gone.
//!
//! Flags, their messages, and what is said to whom are the caller's.

pub mod inverse3;
mod placed;
mod reconnecting;
#[cfg(unix)]
pub mod trial;
#[cfg(unix)]
pub mod two_diy;

pub use placed::{Axis, FIRST_AXIS, PlaceError, Placed, WorldPlaceError, axis, world_frame};
pub use reconnecting::{Reconnecting, Reopen};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
