//! Forces between being computed and being held: the known delay of a loop.

use crate::Scalar;
use crate::contact::LARGEST_DELAY;

/// A force that has been computed but not held yet.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OnItsWay<S> {
    /// What the method asked for `[N]`.
    pub intended: S,
    /// What the limits left of it `[N]`.
    pub commanded: S,
}

/// The forces on their way to the motor, the next to be held first.
#[derive(Clone, Copy, Debug)]
pub(super) struct Queue<S>([OnItsWay<S>; LARGEST_DELAY]);

impl<S: Scalar> Queue<S> {
    pub fn empty() -> Self {
        Self([OnItsWay::default(); LARGEST_DELAY])
    }

    /// The forces on their way in a loop with this delay `[samples]`.
    #[inline]
    pub fn ahead(&self, delay: usize) -> &[OnItsWay<S>] {
        &self.0[..delay.min(LARGEST_DELAY)]
    }

    /// Sends one force, and returns the one that is held from now on.
    #[inline]
    pub fn exchange(&mut self, delay: usize, sent: OnItsWay<S>) -> OnItsWay<S> {
        let waiting = &mut self.0[..delay.min(LARGEST_DELAY)];
        let Some(&held) = waiting.first() else {
            return sent;
        };
        waiting.copy_within(1.., 0);
        if let Some(last) = waiting.last_mut() {
            *last = sent;
        }
        held
    }
}
