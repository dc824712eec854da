//! What the tick of a `palpate_rt::ControlLoop` may not do is watched for here, in three ways.
//!
//! ```text
//! cargo test --workspace --release                        counts allocations, among all tests
//! cargo test --workspace --release --test system_calls    looks for system calls with strace
//! scripts/nightly sanitizer                               RealtimeSanitizer
//! ```
//!
//! All three watch the same [`situations`], and each has to notice the [`misdeeds`] that it is there
//! for. What each of them cannot see stands in docs/realtime.md.

mod hostile;
mod in_worlds;
pub mod misdeeds;
#[cfg(feature = "rtsan")]
pub mod rtsan;
mod several;
pub mod situations;
