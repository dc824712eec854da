//! Position sensor of the device, as an encoder would report it to the loop.

use crate::InvalidParameter;
use crate::error::positive;
use crate::random::SplitMix64;

/// Measurement of a position.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Sampler {
    /// The true position.
    #[default]
    Ideal,
    /// The nearest multiple of an encoder quantum `[m]`; halves are rounded away from zero.
    ///
    /// A quantum that is not finite and positive measures like [`Sampler::Ideal`];
    /// [`Sampler::quantum`] refuses to make one.
    Quantum(f64),
}

impl Sampler {
    /// An encoder with the given quantum `[m]`.
    ///
    /// # Errors
    ///
    /// `quantum` is not finite and positive.
    pub fn quantum(quantum: f64) -> Result<Self, InvalidParameter> {
        positive("quantum", quantum, "finite and above 0 m").map(Self::Quantum)
    }

    /// The measured position `[m]` for a true `position` `[m]`.
    #[must_use]
    pub fn sample(&self, position: f64) -> f64 {
        match *self {
            Self::Quantum(quantum) if quantum.is_finite() && quantum > 0.0 => {
                let multiple = (position / quantum).round();
                // A position too large to count in quanta has no finer digits to lose.
                if multiple.is_finite() {
                    multiple * quantum
                } else {
                    position
                }
            }
            Self::Ideal | Self::Quantum(_) => position,
        }
    }
}

/// White noise of a sensor, the same for the same seed: added to the true position before it is quantised.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorNoise {
    deviation: f64,
    numbers: SplitMix64,
}

/// Seed offset between the generator of the sensor's noise and those of a schedule.
const NOISE_STREAM: u64 = 0x3C6E_F372_FE94_F82B; // fractional digits of √5

impl SensorNoise {
    /// No noise.
    #[must_use]
    pub fn none() -> Self {
        Self {
            deviation: 0.0,
            numbers: SplitMix64::new(0),
        }
    }

    /// Normal noise with a standard deviation `[m]`.
    ///
    /// # Errors
    ///
    /// `deviation` is not finite and at least 0.
    pub fn normal(deviation: f64, seed: u64) -> Result<Self, InvalidParameter> {
        InvalidParameter::unless(
            deviation.is_finite() && deviation >= 0.0,
            "noise",
            deviation,
            "finite and at least 0 m",
        )?;
        Ok(Self {
            deviation,
            numbers: SplitMix64::new(seed ^ NOISE_STREAM),
        })
    }

    /// The noise of the next sample `[m]`; 0 without any.
    #[must_use]
    pub fn draw(&mut self) -> f64 {
        if self.deviation > 0.0 {
            self.deviation * self.numbers.normal()
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_snap_to_the_nearest_multiple() {
        let encoder = Sampler::quantum(0.25).unwrap();
        for (position, expected) in [
            (0.0, 0.0),
            (0.12, 0.0),
            (0.13, 0.25),
            (-0.13, -0.25),
            (1.0, 1.0),
            (0.125, 0.25),
            (-0.125, -0.25),
        ] {
            assert_eq!(encoder.sample(position), expected);
        }
    }

    #[test]
    fn noise_has_its_deviation_no_mean_and_follows_from_its_seed() {
        let drawn = |deviation, seed| -> Vec<f64> {
            let mut noise = SensorNoise::normal(deviation, seed).unwrap();
            (0..20_000).map(|_| noise.draw()).collect()
        };
        let values = drawn(3e-6, 4);
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let square = values.iter().map(|x| x * x).sum::<f64>() / count;
        assert!(mean.abs() < 4.0 * 3e-6 / count.sqrt());
        assert!((square.sqrt() / 3e-6 - 1.0).abs() < 0.03);
        assert_eq!(values, drawn(3e-6, 4));
        assert_ne!(values, drawn(3e-6, 5));
        assert!(drawn(0.0, 4).iter().all(|noise| *noise == 0.0));
        assert!(SensorNoise::normal(f64::NAN, 0).is_err());
    }

    #[test]
    fn the_error_stays_within_half_a_quantum() {
        let quantum = 3.7e-6;
        let encoder = Sampler::quantum(quantum).unwrap();
        for i in -1000..1000 {
            let position = f64::from(i) * 1.234_567e-6;
            assert!((encoder.sample(position) - position).abs() <= 0.5 * quantum * (1.0 + 1e-9));
        }
    }

    #[test]
    fn an_ideal_sampler_changes_nothing() {
        assert_eq!(Sampler::Ideal.sample(0.123_456_789), 0.123_456_789);
    }

    #[test]
    fn a_quantum_must_be_positive_and_cannot_make_a_nan() {
        for quantum in [0.0, -1e-6, f64::NAN, f64::INFINITY] {
            assert!(Sampler::quantum(quantum).is_err());
            assert_eq!(Sampler::Quantum(quantum).sample(0.1), 0.1);
        }
    }
}
