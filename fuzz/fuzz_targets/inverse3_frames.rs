//! Arbitrary output of an Inverse Service: a frame is parsed or rejected, and parsed values are plausible.
#![no_main]

#[path = "../../crates/palpate-drivers/tests/it/inverse3/believed.rs"]
mod believed;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| believed::read(bytes));
