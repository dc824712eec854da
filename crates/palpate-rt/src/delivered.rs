//! Leak of held forces, separated from the energy change while the motors were off.

use palpate_core::Ledger;

/// Leak separated by the state of the motors. The renderer's ledger contains a leak for every interval. While a
/// safety stop keeps the motors off, the object continues to move without a force on the device. The energy change of
/// these intervals is not delivered by a motor.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Delivered {
    /// Leak of the intervals in which the motors could hold a force `[J]`.
    pub leak: f64,
    /// Leak of the other intervals: work from outside `[J]`.
    pub withheld: f64,
    /// Energy generated at the port: the leak without the part that limits explain `[J]`.
    pub created: f64,
}

impl Delivered {
    /// Adds an interval with the ledger `before` and `after` it; `motors_off`: the motors were off during the whole
    /// interval. An unchanged ledger adds nothing.
    pub fn close(&mut self, before: &Ledger<f64>, after: &Ledger<f64>, motors_off: bool) {
        if after.held_leak == before.held_leak {
            return;
        }
        // Use the last leak itself: a difference of large sums would lose precision.
        if motors_off {
            self.withheld += after.held_leak.last;
        } else {
            self.leak += after.held_leak.last;
            self.created += after.held_leak.last - after.limited_leak.last;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Adds an interval with this leak, of which limits explain a quarter.
    fn recorded(ledger: &mut Ledger<f64>, last: f64) -> Ledger<f64> {
        for (leak, last) in [
            (&mut ledger.held_leak, last),
            (&mut ledger.limited_leak, 0.25 * last),
        ] {
            leak.last = last;
            leak.accumulated += last;
            leak.absolute += last.abs();
        }
        *ledger
    }

    #[test]
    fn what_passes_with_the_motors_off_is_no_leak_of_theirs() {
        let (mut ledger, mut delivered) = (Ledger::default(), Delivered::default());
        let mut close = |last: Option<f64>, off| {
            let before = ledger;
            let after = last.map_or(before, |last| recorded(&mut ledger, last));
            delivered.close(&before, &after, off);
            delivered
        };
        close(Some(0.25), false);
        close(Some(3e8), true);
        close(Some(-1e8), true);
        // Unchanged ledger.
        close(None, false);
        let all = close(Some(1e-9), false);
        assert_eq!((all.leak, all.withheld), (0.25 + 1e-9, 2e8));
        assert_eq!(all.created, 0.1875 + 0.75e-9);
    }
}
