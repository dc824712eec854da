//! Motor drives with one axis on a serial port: moteus behind its CAN adapter, and ODrive.
//!
//! A drive measures turns and holds a torque. [`Drive`] is a device with one axis over an [`Axis`], the drive's protocol:
//! a rope on a pulley, a lever, a knob or a screw moves the handle by [`Options::travel`] per turn.

mod axis;
mod device;
mod moteus;
mod odrive;
mod open;
mod text;
mod wire;

pub use axis::{Axis, AxisState, Condition, Heard};
pub use device::Drive;
pub use moteus::Moteus;
pub use odrive::Odrive;
pub use open::{OpenError, Options, SHORTEST_WATCHDOG};
pub use text::Text;
pub use wire::{PortGone, Wire};
