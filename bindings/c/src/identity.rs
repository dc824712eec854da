//! Which contact or world a recorder was made of.

use core::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// What no other contact or world of this program has, whatever became of those before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Identity(usize);

impl Identity {
    /// A new one.
    pub fn next() -> Self {
        static NEXT: AtomicUsize = AtomicUsize::new(0);
        Self(NEXT.fetch_add(1, Relaxed))
    }
}
