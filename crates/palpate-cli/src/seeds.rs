//! Several seeds of a scene: their range, and methods over them.

use std::ops::Range;

use palpate_study::seeded::{Seeded, over_seeds, scores};
use palpate_study::studied::{Compared, Studied, StudyError};

use crate::arguments::SeedFlags;
use crate::failure::Failure;
use crate::progress::Progress;

impl SeedFlags {
    /// Whether several seeds are requested.
    pub fn are_several(&self) -> bool {
        self.seeds > 1
    }

    /// Explains why the seeds are refused.
    pub fn refused(&self, why: &str) -> Failure {
        Failure::Arguments(format!("--seeds {}: {why}", self.seeds))
    }

    /// Returns the seeds from `first` on.
    pub fn range(&self, first: u64) -> Result<Range<u64>, Failure> {
        if let Some(range) = self.start_range
            && !(range.is_finite() && range > 0.0)
        {
            return Err(Failure::Arguments(format!(
                "--start-range is {range} m, but must be finite and greater than 0"
            )));
        }
        let after = first.checked_add(u64::from(self.seeds));
        let after = after.ok_or_else(|| {
            self.refused(&format!("from seed {first} on, the last is beyond 2^64"))
        })?;
        Ok(first..after)
    }

    /// Returns the seeds of a scene, the first one its own.
    pub fn of_scene(&self, scene: &impl Studied) -> Result<Range<u64>, Failure> {
        if scene.random_seed().is_none() && self.start_range.is_none() {
            return Err(self.refused(
                "nothing is random in this scene (no jitter of samples or commands, drops or sensor noise), so every \
                 seed gives the same numbers; omit the flag, or vary the start with --start-range",
            ));
        }
        self.range(scene.seed())
    }

    /// Returns columns over the seeds of a scene.
    pub fn over<S: Studied>(
        &self,
        scene: &S,
        columns: &[S::Column],
        failure: impl Fn(StudyError) -> Failure,
    ) -> Result<Seeded, Failure> {
        let seeds = self.of_scene(scene)?;
        let first = seeds.start;
        let progress = Progress::new(self.seeds as usize);
        progress.begin("seeds");
        let done = || progress.advance();
        let scores = over_seeds(seeds, done, |seed| {
            scores(&scene.with_seed(seed, self.start_range), columns)
        });
        let names: Vec<_> = columns.iter().map(Compared::name).collect();
        let scores = scores.map_err(failure)?;
        Ok(Seeded::new(first, self.start_range, &names, &scores))
    }
}
