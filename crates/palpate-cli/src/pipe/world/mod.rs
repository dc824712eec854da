//! A world between two streams: the positions of all devices in, a force on each of them out.

mod line;
mod names;
mod stream;
mod summary;

pub use line::{DeviceColumns, WorldFormat};
pub use names::Names;
pub use stream::{WorldMemory, WorldStream};
pub use summary::WorldSummary;
