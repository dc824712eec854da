//! Drivers of Haply's devices for a palpate loop. The crate `palpate-haply-emulator` contains an emulator of each.

pub mod inverse3;
pub mod two_diy;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
