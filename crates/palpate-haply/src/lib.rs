//! Haply's devices, as devices of a palpate loop, and emulators of them to try without.

pub mod inverse3;
pub mod two_diy;
