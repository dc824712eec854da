//! The energy ledger: what the object stores, what came through the port, and what leaked.

use crate::Scalar;

/// Energy that a held force created (positive) or destroyed (negative), Eq. (10) with the work of
/// the virtual force in the balance. The leak of an interval is known one sample later, when it is
/// known where the device went.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Leak<S> {
    /// Leak of the last closed interval `[J]`.
    pub last: S,
    /// Sum over all closed intervals `[J]`. Leaks of opposite sign cancel in it.
    pub accumulated: S,
    /// Sum of the absolute leaks of all closed intervals `[J]`.
    pub absolute: S,
}

impl<S: Scalar> Leak<S> {
    fn book(&mut self, leak: S) {
        self.last = leak;
        self.accumulated += leak;
        self.absolute += leak.abs();
    }
}

/// Books of the object's energy, kept by every renderer.
///
/// They balance at every sample:
///
/// ```text
/// stored - stored at start = port_work + virtual_force_work + outside_work + held leak
/// ```
///
/// Energy is positive into the object. The device's own energy is not in these books; what it
/// gave the object is `port_work`, counted with the force that was really held.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ledger<S> {
    /// Kinetic energy of the object and elastic energy of the contact at the last sample `[J]`.
    pub stored: S,
    /// Work of the held force on the object's side of the port, `sum f_i (xi_{i+1} - xi_i)` `[J]`.
    pub port_work: S,
    /// Work of the virtual force on the object, `sum f_V (eta_{i+1} - eta_i)` `[J]`.
    pub virtual_force_work: S,
    /// What changed the object from outside: placing it anew, other parameters, and what passed
    /// while no sample could be trusted `[J]`.
    pub outside_work: S,
    /// Leak of the spring force K p_i over the same motion, the paper's original leak. Where the contact yields to a force
    /// limit (walls and coupled rendering), the spring force is limited too, and so is `stored`.
    pub original_leak: Leak<S>,
    /// Leak of the force that was held, the paper's remaining leak.
    pub held_leak: Leak<S>,
}

/// One interval, closed by the sample at its end. Works are positive into the object.
pub(crate) struct Closing<S> {
    /// Stored energy at the interval's end `[J]`.
    pub stored: S,
    /// Work of the force that was held, through the port `[J]`.
    pub port_work: S,
    /// Work of the virtual force `[J]`.
    pub virtual_force_work: S,
    /// Work that the spring force of the interval's start, K p_i or 0, would have done through the port
    /// `[J]`.
    pub original_work: S,
}

impl<S: Scalar> Ledger<S> {
    pub(crate) fn open(stored: S) -> Self {
        Self {
            stored,
            ..Self::default()
        }
    }

    /// Energy that may still be given out if nothing is to be created: what was stored at the start
    /// and put in since, less what has come out `[J]`.
    pub fn balance(&self) -> S {
        self.stored - self.held_leak.accumulated
    }

    /// Books one interval; false, and nothing booked, if an entry would overflow.
    #[must_use]
    pub(crate) fn close(&mut self, interval: &Closing<S>) -> bool {
        let unpaid = interval.stored - self.stored - interval.virtual_force_work;
        let original = unpaid - interval.original_work;
        let held = unpaid - interval.port_work;
        let mut closed = *self;
        closed.stored = interval.stored;
        closed.port_work += interval.port_work;
        closed.virtual_force_work += interval.virtual_force_work;
        closed.original_leak.book(original);
        closed.held_leak.book(held);
        // Finite only if every entry is: no leak exceeds the sum of their absolute values.
        let entries = closed.stored
            + closed.port_work.abs()
            + closed.virtual_force_work.abs()
            + closed.original_leak.absolute
            + closed.held_leak.absolute;
        if !entries.is_finite() {
            return false;
        }
        *self = closed;
        true
    }

    /// The stored energy is now `stored` `[J]`, by no doing of the contact; false, and nothing
    /// booked, if an entry would overflow.
    #[must_use]
    pub(crate) fn change_from_outside(&mut self, stored: S) -> bool {
        let outside_work = self.outside_work + (stored - self.stored);
        if !outside_work.is_finite() {
            return false;
        }
        self.outside_work = outside_work;
        self.stored = stored;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_from_outside_that_would_overflow_books_nothing() {
        let mut ledger = Ledger {
            outside_work: 1.7e308,
            ..Ledger::open(0.0)
        };
        let before = ledger;
        assert!(!ledger.change_from_outside(1e308));
        assert_eq!(ledger, before);
        assert!(ledger.change_from_outside(1.0));
        assert_eq!(ledger.stored, 1.0);
    }
}
