//! Runs long work without the GIL and lets Ctrl-C end the wait.

use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use pyo3::exceptions::{PyOSError, PyRuntimeError};
use pyo3::prelude::*;

/// Polling interval for pending Python signals.
const LOOK_EVERY: Duration = Duration::from_millis(20);

/// Cancellation flag of a piece of work.
#[derive(Clone, Default)]
pub struct Stop(Arc<AtomicBool>);

impl Stop {
    /// Whether the work is cancelled.
    pub fn is_raised(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// Unwinds the thread of the work without a message if the work is cancelled.
    pub fn leave_if_raised(&self) {
        if self.is_raised() {
            resume_unwind(Box::new("the work is cancelled"));
        }
    }
}

/// Runs `work` in a new thread without the GIL and waits for it. An exception of a Python signal handler, such as
/// `KeyboardInterrupt`, ends the wait; the work then ends at its next check of [`Stop`].
///
/// # Errors
/// An exception of a signal handler; a panic of the work.
pub fn interruptible<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce(&Stop) -> T + Send + 'static,
) -> PyResult<T> {
    let stop = Stop::default();
    let seen = stop.clone();
    let (sender, mut done) = channel();
    thread::Builder::new()
        .name("palpate".to_owned())
        .spawn(move || {
            // Sending fails only after the wait has ended.
            let _ = sender.send(work(&seen));
        })
        .map_err(|error| PyOSError::new_err(format!("cannot start a thread: {error}")))?;
    loop {
        let (back, received) = py.detach(|| {
            let received = done.recv_timeout(LOOK_EVERY);
            (done, received)
        });
        match received {
            Ok(result) => return Ok(result),
            Err(RecvTimeoutError::Disconnected) => {
                let fault =
                    "the work panicked, a defect in palpate; its message is on standard error";
                return Err(PyRuntimeError::new_err(fault));
            }
            Err(RecvTimeoutError::Timeout) => {
                if let Err(raised) = py.check_signals() {
                    stop.0.store(true, Ordering::Relaxed);
                    return Err(raised);
                }
            }
        }
        done = back;
    }
}
