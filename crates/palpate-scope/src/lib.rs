//! A live page on a running loop.
//!
//! A [`Session`] runs one or two loops and listens to them; a [`Server`] serves a page that shows what
//! they do, leads the hand and changes what is rendered. `docs/scope.md` says what page and server
//! tell each other. The loops wait for neither.
//!
//! Without the feature `server` there is only what page and loop tell each other: [`message`], [`rows`] and
//! [`Settings`], for a loop that runs where the page does.

#[cfg(feature = "server")]
mod hub;
pub mod message;
#[cfg(feature = "server")]
mod pace;
pub mod rows;
#[cfg(feature = "server")]
mod server;
#[cfg(feature = "server")]
mod session;
mod settings;
#[cfg(feature = "server")]
mod world;

#[cfg(feature = "server")]
pub use hub::{ClientId, Hub, Outgoing, Seat};
#[cfg(feature = "server")]
pub use server::{DEFAULT_ADDRESS, Home, ListenError, Listening, Server};
#[cfg(feature = "server")]
pub use session::{
    Command, Devices, Ended, LaneEnd, Placed, Receipts, Session, SessionEnd, SessionError, Setup,
    Written,
};
pub use settings::{Limits, Settings, check_lanes, make_room};
#[cfg(feature = "server")]
pub use world::{
    MOST_LANES, OpenLane, WorldEnded, WorldLane, WorldLaneEnd, WorldSession, WorldSessionEnd,
    WorldSetup,
};

#[cfg(all(doctest, feature = "server"))]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
