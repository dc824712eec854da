//! All integration tests of palpate-drivers, in one program.

#[cfg(unix)]
mod drive;
mod external;
#[cfg(unix)]
mod force_dimension;
mod inverse3;
#[cfg(unix)]
mod plugin;
mod two_diy;
