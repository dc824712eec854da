//! Identity of the contact or world that a recorder belongs to.

use core::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// A number that is unique among all contacts and worlds of this program, including freed ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Identity(usize);

impl Identity {
    /// Returns a new identity.
    pub fn next() -> Self {
        static NEXT: AtomicUsize = AtomicUsize::new(0);
        Self(NEXT.fetch_add(1, Relaxed))
    }
}
