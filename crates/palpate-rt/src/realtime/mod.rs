//! Requests for real-time scheduling, with verification.
//!
//! Every granted request is read back from the kernel, because a successful call is not a guarantee.

#[cfg_attr(not(target_os = "linux"), path = "elsewhere.rs")]
mod linux;
mod machine;

use std::fmt;

pub use machine::{Finding, machine};

/// Real-time requests to the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Request {
    /// SCHED_FIFO priority, 1 to 99; `None`: normal scheduling. A loop with a supervisor, whose priority is higher by
    /// one, requests at most 98.
    pub priority: Option<u8>,
    /// Lock the program's memory.
    pub lock_memory: bool,
    /// Run on this processor only.
    pub processor: Option<usize>,
}

impl Default for Request {
    /// Requests priority 80, below the kernel's own watchdogs, and locked memory; any processor.
    fn default() -> Self {
        Self {
            priority: Some(80),
            lock_memory: true,
            processor: None,
        }
    }
}

impl Request {
    /// Creates an empty request.
    #[must_use]
    pub fn nothing() -> Self {
        Self {
            priority: None,
            lock_memory: false,
            processor: None,
        }
    }

    /// Applies the request to the calling thread and reads back the result.
    #[must_use]
    pub fn ask(&self) -> Vec<Answer> {
        let mut answers = Vec::new();
        if let Some(priority) = self.priority {
            answers.push(Answer {
                asked: format!("SCHED_FIFO, priority {priority}"),
                outcome: linux::run_first(priority),
                remedy: "run as root, give the program the capability (`setcap cap_sys_nice+ep PROGRAM`), or add a \
                         line `@GROUP - rtprio 95` in /etc/security/limits.d/, then log in again",
            });
        }
        if self.lock_memory {
            answers.push(Answer {
                asked: "memory locked".to_owned(),
                outcome: linux::lock_memory(),
                remedy: "add a line `@GROUP - memlock unlimited` in /etc/security/limits.d/, then log in again \
                         (`ulimit -l` prints the limit)",
            });
        }
        if let Some(processor) = self.processor {
            answers.push(Answer {
                asked: format!("processor {processor} only"),
                outcome: linux::stay_on(processor),
                remedy: "choose a processor that the program may use (`nproc`, `taskset -p $$`)",
            });
        }
        answers
    }
}

/// Result of a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Answer {
    /// Description of the request.
    pub asked: String,
    /// State reported by the kernel: as requested, or the reason of the refusal.
    pub outcome: Result<(), String>,
    /// Remedy after a refusal.
    pub remedy: &'static str,
}

impl Answer {
    /// Returns whether the request was granted.
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
                    // The user may lack the right; then a reason must be given.
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
