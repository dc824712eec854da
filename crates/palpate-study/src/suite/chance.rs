//! Random numbers that are the same on every platform and in every version.

use chacha20::ChaCha8Rng;
use chacha20::rand_core::{Rng, SeedableRng};

/// Random numbers of one plant: ChaCha with 8 rounds, the seed as its key and the plant's number as its stream. A
/// plant thus does not depend on the plants before it.
pub(crate) struct Chance(ChaCha8Rng);

impl Chance {
    pub fn new(seed: u64, plant: u64) -> Self {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        let mut generator = ChaCha8Rng::from_seed(key);
        generator.set_stream(plant);
        Self(generator)
    }

    /// Returns a uniform value in [0, 1), in steps of 2^-53.
    fn share(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * 0.5_f64.powi(53)
    }

    /// Returns a uniform index below `count`, which is above 0.
    pub fn below(&mut self, count: usize) -> usize {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "an index"
        )]
        let index = (self.share() * count as f64) as usize;
        index.min(count - 1)
    }

    /// Returns a uniform value between two values.
    pub fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.share()
    }

    /// Returns a log-uniform value between two positive values.
    pub fn log_between(&mut self, from: f64, to: f64) -> f64 {
        // `libm` makes the plants independent of the platform.
        from * libm::exp(self.share() * libm::log(to / from))
    }

    /// Returns true with this probability.
    pub fn happens(&mut self, share: f64) -> bool {
        self.share() < share
    }

    /// Returns an integer for use as another seed, small enough for every format.
    pub fn number(&mut self) -> u64 {
        self.0.next_u64() >> 33
    }

    /// Returns one of three values with equal probability.
    pub fn one_of(&mut self, values: [f64; 3]) -> f64 {
        let share = self.share();
        let number = usize::from(share >= 1.0 / 3.0) + usize::from(share >= 2.0 / 3.0);
        values[number]
    }
}
