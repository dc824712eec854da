//! Estimate of a position sensor's error beyond its quantum, from free motion.

use crate::Scalar;

/// White noise of a position sensor, estimated from free motion.
///
/// White noise of variance R in the positions gives two successive third differences, d_(k-1) and d_k, the covariance
/// -15 R. A motion that is smooth over four samples gives them the same sign. The mean of -d_k d_(k-1)/15 is therefore
/// at most R if the motion is smooth over four samples. Intervals with a held force are excluded, because the force
/// bends the motion at each sample. Intervals in which the device moves by less than a few model quanta are excluded,
/// because the rounding errors then have a pattern.
///
/// The estimate applies to one axis. Coupled rendering contains its own; this type is public for programs that observe
/// a device themselves.
#[derive(Clone, Copy, Debug, Default)]
pub struct SensorNoise<S> {
    /// Duration of the last interval `[s]`.
    elapsed: S,
    /// Velocity over the last interval `[m/s]`.
    velocity: S,
    /// Its difference from the previous velocity `[m/s]`.
    change: S,
    /// The difference of that from the previous difference `[m/s]`.
    bend: S,
    /// Number of successive free intervals, at most [`BEFORE_ONE_COUNTS`].
    in_a_row: u8,
    /// Sum of -d_k d_(k-1) `[m^2]`.
    sum: S,
    /// Number of intervals in the sum.
    count: S,
    /// Estimated variance in use `[m^2]`; 0 if the model value is used.
    found: S,
    /// Estimated variance in use when an observer began `[m^2]`; 0 if it was the model value.
    begun_with: S,
}

/// Measurement of one interval.
#[derive(Clone, Copy, Debug)]
pub struct SensorInterval<S> {
    /// Change of the measured position `[m]`.
    pub moved: S,
    /// Duration of the interval `[s]`.
    pub elapsed: S,
    /// Displacement of the device by the held force `[m]`.
    pub pushed: S,
    /// Expected displacement of the device `[m]`.
    pub expected: S,
}

/// Number of intervals in two third differences.
const BEFORE_ONE_COUNTS: u8 = 4;
/// Covariance of two successive third differences divided by the variance of a position, without its sign.
const COVARIANCE: f64 = 15.0;
/// Relative standard deviation of the estimate of R from n intervals, times the square root of n, for Gaussian noise
/// (Bartlett's formula for a sample covariance, with the covariances 20, -15, 6 and -1 of third differences).
const DEVIATION: f64 = 2.51;
/// An estimate is accepted if it exceeds the model value times this factor: rounding errors are not exactly white, and
/// smaller differences matter little.
const MUCH: f64 = 2.0;
/// Additional number of standard deviations for acceptance.
const DOUBTS: f64 = 3.0;
/// Number of intervals after which both sums are halved, so that the estimate follows a changing noise.
const REMEMBERED: f64 = 1024.0;
/// Largest relative difference of the durations of two intervals that count as successive.
const UNEVEN: f64 = 0.2;
/// Smallest motion in quanta per sample; below it the rounding errors have a pattern.
const QUANTA: f64 = 4.0;
/// Largest displacement by a held force in a free interval, relative to the sensor's standard deviation.
const UNSEEN: f64 = 0.1;
/// Limit of one interval's contribution, as a multiple of the mean: knocking on the device kicks it once.
const OUTLIER: f64 = 10.0;
/// Number of intervals from which the limit applies; before, the mean is unknown.
const BEFORE_OUTLIERS: f64 = 16.0;
/// An observer that began with less than the variance divided by this factor has interpreted the noise as motion.
const MISCLASSIFIED: f64 = 4.0;
/// Largest accepted standard deviation `[m]`: larger values come from a hand that shakes the device.
const MOST: f64 = 2e-5;

