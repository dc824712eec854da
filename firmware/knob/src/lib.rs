#![no_std]
#![forbid(unsafe_code)]
//! The loop of a knob with one motor and one position sensor: counts in, duty out. It is independent of the chip: a
//! program passes a count in every period and writes the returned duty to the PWM timer.
//!
//! ```text
//!   turning the rim this way: position + , the wall is at `wall_at` and is solid beyond it
//!   duty > 0 pushes the rim towards +; a wall pushes back with duty < 0
//! ```
//!
//! Without a trusted state there is no force: see [`Status`].

#[cfg(test)]
extern crate std;

mod drive;
mod knob;
mod line_hold;
mod sensor;
mod supervisor;

pub use drive::Drive;
pub use knob::{Answer, Knob, KnobParams, Status, WhenSilent};
pub use line_hold::{HostLine, LineHold, LineHoldParams};
pub use sensor::Sensor;
pub use supervisor::{Supervisor, Verdict};
