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

    /// A flag that SIGINT, SIGTERM, SIGHUP, SIGQUIT and SIGTSTP raise, from now on and for the whole
    /// program. A program that is stopped by ctrl-Z would leave the last force on for as long as it
    /// is, so ctrl-Z ends the loop as well.
    ///
    /// # Errors
    /// The program handles these signals already, or the system refuses.
    pub fn on_signals() -> Result<Self, ctrlc::Error> {
        let flag = Self::new();
        let raised = flag.clone();
        ctrlc::set_handler(move || raised.raise())?;
        #[cfg(unix)]
        for signal in [signal_hook::consts::SIGQUIT, signal_hook::consts::SIGTSTP] {
            signal_hook::flag::register(signal, Arc::clone(&flag.raised))
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
