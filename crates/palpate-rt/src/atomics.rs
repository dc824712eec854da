//! Atomics of the path from the loop to its listener. `conformance/loom` replaces them by model-checked ones.

pub(crate) use std::sync::atomic::{AtomicBool, AtomicU8, AtomicU64, Ordering};
