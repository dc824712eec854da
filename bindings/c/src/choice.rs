//! Numbers that stand for a choice.

use crate::status::Refusal;

/// Whether a switch is on.
#[inline]
pub fn switch<'a>(name: &'static str, given: u32) -> Result<bool, Refusal<'a>> {
    match given {
        0 => Ok(false),
        1 => Ok(true),
        given => Err(Refusal::Choice {
            name,
            given,
            allowed: "0 or 1",
        }),
    }
}

/// Refuses a number in a place that has no meaning yet: a newer header may give it one.
#[inline]
pub fn unused<'a>(given: u32) -> Result<(), Refusal<'a>> {
    if given == 0 {
        return Ok(());
    }
    Err(Refusal::Choice {
        name: "reserved",
        given,
        allowed: "0",
    })
}
