//! `palpate sweep`: one quantity or one key of a scene over several values.

use std::path::Path;

use palpate_record::files::outputs::Outputs;
use palpate_scene::method::MethodName;
use palpate_scene::world::{WorldFile, WorldScene};
use palpate_scene::{Edit, Measure, Scene, SceneFile, Source};
use palpate_study::suite::Column;
use palpate_study::sweep::report::SweepReport;
use palpate_study::sweep::{
    Quantity, SweepError, WorldSweepError, sweep, sweep_scenes, sweep_worlds, table::COLUMNS,
};
use palpate_study::table::TableFormat;
use palpate_study::tune::tunable;

use super::simulate::{read_any, read_scene, read_text};
use crate::arguments::SweepArguments;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::results::{draw, print_report};

/// Runs every column at every value.
pub fn run(arguments: &SweepArguments) -> Result<(), Failure> {
    let values = arguments.values()?;
    let mut outputs = arguments.overwriting.outputs();
    outputs.protect(&arguments.scene);
    if let Some(out) = &arguments.out {
        outputs.plan("--out", out)?;
    }
    arguments.picture.plan(&mut outputs)?;
    let report = match (arguments.over, &arguments.key) {
        (Some(quantity), _) => over(arguments, quantity, &values, &outputs)?,
        (None, Some(key)) => over_key(arguments, key, &values, &outputs)?,
        (None, None) => unreachable!("clap requires one of them"),
    };
    deliver(arguments, &outputs, report)
}

fn over(
    arguments: &SweepArguments,
    quantity: Quantity,
    values: &[f64],
    outputs: &Outputs,
) -> Result<SweepReport, Failure> {
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
    let scene = read_scene(&arguments.scene, &arguments.edits)?.scene;
    let scene = arguments.windowed(scene);
    outputs.spare_inputs()?;
    let progress = Progress::new(values.len());
    progress.begin(quantity.name());
    let done = || progress.advance();
    let swept = sweep(&scene, quantity, values, &columns, arguments.heights, done)
        .map_err(|error| failed(arguments, &error))?;
    Ok(SweepReport::new(&scene, quantity, values, &columns, &swept))
}

fn over_key(
    arguments: &SweepArguments,
    key: &str,
    values: &[f64],
    outputs: &Outputs,
) -> Result<SweepReport, Failure> {
    // Reports the notes of the scene once, and names its own errors.
    let file = read_any(&arguments.scene, &arguments.edits)?;
    let varied = varied(arguments, key, values)?;
    outputs.spare_inputs()?;
    let progress = Progress::new(values.len());
    progress.begin(key);
    let done = || progress.advance();
    match file {
        SceneFile::Contact(file) => {
            let columns = arguments.compared.columns()?;
            let scenes = varied.into_iter().map(|(value, file)| match file {
                SceneFile::Contact(file) => Ok((value, arguments.windowed(file.scene))),
                SceneFile::World(_) => Err(another_renderer(key, value)),
            });
            let scenes: Vec<(f64, Scene)> = scenes.collect::<Result<_, _>>()?;
            let swept = sweep_scenes(key, &scenes, &columns, arguments.heights, done)
                .map_err(|error| failed(arguments, &error))?;
            let swept = values.iter().copied().zip(&swept);
            Ok(SweepReport::of_key(&file.scene, key, swept, &columns))
        }
        SceneFile::World(file) => {
            let methods = arguments.methods_of_world(&file)?;
            let worlds = varied.into_iter().map(|(value, file)| match file {
                SceneFile::World(file) => Ok((value, file.scene)),
                SceneFile::Contact(_) => Err(another_renderer(key, value)),
            });
            let worlds: Vec<(f64, WorldScene)> = worlds.collect::<Result<_, _>>()?;
            let swept = sweep_worlds(key, &worlds, &methods, done);
            let swept = swept.map_err(|error| failed_world(&arguments.scene, &error))?;
            let swept = values.iter().copied().zip(&swept);
            Ok(SweepReport::of_worlds(
                &file.scene.title,
                key,
                swept,
                &methods,
            ))
        }
    }
}

