//! Stop requests for a loop.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Numbers of the real-time signals of Linux.
#[cfg(target_os = "linux")]
const REAL_TIME: std::ops::RangeInclusive<i32> = 32..=64;

/// A stop request for a loop; clones share it. The loop checks it every period.
#[derive(Clone, Debug, Default)]
pub struct StopFlag {
    raised: Arc<AtomicBool>,
    above: Option<Arc<StopFlag>>,
}

impl StopFlag {
    /// Creates a flag that is not raised.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Returns a child flag. Raising this flag also raises the child; raising the child does not raise this flag.
    #[must_use]
    pub fn below(&self) -> Self {
        Self {
            raised: Arc::default(),
            above: Some(Arc::new(self.clone())),
        }
    }

    /// Returns a flag that is raised by SIGINT, SIGTERM, SIGHUP and SIGQUIT, from now on and for the whole program.
    /// Every other catchable signal that would end or stop the program also raises it: user, timer, terminal and
    /// system signals (on Linux also SIGPWR, SIGIO, SIGSTKFLT and the real-time signals), and the signal of `abort`,
    /// which still ends the program. A program stopped by ctrl-Z or by terminal output from the background would
    /// leave the last force on, so these signals also end the loop.
    ///
    /// SIGKILL and SIGSTOP cannot be caught. SIGSEGV, SIGBUS, SIGILL and SIGFPE are not caught, because a program
    /// cannot continue after a fault of the processor. A device that holds its last force needs a watchdog process
    /// for these signals.
    ///
    /// SIGXFSZ (file size limit) has no effect on the loop: the writer of the file gets an error.
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
                    // The C library reserves some of the real-time signals.
                    let _ = signal_hook::flag::register(signal, Arc::clone(&flag.raised));
                }
            }
            signal_hook::flag::register(signals::SIGXFSZ, Arc::default())
                .map_err(ctrlc::Error::System)?;
        }
        Ok(flag)
    }

    /// Requests the end of the loop.
    pub fn raise(&self) {
        self.raised.store(true, Ordering::Release);
    }

    /// Returns whether the end of the loop was requested.
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
