//! What is likely to be a mistake of whoever began the stream.

use std::fmt;

use palpate_record::unit::Excess;
use palpate_sim::replay::ReplaySetup;

/// How the caller calls what is likely to be a mistake: what mends it stands in the words, and only the caller knows its
/// flags.
#[derive(Clone, Copy)]
pub struct Mistakes {
    /// What is said of a device that starts at this position `[m]` inside the object; none if it does not. The flag
    /// says whether the unit of the positions was given.
    pub inside: fn(&ReplaySetup, f64, bool) -> Option<String>,
    /// What is said of a motion that no hand makes.
    pub not_a_hand: fn(&Excess) -> String,
}

impl fmt::Debug for Mistakes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Mistakes").finish_non_exhaustive()
    }
}
