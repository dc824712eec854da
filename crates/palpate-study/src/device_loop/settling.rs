//! Phase before the excitation: the hand moves the device to the calibration position and holds it still.

use std::collections::VecDeque;
use std::time::Duration;

use palpate_device::Vector;

/// Required duration of the rest.
const STILL_FOR: Duration = Duration::from_millis(500);
/// Time limit for coming to rest.
pub const PATIENCE: Duration = Duration::from_secs(10);

/// Detector of a device at rest.
#[derive(Clone, Debug)]
pub struct Settling {
    /// Largest distance from the mean over [`STILL_FOR`], root mean square `[m]`.
    limit: f64,
    recent: VecDeque<(Duration, Vector)>,
}

impl Settling {
    /// Creates a detector without samples. `limit` is the maximum tremor, root mean square `[m]`.
    pub fn within(limit: f64) -> Self {
        Self {
            limit,
            recent: VecDeque::new(),
        }
    }

    /// Adds a sample and returns whether the device has been at rest for long enough.
    pub fn is_still_at(&mut self, time: Duration, position: Vector) -> bool {
        self.recent.push_back((time, position));
        let mut is_long_enough = false;
        while let Some(&(first, _)) = self.recent.front()
            && time.saturating_sub(first) > STILL_FOR
        {
            self.recent.pop_front();
            is_long_enough = true;
        }
        is_long_enough && self.deviation() <= self.limit
    }

    /// Returns the root mean square of the distance from the mean `[m]`.
    fn deviation(&self) -> f64 {
        let count = self.recent.len() as f64;
        let variance: f64 = (0..3)
            .map(|axis| {
                let values = || self.recent.iter().map(|(_, position)| position[axis]);
                let mean = values().sum::<f64>() / count;
                values().map(|value| (value - mean).powi(2)).sum::<f64>() / count
            })
            .sum();
        variance.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_device_is_still_half_a_second_after_it_came_to_rest() {
        let mut settling = Settling::within(1e-3);
        let came_to_rest = 0.8;
        let still = (0..3000).find(|ms| {
            let time = f64::from(*ms) * 1e-3;
            // The device begins at rest, but not for long enough.
            let part = ((time - 0.2) / (came_to_rest - 0.2)).clamp(0.0, 1.0);
            let position = [0.0, 0.015 * part, 0.0];
            settling.is_still_at(Duration::from_secs_f64(time), position)
        });
        let still = f64::from(still.unwrap()) * 1e-3;
        assert!((1.1..1.31).contains(&still), "{still}");
    }

    #[test]
    fn a_hand_that_trembles_too_much_is_never_still() {
        for (amplitude, is_still) in [(1.3e-3, true), (1.6e-3, false)] {
            let mut settling = Settling::within(1e-3);
            let mut was_still = false;
            for ms in 0..3000 {
                let time = f64::from(ms) * 1e-3;
                let position = [0.0, 0.0, amplitude * (60.0 * time).sin()];
                was_still |= settling.is_still_at(Duration::from_secs_f64(time), position);
            }
            assert_eq!(was_still, is_still, "{amplitude}");
        }
    }
}
