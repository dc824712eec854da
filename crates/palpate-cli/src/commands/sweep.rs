//! `palpate sweep`: one quantity of a scene over several values.

use palpate_scene::Measure;
use palpate_scene::method::MethodName;
use palpate_study::suite::Column;
use palpate_study::sweep::report::SweepReport;
use palpate_study::sweep::{Quantity, sweep};
use palpate_study::tune::tunable;

use super::simulate::read_scene;
use crate::arguments::SweepArguments;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::results::print_report;

/// Runs every column at every value.
pub fn run(arguments: &SweepArguments) -> Result<(), Failure> {
    let quantity = arguments.over;
    let compared = &arguments.compared;
    let columns = match (&compared.method, &compared.columns, quantity) {
        // Without a name, all methods with the varied quantity.
        (None, None, Quantity::Damping) => MethodName::ALL
            .into_iter()
            .filter(|method| tunable(*method).is_some())
            .map(Column::new)
            .collect(),
        _ => compared.columns()?,
    };
    let mut scene = read_scene(&arguments.scene)?.scene;
    if let Some(collisions) = arguments.collisions {
        scene.measure = Measure::Collisions(collisions);
    }
    let values = &arguments.values.0;
    let progress = Progress::new(values.len());
    progress.begin(quantity.name());
    let done = || progress.advance();
    let swept = sweep(&scene, quantity, values, &columns, arguments.heights, done)
        .map_err(|error| Failure::input(format!("{}: {error}", arguments.scene.display())))?;
    drop(progress);
    let report = SweepReport::new(&scene, quantity, values, &columns, &swept);
    print_report(&report, arguments.json)
}
