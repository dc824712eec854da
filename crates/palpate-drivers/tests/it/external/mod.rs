//! Devices of other programs.

#[cfg(unix)]
mod process;
mod udp;

use std::time::Duration;

/// Period and longest silence of the loops: an answer has half the period to arrive on a busy machine.
const TIMES: (Duration, Duration) = (Duration::from_secs(2), Duration::from_secs(4));

/// Returns the words of a line.
fn words(line: &str) -> Vec<&str> {
    line.split_ascii_whitespace().collect()
}
