//! A device in a loop of `palpate_rt`.
//!
//! [`rendered`] creates the rendering of a world on its devices. [`RecordedWorld`] reads the world and the device paths
//! from a recording. [`Shaker`] excites a device for calibration ([`calibrate`](crate::calibrate)), through the safety
//! layer.

mod on_devices;
mod recorded_world;
mod settling;
mod shaker;

pub use on_devices::{NotRendered, lacking_axes, rendered};
pub use recorded_world::{RecordedWorld, RecordedWorldError};
pub use shaker::{ShakeDeclined, ShakeError, Shaker};
