//! Which force was held since a sample.

use std::time::Duration;

use palpate_device::Vector;

/// The force on the device that was held since the last sample: one, or the mean of several.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct HeldSince {
    force: Vector,
    since: Option<Duration>,
    changed: bool,
    impulse: Vector,
    span: f64,
}

impl HeldSince {
    /// `force` is held from `now` on `[N]`.
    pub fn change(&mut self, force: Vector, now: Duration) {
        self.settle(now);
        self.changed |= self.span > 0.0 && force != self.force;
        self.force = force;
    }

    /// Mean of what was held up to `now` `[N]`; begins anew from there. None before the first
    /// force.
    pub fn take(&mut self, now: Duration) -> Option<Vector> {
        self.since?;
        self.settle(now);
        let mean = if self.changed && self.span > 0.0 {
            self.impulse.map(|impulse| impulse / self.span)
        } else {
            self.force
        };
        (self.changed, self.impulse, self.span) = (false, [0.0; 3], 0.0);
        Some(mean)
    }

    fn settle(&mut self, now: Duration) {
        let span = now.saturating_sub(self.since.unwrap_or(now)).as_secs_f64();
        for (impulse, force) in self.impulse.iter_mut().zip(self.force) {
            *impulse += force * span;
        }
        self.span += span;
        self.since = Some(self.since.map_or(now, |since| since.max(now)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_force_is_itself_and_several_are_their_mean() {
        let ms = Duration::from_millis;
        let mut held = HeldSince::default();
        assert_eq!(held.take(ms(0)), None);
        held.change([3.0, 0.0, -1.0], ms(1));
        assert_eq!(held.take(ms(4)), Some([3.0, 0.0, -1.0]));
        held.change([1.0, 0.0, 4.0], ms(4));
        held.change([0.1, 0.0, 0.0], ms(5));
        // 1 ms of 1 N, 3 ms of 0.1 N; 1 ms of 4 N
        let [x, y, z] = held.take(ms(8)).unwrap();
        assert!((x - 1.3 / 4.0).abs() < 1e-12, "{x}");
        assert!(y == 0.0 && (z - 1.0).abs() < 1e-12, "{y} {z}");
        assert_eq!(held.take(ms(9)), Some([0.1, 0.0, 0.0]));
    }
}