impl<S: Scalar> SensorNoise<S> {
    /// Processes an interval of a sensor with the model variance `model` `[m^2]`. Returns whether the variance exceeds
    /// the one used by the observer by so much that the observer should restart.
    pub fn take(&mut self, interval: &SensorInterval<S>, model: S) -> bool {
        let square = |x: S| x * x;
        let longer = interval.elapsed.max(self.elapsed);
        let even = (interval.elapsed - self.elapsed).abs() <= S::from_f64(UNEVEN) * longer;
        let free = square(interval.pushed) <= S::from_f64(UNSEEN * UNSEEN) * model;
        if !(even && free) {
            self.in_a_row = 0;
        }
        self.in_a_row = (self.in_a_row + u8::from(free)).min(BEFORE_ONE_COUNTS);
        let velocity = interval.moved / interval.elapsed;
        let change = velocity - self.velocity;
        let bend = change - self.change;
        let product = -(bend * self.bend) * square(interval.elapsed);
        (self.elapsed, self.velocity, self.change, self.bend) =
            (interval.elapsed, velocity, change, bend);
        let quantum = S::from_f64(12.0) * model;
        let moves = square(interval.expected) >= S::from_f64(QUANTA * QUANTA) * quantum;
        let counts = self.in_a_row == BEFORE_ONE_COUNTS && moves && product.is_finite();
        counts && self.count_in(product, model)
    }

    // Not inlined: it has a root and divisions, and does not run in contact.
    #[inline(never)]
    fn count_in(&mut self, product: S, model: S) -> bool {
        let mut product = product;
        if self.count >= S::from_f64(BEFORE_OUTLIERS) {
            let usual = (S::from_f64(COVARIANCE) * model).max(self.sum / self.count);
            product = product.within(S::from_f64(OUTLIER) * usual);
        }
        self.sum += product;
        self.count += S::ONE;
        if self.count >= S::from_f64(REMEMBERED) {
            self.sum = S::HALF * self.sum;
            self.count = S::HALF * self.count;
        }
        self.found = self.beyond(model);
        let misclassified = self.found > S::from_f64(MISCLASSIFIED) * self.begun_with.max(model);
        if misclassified {
            self.begun_with = self.found;
        }
        misclassified
    }

    /// Returns the estimate minus one standard deviation if it significantly exceeds `model` `[m^2]`, otherwise 0.
    fn beyond(&self, model: S) -> S {
        let count = self.count.max(S::ONE);
        let deviation = S::from_f64(DEVIATION) / count.sqrt();
        let mean = self.sum / (S::from_f64(COVARIANCE) * count);
        let unsure = model * (S::from_f64(MUCH) + S::from_f64(DOUBTS) * deviation);
        if mean <= unsure || deviation >= S::ONE {
            return S::ZERO;
        }
        (mean * (S::ONE - deviation)).min(S::from_f64(MOST * MOST))
    }

    /// Returns the variance of a measured position `[m^2]`: the model value `model`, or the estimate minus one standard
    /// deviation if free motion shows a significantly larger variance.
    #[inline]
    #[must_use]
    pub fn variance(&self, model: S) -> S {
        self.found.max(model)
    }

    /// Returns the standard deviation of the sensor's error shown by free motion `[m]`, independent of the model value:
    /// the estimate minus its standard deviation, or 0.
    #[must_use]
    pub fn deviation(&self) -> S {
        self.beyond(S::ZERO).sqrt()
    }

