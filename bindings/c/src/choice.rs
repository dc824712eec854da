//! Checks of integer arguments that encode a choice.

use crate::status::Refusal;

/// Returns the value of a 0/1 switch.
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

/// Rejects a nonzero reserved field, because a newer header may define it.
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
