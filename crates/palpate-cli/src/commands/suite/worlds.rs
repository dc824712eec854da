//! `palpate suite --set worlds` and `worlds-free`: methods on random worlds.

use palpate_study::world::suite::{self, WorldSet};

use crate::arguments::SuiteArguments;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::results::print_report;

/// What the set takes.
const FLAGS: [&str; 4] = ["set", "plants", "seed", "json"];

/// Draws the worlds and judges methods on them.
pub fn run(set: WorldSet, arguments: &SuiteArguments) -> Result<(), Failure> {
    if let Some(flag) = arguments.given.other_than(&FLAGS) {
        return Err(Failure::Arguments(format!(
            "{flag}: with --set {} stand --plants, --seed and --json",
            set.name()
        )));
    }
    let worlds = arguments.plants as usize;
    let progress = Progress::new(suite::steps(set, worlds));
    progress.begin("worlds");
    let report = suite::run(set, worlds, arguments.seed, || progress.advance());
    drop(progress);
    print_report(&report.map_err(Failure::input)?, arguments.json)
}
