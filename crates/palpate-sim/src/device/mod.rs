//! Simulated devices for a loop that runs in time.

mod pointer;
mod simulated;

pub use pointer::{PointerDevice, PointerHand, PointerParams};
pub use simulated::SimulatedDevice;
