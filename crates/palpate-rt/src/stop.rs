//! Asking a loop to end.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Numbers of the real-time signals of Linux.
#[cfg(target_os = "linux")]
const REAL_TIME: std::ops::RangeInclusive<i32> = 32..=64;

/// A wish for a loop to end; clones share it. The loop looks at it every period.
#[derive(Clone, Debug, Default)]
pub struct StopFlag {
    raised: Arc<AtomicBool>,
    above: Option<Arc<StopFlag>>,
}

impl StopFlag {
    /// Nobody wishes so yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Another flag, which is raised as well when this one is. Raising it leaves this one as it is.
    #[must_use]
    pub fn below(&self) -> Self {
        Self {
            raised: Arc::default(),
            above: Some(Arc::new(self.clone())),
        }
    }

    /// A flag that SIGINT, SIGTERM, SIGHUP and SIGQUIT raise, from now on and for the whole program, and
    /// with them every other signal that would end or stop the program and can be caught: those of a
    /// user, a timer, a terminal, the system (on Linux SIGPWR, SIGIO, SIGSTKFLT and the real-time
    /// signals, too) and of `abort`, which ends the program all the same. A program that is stopped, by
    /// ctrl-Z or for writing to a terminal from the background, would leave the last force on for as
    /// long as it is stopped, so these signals end the loop as well.
    ///
    /// Not caught are SIGKILL and SIGSTOP, which nobody can catch, and SIGSEGV, SIGBUS, SIGILL and
    /// SIGFPE: after a fault of the processor the program cannot go on. A device that holds its last
    /// force needs a guardian for these.
    ///
    /// A file that may grow no more (SIGXFSZ) ends nothing: whoever writes it is told by an error.
    ///
    /// # Errors
    /// The program handles these signals already, or the system refuses.
    #[cfg(any(unix, windows))]
    pub fn on_signals() -> Result<Self, ctrlc::Error> {
        let flag = Self::new();
        let raised = flag.clone();
        ctrlc::set_handler(move || raised.raise())?;
        #[cfg(unix)]
        {
            use signal_hook::consts as signals;
            for signal in [
                signals::SIGQUIT,
                signals::SIGTSTP,
                signals::SIGTTIN,
                signals::SIGTTOU,
                signals::SIGUSR1,
                signals::SIGUSR2,
                signals::SIGALRM,
                signals::SIGVTALRM,
                signals::SIGPROF,
                signals::SIGXCPU,
                signals::SIGABRT,
                signals::SIGTRAP,
                signals::SIGSYS,
                signals::SIGIO,
            ] {
                signal_hook::flag::register(signal, Arc::clone(&flag.raised))
                    .map_err(ctrlc::Error::System)?;
            }
            #[cfg(target_os = "linux")]
            {
                use rustix::process::Signal;
                let named = [Signal::POWER, Signal::STKFLT].map(Signal::as_raw);
                for signal in named.into_iter().chain(REAL_TIME) {
                    // The C library keeps some of the real-time signals for itself.
                    let _ = signal_hook::flag::register(signal, Arc::clone(&flag.raised));
                }
            }
            signal_hook::flag::register(signals::SIGXFSZ, Arc::default())
                .map_err(ctrlc::Error::System)?;
        }
        Ok(flag)
    }

    /// Asks the loop to end.
    pub fn raise(&self) {
        self.raised.store(true, Ordering::Release);
    }

    /// Whether the loop was asked to end.
    #[must_use]
    pub fn is_raised(&self) -> bool {
        self.raised.load(Ordering::Acquire)
            || self.above.as_ref().is_some_and(|above| above.is_raised())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flag_below_another_is_raised_by_either() {
        let above = StopFlag::new();
        let (one, other) = (above.below(), above.below().below());
        one.raise();
        assert!(one.is_raised() && !above.is_raised() && !other.is_raised());
        above.raise();
        assert!(other.is_raised());
    }
}
