//! What the tick of a `palpate_rt::ControlLoop` may not do is watched for here, in three ways.
//!
//! ```text
//! cd conformance/realtime
//! cargo test                          counts allocations; looks for system calls with strace
//! RUSTC_BOOTSTRAP=1 RUSTFLAGS=-Zsanitizer=realtime \
//!     cargo test --features rtsan --target x86_64-unknown-linux-gnu --test rtsan
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
