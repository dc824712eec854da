//! Asking a loop to end.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A wish for a loop to end; clones share it. The loop looks at it every period.
#[derive(Clone, Debug, Default)]
pub struct StopFlag(Arc<AtomicBool>);

impl StopFlag {
    /// Nobody wishes so yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// A flag that SIGINT, SIGTERM and SIGHUP raise, from now on and for the whole program.
    ///
    /// # Errors
    /// The program handles these signals already, or the system refuses.
    pub fn on_signals() -> Result<Self, ctrlc::Error> {
        let flag = Self::new();
        let raised = flag.clone();
        ctrlc::set_handler(move || raised.raise())?;
        Ok(flag)
    }

    /// Asks the loop to end.
    pub fn raise(&self) {
        self.0.store(true, Ordering::Release);
    }

    /// Whether the loop was asked to end.
    #[must_use]
    pub fn is_raised(&self) -> bool {
        self.0.load(Ordering::Acquire)
    }
}
