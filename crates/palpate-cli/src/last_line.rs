//! The last line of a stream of forces, which takes the force off.

use std::sync::mpsc::channel;
use std::thread::Builder;
use std::time::Duration;

use crate::failure::Failure;

/// How long a reader may take for the last line.
const LONGEST_WAIT: Duration = Duration::from_secs(1);

/// Writes the last line from beside the thread that answers: that one may wait for ever for a reader that
/// does not read. `write` writes it; a reader that has left needs none, so its errors count for nothing.
///
/// # Errors
/// The line was not taken in time.
pub fn write_beside(write: impl FnOnce() + Send + 'static) -> Result<(), Failure> {
    let (sender, done) = channel();
    let spawned = Builder::new().spawn(move || {
        write();
        let _ = sender.send(());
    });
    if spawned.is_ok() && done.recv_timeout(LONGEST_WAIT).is_ok() {
        return Ok(());
    }
    Err(Failure::System(format!(
        "standard output was not read for {} s, so the last line, which takes the force off, could not be \
         written",
        LONGEST_WAIT.as_secs()
    )))
}
