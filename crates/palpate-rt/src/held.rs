//! Wrench held since a sample.

use std::time::Duration;

use palpate_device::{Vector, Wrench};

/// Wrench held on the device since the last sample: one wrench, or the mean of several.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct HeldSince {
    wrench: Wrench,
    since: Option<Duration>,
    changed: bool,
    /// Impulse `[N s]` and angular impulse `[N m s]`.
    impulse: Wrench,
    span: f64,
    /// Wrench held before the current zero wrench, with the start and end of its contribution to the impulse.
    before_none: Option<(Wrench, Duration, Duration)>,
}

impl HeldSince {
    /// Sets the wrench held from `now` on.
    pub fn change(&mut self, wrench: Wrench, now: Duration) {
        if wrench != Wrench::NONE {
            self.before_none = None;
        } else if self.wrench != Wrench::NONE {
            let from = self.since.unwrap_or(now);
            self.before_none = Some((self.wrench, from, now.max(from)));
        }
        self.settle(now);
        self.changed |= self.span > 0.0 && wrench != self.wrench;
        self.wrench = wrench;
    }

    /// Sets the held wrench to zero from `at` on. The earliest of several cuts counts; it may be reported last.
    pub fn cut(&mut self, at: Duration) {
        match self.before_none {
            Some((wrench, from, until)) if self.wrench == Wrench::NONE => {
                let since = at.max(from);
                if since < until {
                    self.add(&wrench, -(until - since).as_secs_f64());
                    self.changed = true;
                    self.before_none = Some((wrench, from, since));
                }
            }
            _ => self.change(Wrench::NONE, at),
        }
    }

    /// Returns the mean wrench held up to `now` and restarts the mean; `None` before the first command.
    pub fn take(&mut self, now: Duration) -> Option<Wrench> {
        self.since?;
        self.settle(now);
        let mean = if self.changed && self.span > 0.0 {
            let span = self.span;
            self.impulse.each(|impulse| impulse.map(|part| part / span))
        } else {
            self.wrench
        };
        (self.changed, self.impulse, self.span) = (false, Wrench::NONE, 0.0);
        self.before_none = None;
        Some(mean)
    }

    fn settle(&mut self, now: Duration) {
        let span = now.saturating_sub(self.since.unwrap_or(now)).as_secs_f64();
        let wrench = self.wrench;
        self.add(&wrench, span);
        self.span += span;
        self.since = Some(self.since.map_or(now, |since| since.max(now)));
    }

    /// Adds the impulse of `wrench` over `span` `[s]`.
    fn add(&mut self, wrench: &Wrench, span: f64) {
        let add = |impulse: &mut Vector, held: Vector| {
            for (impulse, held) in impulse.iter_mut().zip(held) {
                *impulse += held * span;
            }
        };
        add(&mut self.impulse.force, wrench.force);
        add(&mut self.impulse.torque, wrench.torque);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_wrench_is_itself_and_several_are_their_mean() {
        let ms = Duration::from_millis;
        let of = |force| Wrench {
            force,
            torque: [0.0, force[0], 0.0],
        };
        let mut held = HeldSince::default();
        assert_eq!(held.take(ms(0)), None);
        held.change(of([3.0, 0.0, -1.0]), ms(1));
        assert_eq!(held.take(ms(4)), Some(of([3.0, 0.0, -1.0])));
        held.change(of([1.0, 0.0, 4.0]), ms(4));
        held.change(of([0.1, 0.0, 0.0]), ms(5));
        // 1 ms of 1 N, 3 ms of 0.1 N; 1 ms of 4 N
        let mean = held.take(ms(8)).unwrap();
        let [x, y, z] = mean.force;
        assert!((x - 1.3 / 4.0).abs() < 1e-12, "{x}");
        assert!(y == 0.0 && (z - 1.0).abs() < 1e-12, "{y} {z}");
        assert_eq!(mean.torque, [0.0, x, 0.0]);
        assert_eq!(held.take(ms(9)), Some(of([0.1, 0.0, 0.0])));
    }

    /// A supervisor reports its cut at 9 ms first; a watchdog process had cut at 3 ms.
    #[test]
    fn earliest_cut_determines_mean_wrench_in_any_report_order() {
        let ms = Duration::from_millis;
        let force = |force| Wrench {
            force: [force, 0.0, 0.0],
            torque: [0.0; 3],
        };
        let mean = |cuts: &[u64]| {
            let mut held = HeldSince::default();
            held.change(force(2.0), ms(1));
            for cut in cuts {
                held.cut(ms(*cut));
            }
            held.change(Wrench::NONE, ms(10));
            held.take(ms(11)).unwrap().force[0]
        };
        assert!((mean(&[3]) - 0.4).abs() < 1e-12);
        assert!((mean(&[9]) - 1.6).abs() < 1e-12);
        for cuts in [[9, 3], [3, 9]] {
            assert!((mean(&cuts) - 0.4).abs() < 1e-12, "{cuts:?}");
        }
        // The mean up to a reading is final, and a new force is held.
        let mut held = HeldSince::default();
        held.change(force(2.0), ms(1));
        held.cut(ms(9));
        held.take(ms(9)).unwrap();
        held.cut(ms(3));
        assert_eq!(held.take(ms(10)), Some(Wrench::NONE));
        held.change(force(2.0), ms(10));
        held.cut(ms(12));
        assert_eq!(held.take(ms(14)), Some(force(1.0)));
    }
}
