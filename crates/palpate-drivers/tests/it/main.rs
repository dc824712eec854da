//! All integration tests of palpate-drivers, in one program.

mod inverse3;
mod two_diy;
