//! Simulated devices for a loop that runs in time.

mod in_space;
mod model;
mod pointer;
mod simulated;
mod turning_pointer;

pub use in_space::{SpatialDevice, SpatialHand, SpatialPointer};
pub use model::{Model, model_of, model_of_devices};
pub use pointer::{PointerDevice, PointerHand, PointerParams};
pub use simulated::SimulatedDevice;
