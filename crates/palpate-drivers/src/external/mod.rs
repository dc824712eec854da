//! Devices that another program moves: a process with lines on its standard input and output, or a program that answers
//! UDP packets, in any language. `docs/your-device.md` specifies the protocol.

mod account;
mod channel;
mod driver;
mod open;
#[cfg(unix)]
mod process;
mod protocol;
mod words;

pub use driver::External;
pub use open::{OpenError, Place};
pub use words::words;
