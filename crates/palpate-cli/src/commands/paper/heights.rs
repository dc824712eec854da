//! `palpate paper heights`: dependence of errors on the start height.

use std::path::PathBuf;

use palpate_scene::SceneFile;
use palpate_study::heights::over_heights;
use palpate_study::heights::report::{COLUMNS, HeightsReport, SceneReport};
use palpate_study::studied::{Studied, StudyError};
use palpate_study::tune::HEIGHTS;

use crate::arguments::{Flags, HeightsArguments, TimingFlags};
use crate::commands::simulate::{explain, read_any};
use crate::failure::Failure;
use crate::progress::Progress;
use crate::results::{print_report, write_table};
use crate::worlds::{self, failed};

/// Evaluates every column on every scene.
pub fn run(arguments: &HeightsArguments) -> Result<(), Failure> {
    let factor = arguments.model_mass_factor;
    if !(factor.is_finite() && factor > 0.0) {
        return Err(Failure::Arguments(format!(
            "--model-mass-factor is {factor}, but must be finite and greater than 0"
        )));
    }
    let mut outputs = arguments.overwriting.outputs();
    for scene in &arguments.scenes {
        outputs.protect(scene);
    }
    if let Some(out) = &arguments.out {
        outputs.plan("--out", out)?;
    }
    let read = |path: &PathBuf| read_any(path, &arguments.edits);
    let files = (arguments.scenes.iter().map(read)).collect::<Result<Vec<_>, _>>()?;
    outputs.spare_inputs()?;
    let progress = Progress::new(HEIGHTS * files.len());
    let mut scenes = Vec::with_capacity(files.len());
    let compared = &arguments.compared;
    for (path, file) in arguments.scenes.iter().zip(&files) {
        scenes.push(match file {
            SceneFile::Contact(file) => {
                let no_flags = (&Flags::default(), &TimingFlags::default());
                let failure = |error| match error {
                    StudyError::Contact(error) => explain(no_flags, file, file.scene.method, error),
                    other => failed(path)(other),
                };
                of_scene(
                    &file.scene,
                    factor,
                    &compared.columns()?,
                    &progress,
                    failure,
                )?
            }
            SceneFile::World(file) => {
                compared.refuse_columns(path)?;
                let all = || worlds::able(&file.scene);
                let methods = worlds::compared(compared.method.as_ref(), all)?;
                of_scene(&file.scene, factor, &methods, &progress, failed(path))?
            }
        });
    }
    drop(progress);
    let mut report = HeightsReport::new(factor, scenes);
    let table = write_table(&outputs, arguments.out.as_ref(), &COLUMNS, report.rows())?;
    report.files.extend(table);
    print_report(&report, arguments.json)
}

/// Evaluates the columns on a scene, with a `factor` on the model values of the device's mass.
fn of_scene<S: Studied>(
    scene: &S,
    factor: f64,
    columns: &[S::Column],
    progress: &Progress,
    failure: impl Fn(StudyError) -> Failure,
) -> Result<SceneReport, Failure> {
    progress.begin(scene.title());
    let scene = scene.with_model_mass_factor(factor);
    let found = over_heights(&scene, columns, || progress.advance()).map_err(failure)?;
    Ok(SceneReport::new(&scene, columns, &found))
}
