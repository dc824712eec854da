//! Progress of work that may take more than a second.

use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Work that is done sooner needs no bar.
const PATIENCE: Duration = Duration::from_secs(1);

/// A bar on standard error that appears after a second, and only on a terminal.
pub struct Progress {
    bar: ProgressBar,
    /// Shows the bar, unless the other end is dropped before.
    curtain: Option<(Sender<()>, JoinHandle<()>)>,
}

impl Progress {
    /// Progress over `steps` steps.
    pub fn new(steps: usize) -> Self {
        let bar = ProgressBar::with_draw_target(Some(steps as u64), ProgressDrawTarget::hidden());
        let template = if steps > 1 {
            "{spinner} {bar:40} {pos}/{len} {msg} ({elapsed}, {eta} left)"
        } else {
            "{spinner} {msg} ({elapsed})"
        };
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        let (sender, receiver) = mpsc::channel();
        let shown = bar.clone();
        let curtain = thread::spawn(move || {
            if receiver.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout) {
                // Hides itself where standard error is no terminal.
                shown.set_draw_target(ProgressDrawTarget::stderr());
                shown.enable_steady_tick(Duration::from_millis(100));
            }
        });
        Self {
            bar,
            curtain: Some((sender, curtain)),
        }
    }

    /// Something begins: a step, or work before or after all of them.
    pub fn begin(&self, name: &str) {
        self.bar.set_message(name.to_owned());
    }

    /// A step is done.
    pub fn advance(&self) {
        self.bar.inc(1);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some((sender, curtain)) = self.curtain.take() {
            drop(sender);
            let _ = curtain.join();
        }
        self.bar.finish_and_clear();
    }
}
