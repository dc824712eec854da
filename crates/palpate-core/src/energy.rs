//! Energy ledger: energy stored by the object, exchanged through the port, and leaked.

use crate::Scalar;

/// Energy that a held force created (positive) or destroyed (negative), Eq. (10) with the work of the virtual force in
/// the balance. The leak of an interval is known one sample later, because it depends on the motion of the device.
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
    fn entry(&mut self, leak: S) {
        self.last = leak;
        self.accumulated += leak;
        self.absolute += leak.abs();
    }
}

/// Energy ledger of the object, kept by every renderer.
///
/// It balances at every sample:
///
/// ```text
/// stored - opening = port_work + virtual_force_work + outside_work + held leak
/// ```
///
/// Energy is positive into the object. The ledger excludes the device's own energy. The energy from the device to the
/// object is `port_work`, computed with the force that was actually held.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ledger<S> {
    /// Kinetic energy of the object and elastic energy of the contact at the first sample `[J]`.
    pub opening: S,
    /// The same energy at the last sample `[J]`.
    pub stored: S,
    /// Work of the held force on the object's side of the port, `sum f_i (xi_{i+1} - xi_i)` `[J]`.
    pub port_work: S,
    /// Work of the virtual force on the object, `sum f_V (eta_{i+1} - eta_i)` `[J]`.
    pub virtual_force_work: S,
    /// Energy changes from outside: teleports, other parameters, and changes while samples were rejected `[J]`.
    pub outside_work: S,
    /// Leak of the spring force K p_i over the same motion, the paper's original leak. If the contact yields to a force
    /// limit (walls and coupled rendering), the spring force and `stored` are limited too.
    pub original_leak: Leak<S>,
    /// Leak of the held force, the paper's remaining leak.
    pub held_leak: Leak<S>,
    /// Part of the held leak that limits explain: an object that does not yield to a limit moves as if the device felt
    /// the whole force. The device does not deliver this energy.
    pub limited_leak: Leak<S>,
}

/// One interval, closed by the sample at its end. Works are positive into the object.
pub(crate) struct Closing<S> {
    /// Stored energy at the interval's end `[J]`.
    pub stored: S,
    /// Work of the held force through the port `[J]`.
    pub port_work: S,
    /// Work of the virtual force `[J]`.
    pub virtual_force_work: S,
    /// Work that the spring force of the interval's start, K p_i or 0, would have done through the port
    /// `[J]`.
    pub original_work: S,
    /// Fraction of the planned force that reached the device, 0 to 1.
    pub part_sent: S,
}

impl<S: Scalar> Ledger<S> {
    pub(crate) fn open(stored: S) -> Self {
        Self {
            opening: stored,
            stored,
            ..Self::default()
        }
    }

    /// Returns the energy that may still be given out without generated energy: initially stored energy plus supplied
    /// energy minus delivered energy `[J]`. The equal `stored - held leak` would lose its digits once an object that no
    /// force can hold has run away.
    pub fn balance(&self) -> S {
        self.opening + self.port_work + self.virtual_force_work + self.outside_work
    }

    /// Returns the energy generated at the port `[J]`: the held leak without the part that limits explain.
    pub fn created(&self) -> S {
        self.held_leak.accumulated - self.limited_leak.accumulated
    }

    /// Records one interval; returns false, without effect, if an entry would overflow.
    #[must_use]
    pub(crate) fn close(&mut self, interval: &Closing<S>) -> bool {
        let unpaid = interval.stored - self.stored - interval.virtual_force_work;
        let original = unpaid - interval.original_work;
        let held = unpaid - interval.port_work;
        let limited = (S::ONE - interval.part_sent) * unpaid;
        let mut closed = *self;
        closed.stored = interval.stored;
        closed.port_work += interval.port_work;
        closed.virtual_force_work += interval.virtual_force_work;
        closed.original_leak.entry(original);
        closed.held_leak.entry(held);
        closed.limited_leak.entry(limited);
        // Finite only if every entry is: no leak exceeds the sum of their absolute values.
        let entries = closed.stored
            + closed.port_work.abs()
            + closed.virtual_force_work.abs()
            + closed.original_leak.absolute
            + closed.held_leak.absolute
            + closed.limited_leak.absolute;
        if !entries.is_finite() {
            return false;
        }
        *self = closed;
        true
    }

    /// Sets the stored energy to `stored` `[J]` after a change from outside the contact; returns false, without effect,
    /// if an entry would overflow.
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
    fn overflowing_outside_change_leaves_ledger_unchanged() {
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
