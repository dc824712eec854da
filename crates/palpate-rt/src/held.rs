//! Wrench held since a sample.

use std::time::Duration;

use palpate_device::{Line, Vector, Wrench};

/// Wrench held on the device since the last sample: one wrench, or the mean of several or of lines.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct HeldSince {
    /// Line that is held, and the time at which it began.
    line: Line,
    begun: Duration,
    since: Option<Duration>,
    changed: bool,
    /// Impulse `[N s]` and angular impulse `[N m s]`.
    impulse: Wrench,
    span: f64,
    /// Line held before the current zero wrench.
    before_none: Option<BeforeNone>,
}

/// A line that zero force has replaced.
#[derive(Clone, Copy, Debug)]
struct BeforeNone {
    line: Line,
    begun: Duration,
    /// Start and end of its contribution to the impulse.
    from: Duration,
    until: Duration,
}

impl HeldSince {
    /// Sets the line held from `now` on.
    pub fn change(&mut self, line: impl Into<Line>, now: Duration) {
        let line = line.into();
        if !is_none(&line) {
            self.before_none = None;
        } else if !is_none(&self.line) {
            let from = self.since.unwrap_or(now);
            self.before_none = Some(BeforeNone {
                line: self.line,
                begun: self.begun,
                from,
                until: now.max(from),
            });
        }
        self.settle(now);
        // A line differs from its own mean.
        let is_same = line.is_constant() && line.wrench == self.line.wrench;
        self.changed |= !self.line.is_constant() || (self.span > 0.0 && !is_same);
        (self.line, self.begun) = (line, now);
    }

    /// Sets the held wrench to zero from `at` on. The earliest of several cuts counts; it may be reported last.
    pub fn cut(&mut self, at: Duration) {
        match self.before_none {
            Some(before) if is_none(&self.line) => {
                let since = at.max(before.from);
                if since < before.until {
                    let [from, until] =
                        [since, before.until].map(|time| time.saturating_sub(before.begun));
                    self.add(&before.line.impulse(from, until), -1.0);
                    self.changed = true;
                    self.before_none = Some(BeforeNone {
                        until: since,
                        ..before
                    });
                }
            }
            _ => self.change(Wrench::NONE, at),
        }
    }

    /// Returns the mean wrench held up to `now` and restarts the mean; `None` before the first command.
    pub fn take(&mut self, now: Duration) -> Option<Wrench> {
        self.since?;
        self.settle(now);
        let is_even = self.line.is_constant() && !self.changed;
        let mean = if !is_even && self.span > 0.0 {
            let span = self.span;
            self.impulse.each(|impulse| impulse.map(|part| part / span))
        } else {
            self.line.wrench
        };
        (self.changed, self.impulse, self.span) = (false, Wrench::NONE, 0.0);
        self.before_none = None;
        Some(mean)
    }

    fn settle(&mut self, now: Duration) {
        let since = self.since.unwrap_or(now);
        let [from, until] = [since, now.max(since)].map(|time| time.saturating_sub(self.begun));
        self.add(&self.line.impulse(from, until), 1.0);
        self.span += now.saturating_sub(since).as_secs_f64();
        self.since = Some(since.max(now));
    }

    /// Adds an impulse times `sign`.
    fn add(&mut self, added: &Wrench, sign: f64) {
        let add = |impulse: &mut Vector, added: Vector| {
            for (impulse, added) in impulse.iter_mut().zip(added) {
                *impulse += sign * added;
            }
        };
        add(&mut self.impulse.force, added.force);
        add(&mut self.impulse.torque, added.torque);
    }
}

fn is_none(line: &Line) -> bool {
    line.is_constant() && line.wrench == Wrench::NONE
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

    #[test]
    fn mean_of_a_line_is_that_of_its_course_and_ends_with_it_or_with_a_cut() {
        let ms = Duration::from_millis;
        let line = Line {
            wrench: Wrench::of_force([2.0, 0.0, 0.0]),
            slope: [200.0, 0.0, 0.0],
            duration: ms(10),
        };
        let held = |until: u64, cut: Option<u64>| {
            let mut held = HeldSince::default();
            held.change(line, ms(5));
            if let Some(cut) = cut {
                held.change(Wrench::NONE, ms(until));
                held.cut(ms(cut));
            }
            held.take(ms(until)).unwrap().force[0]
        };
        let close = |found: f64, expected: f64| {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        };
        close(held(15, None), 2.0);
        // 1 N to 2 N, in half of the line.
        close(held(10, None), 1.5);
        // The whole line, then 5 ms of its last value.
        close(held(20, None), (10.0 * 2.0 + 5.0 * 3.0) / 15.0);
        // Half of the line, then nothing.
        close(held(20, Some(10)), 5.0 * 1.5 / 15.0);
        close(held(15, Some(10)), 5.0 * 1.5 / 10.0);
        // The next mean begins within the line.
        let mut late = HeldSince::default();
        late.change(line, ms(5));
        late.take(ms(10)).unwrap();
        late.change(line, ms(15));
        close(
            late.take(ms(20)).unwrap().force[0],
            (5.0 * 2.5 + 5.0 * 1.5) / 10.0,
        );
    }
}
