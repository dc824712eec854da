//! Simulated devices for a loop that runs in time.

mod in_space;
mod pointer;
mod simulated;
mod told;
mod turning_pointer;

pub use in_space::{SpatialDevice, SpatialHand, SpatialPointer};
pub use pointer::{PointerDevice, PointerHand, PointerParams};
pub use simulated::SimulatedDevice;
pub use told::{Told, told_of, told_of_devices};
