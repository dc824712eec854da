//! Whatever an Inverse Service sends: a frame is read or refused, and what is believed is possible.
#![no_main]

#[path = "../../crates/palpate-haply/tests/inverse3/believed.rs"]
mod believed;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| believed::read(bytes));
