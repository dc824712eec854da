//! Zero-order hold with a known delay between measuring and actuating.

use std::collections::VecDeque;

use crate::InvalidParameter;

/// Holds each command for one period, a whole number of periods after it was given.
///
/// The force is 0 until the first command arrives.
#[derive(Debug, Clone, PartialEq)]
pub struct DelayedHold {
    under_way: VecDeque<f64>,
    delay: usize,
}

impl DelayedHold {
    /// Longest delay `[samples]`: more than a second at 1 kHz, so more is a mistake.
    pub const LONGEST_DELAY: usize = 1024;

    /// A hold with a delay `[samples]`; 0 holds a command at once.
    ///
    /// # Errors
    ///
    /// `delay` is above [`LONGEST_DELAY`](Self::LONGEST_DELAY).
    pub fn new(delay: usize) -> Result<Self, InvalidParameter> {
        InvalidParameter::unless(
            delay <= Self::LONGEST_DELAY,
            "delay",
            delay as f64,
            "0 to 1024 samples",
        )?;
        let mut under_way = VecDeque::with_capacity(delay + 1);
        under_way.resize(delay, 0.0);
        Ok(Self { under_way, delay })
    }

    /// Delay `[samples]`.
    #[must_use]
    pub fn delay(&self) -> usize {
        self.delay
    }

    /// Takes the command `[N]` of this sample and returns the force `[N]` to hold until the next.
    pub fn exchange(&mut self, command: f64) -> f64 {
        self.under_way.push_back(command);
        self.under_way.pop_front().unwrap_or(command)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_delay_a_command_is_held_at_once() {
        let mut hold = DelayedHold::new(0).unwrap();
        assert_eq!(hold.exchange(1.5), 1.5);
        assert_eq!(hold.exchange(-2.0), -2.0);
    }

    #[test]
    fn commands_arrive_in_order_after_the_delay_and_zeros_come_first() {
        let mut hold = DelayedHold::new(3).unwrap();
        let held: Vec<f64> = (1..=7).map(|i| hold.exchange(f64::from(i))).collect();
        assert_eq!(held, [0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 4.0]);
        assert_eq!(hold.delay(), 3);
        assert_eq!(hold.under_way.len(), 3);
    }

    #[test]
    fn the_queue_is_bounded() {
        assert!(DelayedHold::new(DelayedHold::LONGEST_DELAY).is_ok());
        let error = DelayedHold::new(DelayedHold::LONGEST_DELAY + 1).unwrap_err();
        assert_eq!((error.name, error.value), ("delay", 1025.0));
    }
}
