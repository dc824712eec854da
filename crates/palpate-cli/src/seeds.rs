//! Several seeds of a scene: their range, and methods over them.

use std::ops::Range;

use palpate_scene::Scene;
use palpate_scene::method::MethodName;
use palpate_scene::world::WorldScene;
use palpate_study::seeded::{
    Seeded, over_seeds, scores, scores_of_world, with_seed, world_with_seed,
};
use palpate_study::sim::closed_loop::LoopError;
use palpate_study::sim::world::WorldBenchError;

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
    pub fn of_scene(&self, scene: &Scene) -> Result<Range<u64>, Failure> {
        self.of_random(scene.random_seed(), scene.timing.seed)
    }

    /// Returns the seeds from `random` on, the seed of a random loop; without it from `seed` on, if the start varies.
    fn of_random(&self, random: Option<u64>, seed: u64) -> Result<Range<u64>, Failure> {
        let first = match (random, self.start_range) {
            (Some(first), _) => first,
            (None, Some(_)) => seed,
            (None, None) => {
                return Err(self.refused(
                    "nothing is random in this scene (no jitter of samples or commands, drops or sensor noise), so every \
                     seed gives the same numbers; omit the flag, or vary the start with --start-range",
                ));
            }
        };
        self.range(first)
    }

    /// Returns methods over the seeds of a scene.
    pub fn contact(
        &self,
        scene: &Scene,
        methods: &[MethodName],
        failure: impl Fn(LoopError) -> Failure,
    ) -> Result<Seeded, Failure> {
        let seeds = self.of_scene(scene)?;
        let first = seeds.start;
        let progress = Progress::new(self.seeds as usize);
        progress.begin("seeds");
        let done = || progress.advance();
        let scores = over_seeds(seeds, done, |seed| {
            scores(&with_seed(scene, seed, self.start_range), methods)
        });
        let names: Vec<_> = methods.iter().map(|method| method.name()).collect();
        let scores = scores.map_err(failure)?;
        Ok(Seeded::new(first, self.start_range, &names, &scores))
    }

    /// Returns methods over the seeds of a world.
    pub fn world(
        &self,
        world: &WorldScene,
        methods: &[&str],
        failure: impl Fn(WorldBenchError) -> Failure,
    ) -> Result<Seeded, Failure> {
        let seeds = self.of_random(world.random_seed(), world.timing.imperfections.seed)?;
        let first = seeds.start;
        let progress = Progress::new(self.seeds as usize);
        progress.begin("seeds");
        let done = || progress.advance();
        let scores = over_seeds(seeds, done, |seed| {
            scores_of_world(&world_with_seed(world, seed, self.start_range), methods)
        });
        let scores = scores.map_err(failure)?;
        Ok(Seeded::new(first, self.start_range, methods, &scores))
    }
}
