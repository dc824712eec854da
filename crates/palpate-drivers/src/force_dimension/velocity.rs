//! Comparison of the library's velocities with those of its positions.

use std::time::Duration;

use palpate_device::Vector;

/// Window of the library's estimate by default.
const WINDOW: Duration = Duration::from_millis(20);
/// Longest window of ours that is comparable.
const MAX_WINDOW: Duration = Duration::from_millis(30);
/// Number of kept positions: those of the window at 8 kHz and less.
const KEPT: usize = 256;
/// Difference that an acceleration within the window explains: a constant `[m/s]` and a part of the speed.
const ALLOWED: (f64, f64) = (0.05, 0.25);
/// Least number of comparisons, and the part that must differ for a message.
const MIN_COMPARED: u64 = 100;
const MIN_PART: f64 = 0.1;

/// Comparison of velocities. Wrong units, a mixed-up axis or positions that do not follow the device show in it.
#[derive(Debug)]
pub struct VelocityCheck {
    /// Ring of positions with their times.
    kept: [(Duration, Vector); KEPT],
    next: usize,
    filled: usize,
    compared: u64,
    differ: u64,
    /// Largest difference `[m/s]`.
    worst: f64,
}

impl VelocityCheck {
    pub fn new() -> Self {
        Self {
            kept: [(Duration::ZERO, [0.0; 3]); KEPT],
            next: 0,
            filled: 0,
            compared: 0,
            differ: 0,
            worst: 0.0,
        }
    }

    /// Compares the library's velocity `[m/s]` with that of the positions up to `position` `[m]`.
    pub fn compare(&mut self, now: Duration, position: Vector, velocity: Vector) {
        // The newest position that is old enough.
        let before = (1..=self.filled)
            .filter_map(|back| self.kept.get((self.next + KEPT - back) % KEPT))
            .find(|(time, _)| now.saturating_sub(*time) >= WINDOW);
        if let Some((time, there)) = before {
            let span = now.saturating_sub(*time);
            if span <= MAX_WINDOW {
                let own = [0, 1, 2].map(|axis: usize| {
                    let [to, from] =
                        [position, *there].map(|place| place.get(axis).copied().unwrap_or(0.0));
                    (to - from) / span.as_secs_f64()
                });
                self.count(own, velocity);
            }
        }
        if let Some(place) = self.kept.get_mut(self.next) {
            *place = (now, position);
        }
        self.next = (self.next + 1) % KEPT;
        self.filled = (self.filled + 1).min(KEPT);
    }

    fn count(&mut self, own: Vector, given: Vector) {
        let norm = |of: Vector| of.iter().map(|part| part * part).sum::<f64>().sqrt();
        let [ox, oy, oz] = own;
        let [gx, gy, gz] = given;
        let off = norm([gx - ox, gy - oy, gz - oz]);
        let (least, part) = ALLOWED;
        let fits = off <= least + part * norm(own);
        self.compared += 1;
        self.differ += u64::from(!fits);
        if off.is_finite() {
            self.worst = self.worst.max(off);
        }
    }

    /// Returns a message if many velocities differ.
    pub fn message(&self) -> Option<String> {
        let is_often = self.differ as f64 > MIN_PART * self.compared as f64;
        (self.compared >= MIN_COMPARED && is_often).then(|| {
            format!(
                "the library's velocity differs from that of its positions in {} of {} samples, by up to {:.3} m/s: \
                 another unit, axis or window of the velocity, or positions that do not follow the device",
                self.differ, self.compared, self.worst
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(velocity: impl Fn(f64) -> f64) -> Option<String> {
        let mut check = VelocityCheck::new();
        for ms in 0..500_u32 {
            let time = f64::from(ms) * 1e-3;
            // 20 mm at 2 Hz.
            let x = 0.02 * (12.566 * time).sin();
            let now = Duration::from_millis(ms.into());
            check.compare(now, [x, 0.0, 0.0], [velocity(time), 0.0, 0.0]);
        }
        check.message()
    }

    #[test]
    fn millimetres_are_noticed_and_a_velocity_of_the_same_window_is_not() {
        let mean = |time: f64| 0.02 * 12.566 * (12.566 * (time - 0.01)).cos();
        assert_eq!(after(mean), None);
        let message = after(|time| 1e3 * mean(time)).unwrap();
        assert!(message.contains("another unit"), "{message}");
        assert!(after(|_| f64::NAN).is_some());
    }
}
