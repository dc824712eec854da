//! The core's words in those of recordings: neither crate knows the other.

use palpate_record::recording::Phase;

pub(crate) fn phase(phase: palpate::Phase) -> Phase {
    match phase {
        palpate::Phase::Free => Phase::Free,
        palpate::Phase::Contact => Phase::Contact,
        palpate::Phase::Enters => Phase::Enters,
        palpate::Phase::Leaves => Phase::Leaves,
        palpate::Phase::Waiting => Phase::Waiting,
    }
}
