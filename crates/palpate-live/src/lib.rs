// The example of the README needs the server.
#![cfg_attr(feature = "server", doc = include_str!("../README.md"))]
//!
//! # Overview
//!
//! Live web page for a running loop.
//!
//! A [`Session`] runs one or two loops and receives their ticks. A [`Server`] serves a page that shows them, moves the
//! hand and changes the rendering. `docs/reference/live-protocol.md` describes the protocol between page and server.
//! The loops never wait for either.
//!
//! Without the feature `server` the crate has only the protocol: [`message`], [`rows`] and [`Settings`], for a loop
//! that runs in the page itself.

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
    Command, Devices, Ended, LaneEnd, MetadataOf, Placed, Session, SessionEnd, SessionError, Setup,
    Written,
};
pub use settings::{Limits, Settings, check_lanes, make_room};
#[cfg(feature = "server")]
pub use world::{
    MAX_LANES, OpenLane, WorldEnded, WorldLane, WorldLaneEnd, WorldSession, WorldSessionEnd,
    WorldSetup,
};
