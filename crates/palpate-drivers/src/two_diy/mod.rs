//! Haply 2DIY: a planar five-bar linkage on a serial port.

mod board;
#[cfg(unix)]
mod driver;
mod force;
#[cfg(unix)]
mod guard;
pub mod kinematics;
mod layout;
#[cfg(unix)]
mod line;
#[cfg(unix)]
mod motors;
pub mod packet;
mod plausible;
mod ports;
#[cfg(unix)]
mod start;

pub use board::{Board, LARGEST_TORQUE};
#[cfg(unix)]
pub use driver::{Counts, TwoDiy};
pub use force::{Torques, torques};
pub use layout::{Direction, Generation, Joint, Layout};
#[cfg(unix)]
pub use motors::{Checked, Unchecked, Verdict};
pub use ports::{Guess, Port, ports};
#[cfg(unix)]
pub use start::{Calibration, OpenError, Options};
