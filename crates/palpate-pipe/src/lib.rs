//! A renderer between two streams of lines: positions in, forces on the device out.
//!
//! A program in any language that owns a device writes a line for each sample and reads a line with the force that it
//! commands until the next. [`Stream`] renders one contact, [`world::WorldStream`] a world, and [`calibrate()`] excites a
//! device to be calibrated. [`answer_all`] serves a stream on a thread of its own until the input ends or a signal comes.
//! The last line always takes the force off.
//!
//! What a line is and what is said of one that is none stands in [`Format`] and [`world::WorldFormat`]. Flags, exit codes, and
//! how messages reach a person are the caller's: [`Messages`] takes a function that writes them, [`Mistakes`] the
//! caller's words.

mod calibrating;
mod change;
mod columns;
mod last_line;
mod line;
mod messages;
mod mistake;
mod number;
#[cfg(test)]
mod schemas;
mod serving;
mod stream;
mod summary;
pub mod world;

pub use calibrating::{CalibratingError, calibrate};
pub use change::{Change, Changeable, rendering};
pub use columns::{Answer, AnswerColumn, Columns, columns};
pub use last_line::LastLineUnread;
pub use line::{Format, Line, Refusal};
pub use messages::Messages;
pub use mistake::Mistakes;
pub use serving::{Answering, Ended, ServeError, Served, Stopped, answer_all};
pub use stream::{Memory, Stream};
pub use summary::PipeSummary;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
