//! Asking a loop to end.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

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
    /// with them the rest of the signals by which somebody, a terminal or a timer ends or stops a
    /// program. One that is stopped, by ctrl-Z or for writing to a terminal from the background, would
    /// leave the last force on for as long as it is, so that ends the loop as well.
    ///
    /// A file that may grow no more (SIGXFSZ) ends nothing: whoever writes it is told by an error.
    ///
    /// # Errors
    /// The program handles these signals already, or the system refuses.
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
            ] {
                signal_hook::flag::register(signal, Arc::clone(&flag.raised))
                    .map_err(ctrlc::Error::System)?;
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
