//! Stub for systems without support of real-time requests.

const WHY: &str = "available on Linux only";

pub fn run_first(_priority: u8) -> Result<(), String> {
    Err(WHY.to_owned())
}

pub fn lock_memory() -> Result<(), String> {
    Err(WHY.to_owned())
}

pub fn stay_on(_processor: usize) -> Result<(), String> {
    Err(WHY.to_owned())
}
