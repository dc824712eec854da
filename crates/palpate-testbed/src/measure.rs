//! What the loop sees of the device: its position, as an encoder would report it.

use crate::InvalidParameter;
use crate::error::positive;

/// How a position is measured.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Sampler {
    /// The true position.
    #[default]
    Ideal,
    /// The nearest multiple of an encoder quantum \[m\]; halves are rounded away from zero.
    ///
    /// A quantum that is not finite and positive measures like [`Sampler::Ideal`];
    /// [`Sampler::quantum`] refuses to make one.
    Quantum(f64),
}

impl Sampler {
    /// An encoder with the given quantum \[m\].
    ///
    /// # Errors
    ///
    /// `quantum` is not finite and positive.
    pub fn quantum(quantum: f64) -> Result<Self, InvalidParameter> {
        positive("quantum", quantum, "finite and above 0 m").map(Self::Quantum)
    }

    /// The measured position \[m\] for a true `position` \[m\].
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
