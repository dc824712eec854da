//! `palpate tune`: error and leak of a method over its damping.

mod world;

use palpate_record::files::outputs::Outputs;
use palpate_scene::Scene;
use palpate_scene::SceneFile;
use palpate_scene::method::{MethodName, SettingKey};
use palpate_study::tune::report::{COLUMNS, TuneReport};
use palpate_study::tune::{self, HEIGHTS, Objective, TuneError};

use super::simulate::{explain, read_any};
use crate::arguments::{CurveArguments, Least, TuneArguments, flag_of_setting};
use crate::failure::Failure;
use crate::progress::Progress;
use crate::results::{draw_study, print_report, write_table};

/// Tries every value of the curve at every start height.
pub fn run(arguments: &TuneArguments) -> Result<(), Failure> {
    let flags = &arguments.flags;
    let objective = match arguments.curve.least {
        Least::Error => Objective::Error,
        Least::Leak => Objective::Leak,
    };
    let file = match read_any(&arguments.scene, &flags.edits)? {
        SceneFile::Contact(file) => *file,
        SceneFile::World(file) => {
            return world::run(arguments, objective, &arguments.scene, &file);
        }
    };
    let methods = flags.methods(file.scene.method);
    let &[method] = methods.as_slice() else {
        return Err(Failure::Arguments(
            "tune varies one method; name it with --method".into(),
        ));
    };
    flags.check_settings(&methods)?;
    let setting = tune::tunable(method).ok_or_else(|| {
        let nothing = TuneError::NothingToTune(method);
        Failure::Arguments(format!("{nothing}; name one with --method"))
    })?;
    if flags.settings().has(setting.key) {
        return Err(Failure::Arguments(format!(
            "{} is the setting that tune varies; give its range with --from and --to",
            flag_of_setting(setting)
        )));
    }
    let mut outputs = arguments.overwriting.outputs();
    outputs.protect(&arguments.scene);
    arguments.plan(&mut outputs)?;
    let mut scene = file.scene.clone();
    flags.change(&mut scene, &methods)?;
    arguments.timing.change(&mut scene)?;
    // Input files include a device file from the flags.
    outputs.spare_inputs()?;
    // The range of the values depends on stiffness and period, so check these first.
    scene
        .renderer(method)
        .map_err(|error| explain((flags, &arguments.timing), &file, method, error.into()))?;
    let values = values(&arguments.curve, &scene, method, setting.key)?;
    let progress = Progress::new(HEIGHTS);
    progress.begin("start heights");
    let points =
        tune::tune(&scene, method, &values, || progress.advance()).map_err(
            |error| match error {
                TuneError::Loop(error) => explain((flags, &arguments.timing), &file, method, error),
                other => Failure::input(other),
            },
        )?;
    drop(progress);

    let mut report = TuneReport::new(&scene, method, setting, objective, points);
    let table = write_table(&outputs, arguments.out.as_ref(), &COLUMNS, report.rows())?;
    report.files.extend(table);
    let figure = draw_study(&outputs, &arguments.picture, || palpate_plot::tune(&report))?;
    report.files.extend(figure);
    print_report(&report, arguments.json)
}

impl TuneArguments {
    /// Plans the requested files.
    fn plan(&self, outputs: &mut Outputs) -> Result<(), Failure> {
        if let Some(out) = &self.out {
            outputs.plan("--out", out)?;
        }
        self.picture.plan(outputs)
    }
}

/// Default number of tried values.
const STEPS: u32 = 400;

/// Returns the values to try `[N s/m]`.
fn values(
    curve: &CurveArguments,
    scene: &Scene,
    method: MethodName,
    setting: SettingKey,
) -> Result<Vec<f64>, Failure> {
    let to = curve
        .to
        .unwrap_or_else(|| tune::usual_most(scene, method, setting));
    let steps = curve.steps.unwrap_or(STEPS);
    let from = curve
        .from
        .unwrap_or_else(|| tune::usual_least(setting, to, steps));
    evenly(from, to, steps)
}

/// Returns `steps` evenly spaced values `[N s/m]`.
fn evenly(from: f64, to: f64, steps: u32) -> Result<Vec<f64>, Failure> {
    if !(from.is_finite() && to.is_finite() && from >= 0.0 && to > from) {
        return Err(Failure::Arguments(format!(
            "--from {from} --to {to}: the values must be finite, not below 0, and increase"
        )));
    }
    let last = f64::from(steps - 1);
    Ok((0..steps)
        .map(|i| from + (to - from) * (f64::from(i) / last))
        .collect())
}
