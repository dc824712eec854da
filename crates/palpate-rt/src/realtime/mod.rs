//! Asking the machine to serve the loop's thread first, and finding out whether it does.
//!
//! Whatever is asked for is looked up again afterwards, where the kernel keeps it: a call that
//! returns without an error is not yet a promise.

#[cfg_attr(not(target_os = "linux"), path = "elsewhere.rs")]
mod linux;
mod machine;

use std::fmt;

pub use machine::{Finding, machine};

/// What to ask the machine for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Request {
    /// Priority under SCHED_FIFO, 1 to 99; `None`: stay with everybody else. A loop with a supervisor,
    /// who has one more, asks for 98 at most.
    pub priority: Option<u8>,
    /// Keep the program's memory from being moved out.
    pub lock_memory: bool,
    /// Run on this processor only.
    pub processor: Option<usize>,
}

impl Default for Request {
    /// Priority 80, below the kernel's own watchdogs, and memory locked; any processor.
    fn default() -> Self {
        Self {
            priority: Some(80),
            lock_memory: true,
            processor: None,
        }
    }
}

impl Request {
    /// Asks for nothing.
    #[must_use]
    pub fn nothing() -> Self {
        Self {
            priority: None,
            lock_memory: false,
            processor: None,
        }
    }

    /// Asks the machine, for the thread that calls, and looks up what came of it.
    #[must_use]
    pub fn ask(&self) -> Vec<Answer> {
        let mut answers = Vec::new();
        if let Some(priority) = self.priority {
            answers.push(Answer {
                asked: format!("SCHED_FIFO, priority {priority}"),
                outcome: linux::run_first(priority),
                remedy: "run as root, give the program the right (`setcap cap_sys_nice+ep \
                         PROGRAM`), or let your user have it: a line `@GROUP - rtprio 95` in \
                         /etc/security/limits.d/, then log in again",
            });
        }
        if self.lock_memory {
            answers.push(Answer {
                asked: "memory locked".to_owned(),
                outcome: linux::lock_memory(),
                remedy: "a line `@GROUP - memlock unlimited` in /etc/security/limits.d/, then log \
                         in again (`ulimit -l` says what is allowed)",
            });
        }
        if let Some(processor) = self.processor {
            answers.push(Answer {
                asked: format!("processor {processor} only"),
                outcome: linux::stay_on(processor),
                remedy: "name a processor that the program may run on (`nproc`, `taskset -p $$`)",
            });
        }
        answers
    }
}

/// What came of a wish.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Answer {
    /// What was asked for.
    pub asked: String,
    /// What the kernel says about it now: as it was asked, or why not.
    pub outcome: Result<(), String>,
    /// What can be done where it was refused.
    pub remedy: &'static str,
}

impl Answer {
    /// Whether it is as it was asked.
    #[must_use]
    pub fn is_granted(&self) -> bool {
        self.outcome.is_ok()
    }
}

impl fmt::Display for Answer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.outcome {
            Ok(()) => write!(f, "{}: granted", self.asked),
            Err(why) => write!(f, "{}: refused ({why}); {}", self.asked, self.remedy),
        }
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn what_is_granted_is_what_the_kernel_has() {
        std::thread::spawn(|| {
            let request = Request {
                priority: Some(3),
                lock_memory: true,
                processor: Some(0),
            };
            for answer in request.ask() {
                match &answer.outcome {
                    Ok(()) => {}
                    // Whoever runs this may not have the right; then the reason must be there.
                    Err(why) => assert!(!why.is_empty()),
                }
            }
            let (policy, priority) = linux::scheduling().unwrap();
            let is_first = policy == "FIFO" && priority == 3;
            assert_eq!(is_first, request.ask()[0].is_granted());
        })
        .join()
        .unwrap();
    }

    #[test]
    fn what_cannot_be_is_refused_with_a_reason() {
        let answers = Request {
            processor: Some(1000),
            ..Request::nothing()
        }
        .ask();
        assert_eq!(answers.len(), 1);
        assert!(!answers[0].is_granted());
        assert!(
            answers[0]
                .to_string()
                .starts_with("processor 1000 only: refused (")
        );
        assert!(Request::nothing().ask().is_empty());
    }
}
