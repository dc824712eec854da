//! All integration tests of palpate-scope, in one program.

mod attacks;
mod common;
mod load;
mod protocol;
mod several;
