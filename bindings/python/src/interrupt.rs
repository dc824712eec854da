//! Long work beside Python: other threads of Python run meanwhile, and Ctrl-C ends the wait.

use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use pyo3::exceptions::{PyOSError, PyRuntimeError};
use pyo3::prelude::*;

/// How often it is looked whether Python has a signal to handle.
const LOOK_EVERY: Duration = Duration::from_millis(20);

/// Whether nobody waits for the work any more.
#[derive(Clone, Default)]
pub struct Stop(Arc<AtomicBool>);

impl Stop {
    /// Whether nobody waits for the work any more.
    pub fn is_raised(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// Ends the work where nobody waits for it any more: unwinds its thread, without a message.
    pub fn leave_if_raised(&self) {
        if self.is_raised() {
            resume_unwind(Box::new("nobody waits for this work any more"));
        }
    }
}

/// Does `work` in a thread of its own, without the lock of Python, and waits for it. What a signal
/// handler of Python raises, such as `KeyboardInterrupt`, ends the wait; the work then ends where it
/// next looks at its [`Stop`].
///
/// # Errors
/// What a signal handler raised; a panic of the work.
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
            // Nobody waits any more where this fails.
            let _ = sender.send(work(&seen));
        })
        .map_err(|error| PyOSError::new_err(format!("no thread to work in: {error}")))?;
    loop {
        let (back, received) = py.detach(|| {
            let received = done.recv_timeout(LOOK_EVERY);
            (done, received)
        });
        match received {
            Ok(result) => return Ok(result),
            Err(RecvTimeoutError::Disconnected) => {
                let fault =
                    "the work ended by a fault of palpate; its message is on standard error";
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