    /// Notes missing samples: the next interval does not follow the last one.
    pub fn interrupted(&mut self) {
        self.in_a_row = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: f64 = 0.001;

    /// Reproducible normal numbers of deviation 1: sums of twelve numbers of a linear congruential generator.
    fn normal() -> impl FnMut() -> f64 {
        let mut state = 1_u64;
        move || {
            let mut sum = -6.0;
            for _ in 0..12 {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                sum += (state >> 11) as f64 / (1_u64 << 53) as f64;
            }
            sum
        }
    }

    /// Returns the deviation found in the positions of `samples` samples with the model value `quantum`.
    fn found(samples: usize, quantum: f64, mut position: impl FnMut(f64) -> f64) -> f64 {
        let model = (quantum * quantum).max(1e-18) / 12.0;
        let mut noise = SensorNoise::default();
        let mut last = position(0.0);
        for k in 1..samples {
            let now = position(k as f64 * PERIOD);
            let interval = SensorInterval {
                moved: now - last,
                elapsed: PERIOD,
                pushed: 0.0,
                expected: now - last,
            };
            noise.take(&interval, model);
            last = now;
        }
        noise.variance(model).sqrt()
    }

    /// Position of a swinging, trembling hand.
    fn hand(t: f64) -> f64 {
        0.05 * (6.0 * t).sin() + 0.0005 * (60.0 * t).sin()
    }

    #[test]
    fn noise_of_a_sensor_in_a_moving_hand_is_found() {
        for deviation in [1e-7, 1e-6, 1e-5] {
            let mut normal = normal();
            let found = found(1000, 0.0, |t| hand(t) + deviation * normal());
            assert!(
                (0.85..=1.05).contains(&(found / deviation)),
                "{found:e} of {deviation:e}"
            );
        }
    }

    #[test]
    fn few_samples_say_less_than_there_is() {
        let mut normal = normal();
        let deviation = 5e-6;
        let mut position = |t| hand(t) + deviation * normal();
        assert!(found(8, 0.0, &mut position) < 1e-9);
        for _ in 0..50 {
            let found = found(40, 0.0, &mut position);
            assert!(found < 1.3 * deviation, "{found:e}");
        }
    }

    #[test]
    fn a_hand_alone_is_no_noise() {
        assert!(found(3000, 0.0, hand) < 1e-9);
        // Dry friction, whose acceleration changes its sign, does not count as noise.
        let rubbed = |t: f64| {
            let phase = (5.0 * t).fract();
            let (sign, half) = if phase < 0.5 {
                (1.0, phase)
            } else {
                (-1.0, phase - 0.5)
            };
            sign * 0.5 * half * (0.5 - half)
        };
        assert!(found(3000, 0.0, rubbed) < 1e-9);
    }

    #[test]
    fn a_knock_is_no_noise() {
        // A device that is stopped and pushed back at 0.25 m/s in each direction, five times a second.
        let knocked = |t: f64| 0.05 * ((5.0 * t).fract() - 0.5).abs();
        let found = found(3000, 1e-6, knocked);
        assert!(found < 1e-6, "{found:e}");
    }

    #[test]
    fn rounding_adds_no_noise_beyond_the_model_quantum() {
        let quantum = 1e-5;
        let rounded = |position: f64| (position / quantum).round() * quantum;
        for speed in [0.0, 0.001, 0.005, 0.006, 0.05, 0.3, 1.0] {
            let found = found(1000, quantum, |t| {
                rounded(speed * (t + 0.2 * t * t) + 1e-6 * (60.0 * t).sin())
            });
            let model = quantum / 12_f64.sqrt();
            assert!(found < 1.01 * model, "{found:e} at {speed} m/s");
        }
    }

    #[test]
    fn what_a_force_moves_is_no_noise() {
        let mut noise = SensorNoise::default();
        let mut normal = normal();
        for k in 0..1000 {
            let interval = SensorInterval {
                moved: 1e-3 + 1e-5 * normal(),
                elapsed: PERIOD,
                // Never four successive intervals without a force.
                pushed: if k % 4 == 0 { 1e-6 } else { 0.0 },
                expected: 1e-3,
            };
            noise.take(&interval, 1e-18);
        }
        assert_eq!(noise.variance(1e-18), 1e-18);
    }

    #[test]
    fn no_more_is_believed_than_a_sensor_has() {
        let mut normal = normal();
        let found = found(1000, 0.0, |_| 0.01 * normal());
        assert!((found - MOST).abs() < 1e-12, "{found:e}");
    }
}
