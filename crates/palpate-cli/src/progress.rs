//! Progress of work that may take more than a second.

use std::io::{IsTerminal, stderr};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::failure::tell;

/// Shorter work needs no bar.
const PATIENCE: Duration = Duration::from_secs(1);
/// Time of the first line if standard error is not a terminal; later lines follow whenever the time has doubled.
const FIRST_LINE: Duration = Duration::from_secs(30);

/// A progress bar on standard error after one second; lines if standard error is not a terminal.
pub struct Progress {
    bar: ProgressBar,
    /// Shows the bar, unless the other end is dropped before.
    curtain: Option<(Sender<()>, JoinHandle<()>)>,
}

impl Progress {
    /// Progress over `steps` steps.
    pub fn new(steps: usize) -> Self {
        if stderr().is_terminal() {
            Self::shown_by(steps, |bar, ended| {
                if ended(PATIENCE) {
                    return;
                }
                bar.set_draw_target(ProgressDrawTarget::stderr());
                bar.enable_steady_tick(Duration::from_millis(100));
            })
        } else {
            Self::in_lines(steps, FIRST_LINE, tell)
        }
    }

    /// Progress in lines: one after `first`, and then whenever the time has doubled.
    fn in_lines(steps: usize, first: Duration, tell: impl Fn(String) + Send + 'static) -> Self {
        Self::shown_by(steps, move |bar, ended| {
            let mut wait = first;
            while !ended(wait) {
                tell(line(bar));
                wait = bar.elapsed();
            }
        })
    }

    /// Progress shown by another thread; `show` learns whether the work ends within a time.
    fn shown_by(
        steps: usize,
        show: impl FnOnce(&ProgressBar, &dyn Fn(Duration) -> bool) + Send + 'static,
    ) -> Self {
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
            show(&shown, &|time| {
                receiver.recv_timeout(time) != Err(RecvTimeoutError::Timeout)
            });
        });
        Self {
            bar,
            curtain: Some((sender, curtain)),
        }
    }

    /// Names the current step, or work before or after all steps.
    pub fn begin(&self, name: &str) {
        self.bar.set_message(name.to_owned());
    }

    /// Completes a step.
    pub fn advance(&self) {
        self.bar.inc(1);
    }
}

/// The current part, the completed share, and the elapsed time.
fn line(bar: &ProgressBar) -> String {
    let done = match bar.length() {
        Some(steps) if steps > 1 => format!(", {} of {steps}", bar.position()),
        _ => String::new(),
    };
    let seconds = bar.elapsed().as_secs();
    format!("progress: {}{done}, {seconds} s", bar.message())
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn where_there_is_no_terminal_lines_name_the_part_and_its_steps() {
        let (model, lines) = mpsc::channel();
        let progress = Progress::in_lines(3, Duration::from_millis(1), move |line| {
            let _ = model.send(line);
        });
        progress.begin("what can be rendered");
        progress.advance();
        let is_wanted = |line: String| line.starts_with("progress: what can be rendered, 1 of 3, ");
        assert!(lines.iter().any(is_wanted));
        drop(progress);
        // The thread has ended, and so has its output.
        assert!(lines.iter().all(is_wanted));
    }
}
