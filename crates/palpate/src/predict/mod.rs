//! Where the device will be: what a method may know of the device beyond its samples.

mod observer;
mod placed;
mod spread;

pub(crate) use observer::{Motion, Observer, ObserverParams, Seen};
pub(crate) use placed::Placed;
