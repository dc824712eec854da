//! Sampling times of a device with a clock of its own.

use std::time::Duration;

/// Largest drift of a device's clock against the loop's.
const DRIFT: f64 = 200e-6;
/// Interval at which the rate of the device's clock is checked `[s]`.
const RATE_CHECKED_EVERY: f64 = 1.0;
/// Allowed rate of the device's clock. Milliseconds in place of seconds give 1000.
const RATE: std::ops::RangeInclusive<f64> = 0.5..=2.0;

/// Sampling time on the loop's clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stamp {
    /// The sample was taken at this time.
    At(Duration),
    /// The device's time did not increase.
    NotLater,
    /// The device's time does not run in seconds.
    NotSeconds,
}

/// Map from the device's clock to the loop's. The fastest message gives the difference of the clocks, with the delay of
/// that message; a slower one keeps its sampling time. The difference follows a drift.
#[derive(Clone, Copy, Debug, Default)]
pub struct DeviceTime {
    /// First times of device and loop, and of the current check of the rate `[s]`.
    first: Option<[f64; 2]>,
    checked: [f64; 2],
    /// Last times since the first ones `[s]`.
    last: [f64; 2],
    /// Loop's time minus device's, since the first ones `[s]`.
    difference: f64,
}

impl DeviceTime {
    /// Returns the sampling time of a sample that was taken at `time` of the device `[s]` and arrived at `now`.
    pub fn of(&mut self, time: f64, now: Duration) -> Stamp {
        let arrival = now.as_secs_f64();
        let Some([device, host]) = self.first else {
            self.first = Some([time, arrival]);
            return Stamp::At(now);
        };
        let [time, arrival] = [time - device, arrival - host];
        let [last, before] = self.last;
        if time <= last {
            return Stamp::NotLater;
        }
        self.last = [time, arrival];
        let [checked_time, checked_arrival] = self.checked;
        let since = arrival - checked_arrival;
        if since >= RATE_CHECKED_EVERY {
            self.checked = self.last;
            if !RATE.contains(&((time - checked_time) / since)) {
                return Stamp::NotSeconds;
            }
        }
        let drifted = self.difference + DRIFT * (arrival - before);
        self.difference = drifted.min(arrival - time);
        let age = (arrival - time - self.difference).max(0.0);
        Stamp::At(now.saturating_sub(Duration::try_from_secs_f64(age).unwrap_or(now)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: Duration = Duration::from_millis(1);

    #[test]
    fn a_slow_message_keeps_its_sampling_time() {
        let mut time = DeviceTime::default();
        assert_eq!(time.of(1e6, MS * 100), Stamp::At(MS * 100));
        // It was 3 ms on its way, the first 0 ms.
        let Stamp::At(stamp) = time.of(1e6 + 0.010, MS * 113) else {
            panic!()
        };
        assert!(
            stamp.abs_diff(MS * 110) < Duration::from_micros(5),
            "{stamp:?}"
        );
        // A faster one than the first.
        let Stamp::At(stamp) = time.of(1e6 + 0.020, MS * 119) else {
            panic!()
        };
        assert!(
            stamp.abs_diff(MS * 119) < Duration::from_micros(5),
            "{stamp:?}"
        );
        let Stamp::At(stamp) = time.of(1e6 + 0.021, MS * 121) else {
            panic!()
        };
        assert!(
            stamp.abs_diff(MS * 120) < Duration::from_micros(5),
            "{stamp:?}"
        );
        assert_eq!(time.of(1e6 + 0.021, MS * 122), Stamp::NotLater);
    }

    #[test]
    fn milliseconds_in_place_of_seconds_are_noticed() {
        for rate in [1000.0, 0.0001] {
            let mut time = DeviceTime::default();
            let found = (0..3000).map(|ms| time.of(rate * f64::from(ms) * 1e-3, MS * ms));
            assert!(
                found.into_iter().any(|stamp| stamp == Stamp::NotSeconds),
                "{rate}"
            );
        }
        let mut time = DeviceTime::default();
        let found = (0..3000).map(|ms| time.of(1.0001 * f64::from(ms) * 1e-3, MS * ms));
        assert!(found.into_iter().all(|stamp| matches!(stamp, Stamp::At(_))));
    }
}
