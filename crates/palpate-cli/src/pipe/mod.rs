//! A renderer between two streams of lines: positions in, forces on the device out.
//!
//! A program in any language that owns a device writes a line for each sample and reads a line with the force to
//! command until the next sample. [`Stream`] renders one contact, [`world::WorldStream`] renders a world, and
//! [`calibrate()`] excites a device for calibration. [`answer_all`] serves a stream on a separate thread until the
//! input ends or a signal arrives. The last line always sets the force to 0.
//!
//! [`Format`] and [`world::WorldFormat`] define the input lines and the errors for invalid ones. The caller owns flags,
//! exit codes and the output of messages: [`Messages`] takes a function that writes them, and [`Mistakes`] takes the
//! caller's wording.

mod calibrating;
mod change;
mod columns;
mod last_line;
mod line;
mod messages;
mod mistake;
mod number;
mod serving;
mod stream;
mod summary;
pub mod world;

pub use calibrating::{CalibratingError, calibrate};
pub use change::{Changeable, rendering};
pub use columns::{AnswerColumn, Columns, columns};
pub use line::Format;
pub use messages::Messages;
pub use mistake::Mistakes;
pub use serving::{Answering, Ended, ServeError, Stopped, answer_all};
pub use stream::{Memory, Stream};
pub use summary::PipeSummary;
