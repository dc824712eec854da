//! A five-bar pantograph: two motors on the base, two arms of two links, one end-point.
//!
//! [`kinematics`] says where the end-point is, [`Dynamics`] how the links accelerate, and
//! [`Pantograph`] puts motors, encoders, friction, a controller for x and a safety box around them
//! and stands behind [`DevicePlant`](crate::device::DevicePlant): the contact direction is y.
//!
//! Motors hold **torques** between samples, not forces. While the end-point moves, the force that a
//! held torque makes turns and changes with the pose, as it does on the bench.

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
