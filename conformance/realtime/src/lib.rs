//! Checks that the tick of a `palpate_rt::ControlLoop` avoids forbidden operations, in three ways.
//!
//! ```text
//! cargo test --workspace --release                        counts allocations, among all tests
//! cargo test --workspace --release --test system_calls    looks for system calls with strace
//! scripts/nightly sanitizer                               RealtimeSanitizer
//! ```
//!
//! All three check the same [`situations`], and each has to detect its share of the [`misdeeds`].
//! docs/realtime-design.md describes the limits of each check.

mod hostile;
mod in_worlds;
pub mod misdeeds;
#[cfg(feature = "rtsan")]
pub mod rtsan;
mod several;
pub mod situations;
