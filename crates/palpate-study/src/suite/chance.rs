//! Random numbers that are the same everywhere and for ever.

use chacha20::ChaCha8Rng;
use chacha20::rand_core::{Rng, SeedableRng};

/// Numbers of one plant: ChaCha with 8 rounds, the seed as its key and the plant's number as its
/// stream, so that a plant does not depend on those before it.
pub(super) struct Chance(ChaCha8Rng);

impl Chance {
    pub fn new(seed: u64, plant: u64) -> Self {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        let mut generator = ChaCha8Rng::from_seed(key);
        generator.set_stream(plant);
        Self(generator)
    }

    /// Evenly from 0 up to, but without, 1, in steps of 2^-53.
    fn share(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * 0.5_f64.powi(53)
    }

    /// Evenly between two values.
    pub fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.share()
    }

    /// Between two positive values, every ratio as likely as the next.
    pub fn log_between(&mut self, from: f64, to: f64) -> f64 {
        // libm, or the plants would depend on the platform.
        from * libm::exp(self.share() * libm::log(to / from))
    }

    /// True in this share of the cases.
    pub fn happens(&mut self, share: f64) -> bool {
        self.share() < share
    }

    /// A whole number that serves as a seed of its own, small enough for every format.
    pub fn number(&mut self) -> u64 {
        self.0.next_u64() >> 33
    }

    /// One of three, each as likely as the others.
    pub fn one_of(&mut self, values: [f64; 3]) -> f64 {
        let share = self.share();
        let number = usize::from(share >= 1.0 / 3.0) + usize::from(share >= 2.0 / 3.0);
        values[number]
    }
}