/// Reads the scene with each value of the key.
fn varied(
    arguments: &SweepArguments,
    key: &str,
    values: &[f64],
) -> Result<Vec<(f64, SceneFile)>, Failure> {
    let name = arguments.scene.display().to_string();
    let source = Source::new(&name, &read_text(&arguments.scene)?).edited(&arguments.edits.set);
    let at = |&value: &f64| {
        let edit = Edit::number(&format!("--key {key}, value {value}"), key, value);
        let edit = edit.map_err(|error| Failure::Arguments(format!("--key {key}: {error}")))?;
        let source = source.clone().edited(&[edit]);
        let file = SceneFile::parse_edited(&source).map_err(Failure::inputs)?;
        Ok((value, file))
    };
    values.iter().map(at).collect()
}

fn another_renderer(key: &str, value: f64) -> Failure {
    Failure::Arguments(format!(
        "--key {key}, value {value}: this value changes whether the scene is one contact along one axis or a world, \
         so its results cannot be compared with the others"
    ))
}

fn failed(arguments: &SweepArguments, error: &SweepError) -> Failure {
    Failure::input(format!("{}: {error}", arguments.scene.display()))
}

fn failed_world(path: &Path, error: &WorldSweepError) -> Failure {
    Failure::input(format!("{}: {error}", path.display()))
}

impl SweepArguments {
    /// Returns the scene with the window of `--collisions`.
    fn windowed(&self, mut scene: Scene) -> Scene {
        if let Some(collisions) = self.collisions {
            scene.measure = Measure::Collisions(collisions);
        }
        scene
    }

    /// Returns the values to try.
    fn values(&self) -> Result<Vec<f64>, Failure> {
        let (Some(from), Some(to), Some(steps)) = (self.from, self.to, self.steps) else {
            let values = self.values.as_ref();
            return Ok(values.map_or_else(Vec::new, |values| values.0.clone()));
        };
        let is_range = from.is_finite() && to.is_finite() && from != to;
        if !is_range || (self.log && !(from > 0.0 && to > 0.0)) {
            return Err(Failure::Arguments(format!(
                "--from {from} --to {to}: the two values must be finite and differ{}",
                if self.log {
                    ", and with --log be above 0"
                } else {
                    ""
                }
            )));
        }
        let last = steps - 1;
        let at = |step: u32| match step {
            0 => from,
            _ if step == last => to,
            _ => {
                let share = f64::from(step) / f64::from(last);
                if self.log {
                    from * (to / from).powf(share)
                } else {
                    from + (to - from) * share
                }
            }
        };
        Ok((0..steps).map(at).collect())
    }

    /// Returns the methods of a sweep over a world: the named ones, or all that its file has settings for.
    fn methods_of_world(&self, file: &WorldFile) -> Result<Vec<&'static str>, Failure> {
        for (flag, is_given) in [
            ("--columns", self.compared.columns.is_some()),
            ("--heights", self.heights),
            ("--collisions", self.collisions.is_some()),
        ] {
            if is_given {
                return Err(Failure::Arguments(format!(
                    "{flag}: {} is a world; the flag is for one contact along one axis",
                    self.scene.display()
                )));
            }
        }
        match &self.compared.method {
            Some(methods) if !methods.are_all => Ok(methods.names.clone()),
            _ => {
                let all = WorldScene::METHODS.into_iter();
                Ok(all.filter(|name| file.scene.method(name).is_ok()).collect())
            }
        }
    }
}

/// Writes the requested files, then prints the report.
fn deliver(
    arguments: &SweepArguments,
    outputs: &Outputs,
    mut report: SweepReport,
) -> Result<(), Failure> {
    if let Some(out) = &arguments.out {
        outputs.write(out, |writer| {
            TableFormat::from_path(out).write(writer, &COLUMNS, report.rows())
        })?;
        report.wrote(out);
    }
    if let Some(path) = &arguments.picture.plot {
        let figure = palpate_plot::sweep(&report);
        draw(outputs, path, &figure, &arguments.picture.look)?;
        report.wrote(path);
    }
    print_report(&report, arguments.json)
}
