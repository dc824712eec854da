//! A five-bar pantograph: two motors on the base, two arms of two links, one end-point.
//!
//! [`kinematics`] computes the end-point, [`Dynamics`] the accelerations of the links. [`Pantograph`] adds motors,
//! encoders, friction, a controller for x and a safety box, and implements [`DevicePlant`](crate::device::DevicePlant)
//! with the contact direction y.
//!
//! Motors hold **torques** between samples, not forces. The force of a held torque therefore turns and changes with the
//! pose while the end-point moves, as on a real device.

mod device;
mod dynamics;
pub mod kinematics;
mod motion;
mod parameter;
mod params;

pub use device::{Pantograph, Pid, SafetyBox};
pub use dynamics::Dynamics;
pub use kinematics::{ArmPose, Geometry};
pub use parameter::PantographParameter;
pub use params::{Actuation, Link, PantographParams};
