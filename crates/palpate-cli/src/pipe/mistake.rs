//! Likely mistakes of the caller of a stream.

use std::fmt;

use palpate_record::unit::Excess;
use palpate_study::sim::replay::ReplaySetup;

/// Wording of likely mistakes. It contains the remedy, and only the caller knows its flags.
#[derive(Clone, Copy)]
pub struct Mistakes {
    /// Message for a device that starts at this position `[m]` inside the object; `None` if it starts outside. The flag
    /// is whether the unit of the positions was given.
    pub inside: fn(&ReplaySetup, f64, bool) -> Option<String>,
    /// Message for an implausible motion.
    pub not_a_hand: fn(&Excess) -> String,
}

impl fmt::Debug for Mistakes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Mistakes").finish_non_exhaustive()
    }
}
