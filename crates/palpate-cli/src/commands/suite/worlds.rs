//! `palpate suite --set worlds` and `worlds-free`: methods on random worlds.

use palpate_study::world::suite::{self, WorldSet};

use crate::arguments::SuiteArguments;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::results::print_report;

/// Flags of the set.
const FLAGS: [&str; 5] = ["set", "plants", "seed", "seeds", "json"];

/// Draws the worlds and evaluates methods on them.
pub fn run(set: WorldSet, arguments: &SuiteArguments) -> Result<(), Failure> {
    if let Some(flag) = arguments.given.other_than(&FLAGS) {
        return Err(Failure::Arguments(format!(
            "{flag}: with --set {}, the allowed flags are --plants, --seed, --seeds and --json",
            set.name()
        )));
    }
    let worlds = arguments.plants as usize;
    let seeds = arguments.seed_range()?;
    let progress = Progress::new(suite::steps(set, worlds) * arguments.seeds as usize);
    progress.begin("worlds");
    let report = suite::run(set, worlds, seeds, || progress.advance());
    drop(progress);
    print_report(&report.map_err(Failure::input)?, arguments.json)
}
