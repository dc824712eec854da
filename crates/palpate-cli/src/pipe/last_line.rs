//! The last lines of a stream: an input line that may be cut off, and the output line that sets the force to 0.

use std::sync::mpsc::channel;
use std::thread::Builder;
use std::time::Duration;

/// Whether a line of a stream is cut off: `0.01` may be the rest of `0.0123`.
pub fn is_cut_off(line: &[u8]) -> bool {
    !line.ends_with(b"\n")
}

/// Message for a line that is cut off.
pub const CUT_OFF: &str =
    "the input ends within the line, so the line may be cut off; a line must end with a newline";

/// Longest wait for a reader of the last line.
const LONGEST_WAIT: Duration = Duration::from_secs(1);

/// The reader did not read the last line, so the motor may hold its last force.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "standard output was not read for {} s; the last line, which sets the force to 0, could not be written",
    LONGEST_WAIT.as_secs()
)]
pub struct LastLineUnread;

/// Writes the last line from another thread than the answering one, which may wait forever for a stalled reader. Errors
/// of `write` are ignored: a reader that has exited needs no last line.
///
/// # Errors
/// The reader did not take the line in time.
pub fn write_beside(write: impl FnOnce() + Send + 'static) -> Result<(), LastLineUnread> {
    let (sender, done) = channel();
    let spawned = Builder::new().spawn(move || {
        write();
        let _ = sender.send(());
    });
    if spawned.is_ok() && done.recv_timeout(LONGEST_WAIT).is_ok() {
        return Ok(());
    }
    Err(LastLineUnread)
}
