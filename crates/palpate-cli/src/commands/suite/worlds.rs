//! `palpate suite --set worlds`: methods on random worlds.

use palpate_study::world::suite;

use crate::arguments::SuiteArguments;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::results::print_report;

/// What the set takes.
const FLAGS: [&str; 4] = ["set", "plants", "seed", "json"];

/// Draws the worlds and judges methods on them.
pub fn run(arguments: &SuiteArguments) -> Result<(), Failure> {
    if let Some(flag) = arguments.given.other_than(&FLAGS) {
        return Err(Failure::Arguments(format!(
            "{flag}: with --set worlds stand --plants, --seed and --json"
        )));
    }
    let worlds = arguments.plants as usize;
    let progress = Progress::new(suite::steps(worlds));
    progress.begin("worlds");
    let report = suite::run(worlds, arguments.seed, || progress.advance());
    drop(progress);
    print_report(&report.map_err(Failure::input)?, arguments.json)
}
