//! Haply's devices, as devices of a palpate loop. The crate `palpate-haply-emulator` has an emulator of each.

pub mod inverse3;
pub mod two_diy;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
