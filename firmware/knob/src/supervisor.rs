//! Detects a stalled loop, from an interrupt that the loop cannot block.

/// Result of a check.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The loop runs: feed the watchdog.
    Alive,
    /// The loop has not run since the last check: disable the output, and let the watchdog reset the chip.
    Stalled,
}

/// Monitor of a counter that every tick of the loop increments. A stall is latched until the chip is reset, even if the
/// loop resumes: the loop is no longer trusted.
#[derive(Clone, Copy, Debug, Default)]
pub struct Supervisor {
    last: u32,
    has_looked: bool,
    stalled: bool,
}

impl Supervisor {
    /// Creates a supervisor before its first check.
    pub const fn new() -> Self {
        Self {
            last: 0,
            has_looked: false,
            stalled: false,
        }
    }

    /// Checks the counter of ticks. Call it with a period of at least two periods of the loop.
    pub fn look(&mut self, ticks: u32) -> Verdict {
        self.stalled |= self.has_looked && ticks == self.last;
        self.last = ticks;
        self.has_looked = true;
        if self.stalled {
            Verdict::Stalled
        } else {
            Verdict::Alive
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_loop_that_stalled_once_is_not_trusted_again() {
        let mut supervisor = Supervisor::new();
        let seen = [3, 5, u32::MAX, 0, 0, 2, 4].map(|ticks| supervisor.look(ticks));
        let (alive, stalled) = (Verdict::Alive, Verdict::Stalled);
        assert_eq!(
            seen,
            [alive, alive, alive, alive, stalled, stalled, stalled]
        );
    }
}
