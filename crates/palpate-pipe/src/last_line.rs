//! The last lines of a stream: of its input, which may be cut off, and of its forces, which takes the force off.

use std::sync::mpsc::channel;
use std::thread::Builder;
use std::time::Duration;

/// Whether a line of a stream was cut off: `0.01` may be what is left of `0.0123`.
pub fn is_cut_off(line: &[u8]) -> bool {
    !line.ends_with(b"\n")
}

/// What is said of a line that was cut off.
pub const CUT_OFF: &str =
    "the input ends within the line, so the line may be cut off; a line must end with a newline";

/// How long a reader may take for the last line.
const LONGEST_WAIT: Duration = Duration::from_secs(1);

/// Nobody read the last line, so whoever commands the motor may hold its last force.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "standard output was not read for {} s, so the last line, which takes the force off, could not be \
     written",
    LONGEST_WAIT.as_secs()
)]
pub struct LastLineUnread;

/// Writes the last line from beside the thread that answers: that one may wait for ever for a reader that
/// does not read. `write` writes it; a reader that has left needs none, so its errors count for nothing.
///
/// # Errors
/// The line was not taken in time.
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
