//! `palpate tune` with a world: the damping of a method, and its coupling if it has one.

use std::path::Path;

use palpate_scene::world::WorldFile;
use palpate_study::sim::world::{WorldBench, WorldBenchError};
use palpate_study::tune::Objective;
use palpate_study::world::candidates::{Scale, Tunable};
use palpate_study::world::tune::{COLUMNS, Tuned, WorldTuneReport, tune};

use super::evenly;
use crate::arguments::TuneArguments;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::results::{draw_study, print_report, write_table};
use crate::worlds::{self, wrong_world};

/// Flags of tuning on a world.
const FLAGS: [&str; 13] = [
    "scene",
    "method",
    "from",
    "to",
    "steps",
    "least",
    "out",
    "plot",
    "size",
    "title",
    "caption",
    "overwrite",
    "json",
];

/// Tries every setting on the world.
pub fn run(
    arguments: &TuneArguments,
    objective: Objective,
    path: &Path,
    file: &WorldFile,
) -> Result<(), Failure> {
    worlds::only(&arguments.given, &FLAGS, path)?;
    let scene = &file.scene;
    let method = worlds::one_method(&arguments.flags, scene)?;
    let tunable = Tunable::named(method).ok_or_else(|| {
        Failure::Arguments(format!(
            "{method} has no setting to tune on a world; methods with one: {}; name one with --method",
            Tunable::ALL.map(Tunable::name).join(", ")
        ))
    })?;
    let mut outputs = arguments.overwriting.outputs();
    outputs.protect(&arguments.scene);
    arguments.plan(&mut outputs)?;
    let scale = Scale::new(scene);
    let curve = &arguments.curve;
    let is_given = curve.from.is_some() || curve.to.is_some();
    let settings = if is_given {
        let to = curve.to.unwrap_or(4.0 * scale.stiffness * scale.period);
        let steps = curve.steps.unwrap_or(25);
        let dampings = evenly(curve.from.unwrap_or(0.0), to, steps)?;
        tunable.with_dampings(scale, |_| dampings.clone())
    } else if curve.steps.is_some() {
        return Err(Failure::Arguments(
            "--steps: on a world it requires --from or --to, the range of the damping".into(),
        ));
    } else {
        tunable.candidates(scale)
    };
    let failure = |error: WorldBenchError| match error {
        WorldBenchError::Rendering(faults) => wrong_world(&arguments.flags, file, &faults),
        other => Failure::input(format!("{}: {other}", path.display())),
    };
    let progress = Progress::new(settings.len());
    progress.begin("ideal");
    let bench = WorldBench::new(scene).map_err(failure)?;
    progress.begin(method);
    let mut tuned =
        tune(scene, &bench, tunable, &settings, || progress.advance()).map_err(failure)?;
    drop(progress);
    let softer = tunable.softer(scale);
    if !is_given && !softer.is_empty() && !tuned.iter().any(Tuned::is_usable) {
        let progress = Progress::new(softer.len());
        progress.begin("softer couplings");
        let further = tune(scene, &bench, tunable, &softer, || progress.advance());
        tuned.extend(further.map_err(failure)?);
    }
    if tuned.iter().all(|one| one.error().is_none()) {
        return Err(Failure::input(format!(
            "{}: the ideal has no contact with a tool in the window, so there is no error to minimise",
            path.display()
        )));
    }
    let report = WorldTuneReport::new(scene, &bench, tunable, objective, &tuned);
    let mut report = report.expect("at least one setting was tried");
    let table = write_table(&outputs, arguments.out.as_ref(), &COLUMNS, report.rows())?;
    report.files.extend(table);
    let figure = draw_study(&outputs, &arguments.picture, || {
        palpate_plot::tune_world(&report)
    })?;
    report.files.extend(figure);
    print_report(&report, arguments.json)
}
