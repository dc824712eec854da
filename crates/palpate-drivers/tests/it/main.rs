//! All integration tests of palpate-drivers, in one program.

mod external;
mod inverse3;
#[cfg(unix)]
mod plugin;
mod two_diy;
