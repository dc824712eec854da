//! All integration tests of palpate-live, in one program.

mod attacks;
mod common;
mod load;
mod protocol;
mod several;
