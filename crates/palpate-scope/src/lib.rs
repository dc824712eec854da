//! A live page on a running loop.
//!
//! A [`Session`] runs one or two loops and listens to them; a [`Server`] serves a page that shows what
//! they do, leads the hand and changes what is rendered. `docs/scope.md` says what page and server
//! tell each other. The loops wait for neither.

mod hub;
mod message;
mod pace;
mod rows;
mod server;
mod session;
mod settings;

pub use hub::{ClientId, Hub, Outgoing, Seat};
pub use server::{DEFAULT_ADDRESS, ListenError, Listening, Server};
pub use session::{
    Command, Devices, Ended, LaneEnd, Placed, Receipts, Session, SessionEnd, SessionError, Setup,
    Written,
};
pub use settings::{Limits, Settings};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
