//! All integration tests of palpate-haply, in one program.

mod inverse3;
mod two_diy;
