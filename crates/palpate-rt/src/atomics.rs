//! The atomics of the path from the loop to its listener. `conformance/loom` puts those of a model of
//! memory in their place.

pub(crate) use std::sync::atomic::{AtomicBool, AtomicU8, AtomicU64, Ordering};
