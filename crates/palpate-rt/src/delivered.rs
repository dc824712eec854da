//! What held forces leaked while they were held, apart from what passed while the motors were off.

use palpate::Leak;

/// The renderer books a leak for every interval. While a trip keeps the motors off, its object goes on
/// moving against a device that feels nothing: what that makes of the energy, no motor has given to
/// anybody.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Delivered {
    /// Leak of the intervals in which the motors could hold a force `[J]`.
    pub leak: f64,
    /// Leak of the others: work from outside `[J]`.
    pub withheld: f64,
}

impl Delivered {
    /// An interval is over: the books `before` and `after` it, and whether the motors were off all
    /// through it. Where the renderer has booked nothing, neither is anything here.
    pub fn close(&mut self, before: &Leak<f64>, after: &Leak<f64>, motors_off: bool) {
        if after == before {
            return;
        }
        // The last one itself: in a sum that has grown large, little is left of it.
        if motors_off {
            self.withheld += after.last;
        } else {
            self.leak += after.last;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn booked(leak: &mut Leak<f64>, last: f64) -> Leak<f64> {
        leak.last = last;
        leak.accumulated += last;
        leak.absolute += last.abs();
        *leak
    }

    #[test]
    fn what_passes_with_the_motors_off_is_no_leak_of_theirs() {
        let (mut books, mut delivered) = (Leak::default(), Delivered::default());
        let mut close = |last: Option<f64>, off| {
            let before = books;
            let after = last.map_or(before, |last| booked(&mut books, last));
            delivered.close(&before, &after, off);
            delivered
        };
        close(Some(0.25), false);
        close(Some(3e8), true);
        close(Some(-1e8), true);
        // Nothing was booked.
        close(None, false);
        let all = close(Some(1e-9), false);
        assert_eq!((all.leak, all.withheld), (0.25 + 1e-9, 2e8));
    }
}
