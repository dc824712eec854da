//! Which force and torque were held since a sample.

use std::time::Duration;

use palpate_device::{Vector, Wrench};

/// What was held on the device since the last sample: one wrench, or the mean of several.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct HeldSince {
    wrench: Wrench,
    since: Option<Duration>,
    changed: bool,
    /// Impulse `[N s]` and angular impulse `[N m s]`.
    impulse: Wrench,
    span: f64,
}

impl HeldSince {
    /// `wrench` is held from `now` on.
    pub fn change(&mut self, wrench: Wrench, now: Duration) {
        self.settle(now);
        self.changed |= self.span > 0.0 && wrench != self.wrench;
        self.wrench = wrench;
    }

    /// Mean of what was held up to `now`; begins anew from there. None before the first command.
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
        Some(mean)
    }

    fn settle(&mut self, now: Duration) {
        let span = now.saturating_sub(self.since.unwrap_or(now)).as_secs_f64();
        let add = |impulse: &mut Vector, held: Vector| {
            for (impulse, held) in impulse.iter_mut().zip(held) {
                *impulse += held * span;
            }
        };
        add(&mut self.impulse.force, self.wrench.force);
        add(&mut self.impulse.torque, self.wrench.torque);
        self.span += span;
        self.since = Some(self.since.map_or(now, |since| since.max(now)));
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
}
