//! `palpate paper heights`: dependence of errors on the start height.

use palpate_study::heights::report::{COLUMNS, HeightsReport, SceneReport};
use palpate_study::heights::{HeightsError, over_heights};
use palpate_study::table::TableFormat;
use palpate_study::tune::HEIGHTS;

use crate::arguments::{Flags, HeightsArguments, TimingFlags};
use crate::commands::simulate::{explain, read_scene};
use crate::failure::Failure;
use crate::progress::Progress;
use crate::results::print_report;

/// Evaluates every column on every scene.
pub fn run(arguments: &HeightsArguments) -> Result<(), Failure> {
    let factor = arguments.model_mass_factor;
    if !(factor.is_finite() && factor > 0.0) {
        return Err(Failure::Arguments(format!(
            "--model-mass-factor is {factor}, but must be finite and greater than 0"
        )));
    }
    let columns = arguments.compared.columns()?;
    let mut outputs = arguments.overwriting.outputs();
    for scene in &arguments.scenes {
        outputs.protect(scene);
    }
    if let Some(out) = &arguments.out {
        outputs.plan("--out", out)?;
    }
    let files = arguments
        .scenes
        .iter()
        .map(|path| read_scene(path, &arguments.edits))
        .collect::<Result<Vec<_>, _>>()?;
    outputs.spare_inputs()?;
    let progress = Progress::new(HEIGHTS * files.len());
    let mut scenes = Vec::with_capacity(files.len());
    for (path, file) in arguments.scenes.iter().zip(&files) {
        progress.begin(&file.scene.title);
        let mut scene = file.scene.clone();
        if factor != 1.0 {
            scene.model_device_mass = Some(factor * scene.device.mass());
        }
        let found =
            over_heights(&scene, &columns, || progress.advance()).map_err(|error| match error {
                HeightsError::Scene(error) => explain(
                    (&Flags::default(), &TimingFlags::default()),
                    file,
                    scene.method,
                    error,
                ),
                other => Failure::input(format!("{}: {other}", path.display())),
            })?;
        scenes.push(SceneReport::new(&scene, &columns, &found));
    }
    drop(progress);
    let mut report = HeightsReport::new(factor, scenes);
    if let Some(out) = &arguments.out {
        outputs.write(out, |writer| {
            TableFormat::from_path(out).write(writer, &COLUMNS, report.rows())
        })?;
        report.wrote(out);
    }
    print_report(&report, arguments.json)
}
