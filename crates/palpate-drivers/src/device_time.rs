//! Sampling times of a device with a clock of its own.

use std::cmp::Ordering;
use std::time::Duration;

/// Largest drift of a device's clock against its estimated rate.
const DRIFT: f64 = 200e-6;
/// Largest estimate of how much slower the device's clock runs: that of a microcontroller without a crystal.
const SLOWEST: f64 = 0.02;
/// Interval of the estimate `[s]`: until it is known after three, a slow clock adds its error to the sample's age.
const ESTIMATED_EVERY: f64 = 0.1;
/// Interval at which the rate of the device's clock is checked `[s]`.
const RATE_CHECKED_EVERY: f64 = 0.5;
/// Allowed rate of the device's clock. Milliseconds in place of seconds give 1000. Only a clock that leaves it on the
/// same side in two successive intervals is wrong: a late sample makes one too slow and the next too fast.
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
/// that message; a slower one keeps its sampling time. The difference follows a drift, and the rate of a slow clock.
#[derive(Clone, Copy, Debug, Default)]
pub struct DeviceTime {
    /// First times of device and loop, and of the current check of the rate `[s]`.
    first: Option<[f64; 2]>,
    checked: [f64; 2],
    /// Side on which the rate of the last check left [`RATE`].
    off: Option<Ordering>,
    /// Last times since the first ones `[s]`.
    last: [f64; 2],
    /// Loop's time minus device's, since the first ones `[s]`.
    difference: f64,
    rate: Rate,
}

/// Estimate of how much slower the device's clock runs, from the least differences of successive intervals.
#[derive(Clone, Copy, Debug, Default)]
struct Rate {
    /// Begin of the interval and its least difference `[s]`.
    least: [f64; 2],
    /// Those of the interval before.
    before: Option<[f64; 2]>,
    /// Growth of the least difference between the last two intervals.
    growth: f64,
    /// Estimate. A growth that does not last is a delay of messages.
    slower: f64,
}

impl Rate {
    /// Takes the difference of a sample that arrived at `arrival`, and returns the estimate.
    fn of(&mut self, arrival: f64, difference: f64) -> f64 {
        let [begun, least] = self.least;
        if arrival - begun < ESTIMATED_EVERY {
            self.least = [begun, least.min(difference)];
            return self.slower;
        }
        if let Some([begun_before, least_before]) = self.before {
            let growth = (least - least_before) / (begun - begun_before);
            self.slower = growth.min(self.growth).clamp(0.0, SLOWEST);
            self.growth = growth;
        }
        self.before = Some(self.least);
        self.least = [arrival, difference];
        self.slower
    }
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
            let rate = (time - checked_time) / since;
            let off = if rate > *RATE.end() {
                Some(Ordering::Greater)
            } else {
                (rate < *RATE.start()).then_some(Ordering::Less)
            };
            if std::mem::replace(&mut self.off, off) == off && off.is_some() {
                return Stamp::NotSeconds;
            }
        }
        let slower = self.rate.of(arrival, arrival - time);
        let drifted = self.difference + (slower + DRIFT) * (arrival - before);
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
    fn a_slow_clock_is_followed_and_a_longer_delay_is_not_taken_for_one() {
        // The largest age of a sample that arrives at once, with the clock of a device at this rate.
        for (rate, largest) in [(0.995, 2), (0.98, 7), (1.02, 1)] {
            let mut time = DeviceTime::default();
            for ms in 0..60_000 {
                let now = MS * ms;
                let Stamp::At(stamp) = time.of(rate * now.as_secs_f64(), now) else {
                    panic!("{rate}: {ms} ms");
                };
                assert!(now - stamp <= MS * largest, "{rate}: {ms} ms: {stamp:?}");
            }
        }
        let mut time = DeviceTime::default();
        for ms in 0..5_000 {
            let sampled = MS * ms;
            let delay = if ms < 2_000 { MS } else { MS * 30 };
            let Stamp::At(stamp) = time.of(sampled.as_secs_f64(), sampled + delay) else {
                panic!("{ms} ms");
            };
            assert!(stamp.abs_diff(sampled) < MS * 2, "{ms} ms: {stamp:?}");
        }
    }

    /// One sample arrives late at any moment, and the device is silent until then.
    #[test]
    fn a_late_sample_of_a_right_clock_is_no_wrong_clock() {
        for late in [300, 800, 950] {
            for from in (100..2_000).step_by(50) {
                let mut time = DeviceTime::default();
                for ms in (0..=from).chain(from + late + 1..6_000) {
                    let delay = if ms == from { late } else { 0 };
                    let stamp = time.of(f64::from(ms) * 1e-3, MS * (ms + delay));
                    assert!(matches!(stamp, Stamp::At(_)), "{late} from {from}: {ms} ms");
                }
            }
        }
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
