//! `palpate sweep`: one quantity or one key of a scene over several values.

use palpate_record::files::outputs::Outputs;
use palpate_scene::method::MethodName;
use palpate_scene::world::WorldScene;
use palpate_scene::{Edit, Measure, Scene, SceneFile, Source};
use palpate_study::studied::Studied;
use palpate_study::suite::Column;
use palpate_study::sweep::report::SweepReport;
use palpate_study::sweep::{Point, Quantity, sweep_points, table::COLUMNS};
use palpate_study::tune::tunable;

use super::simulate::{read_any, read_text};
use crate::arguments::SweepArguments;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::results::{draw_study, print_report, write_table};
use crate::values::Over;
use crate::worlds::{able, compared, failed};

/// Runs every column at every value.
pub fn run(arguments: &SweepArguments) -> Result<(), Failure> {
    let mut outputs = arguments.overwriting.outputs();
    outputs.protect(&arguments.scene);
    if let Some(out) = &arguments.out {
        outputs.plan("--out", out)?;
    }
    arguments.picture.plan(&mut outputs)?;
    // Reports the notes of the scene once, and names its own errors.
    let report = match read_any(&arguments.scene, &arguments.edits)? {
        SceneFile::Contact(file) => {
            let columns = arguments.columns()?;
            let scene = arguments.windowed(file.scene);
            swept(arguments, &outputs, &scene, &columns, |file| match file {
                SceneFile::Contact(file) => Some(arguments.windowed(file.scene)),
                SceneFile::World(_) => None,
            })?
        }
        SceneFile::World(file) => {
            let methods = arguments.methods_of_world(&file.scene)?;
            swept(
                arguments,
                &outputs,
                &file.scene,
                &methods,
                |file| match file {
                    SceneFile::World(file) => Some(file.scene),
                    SceneFile::Contact(_) => None,
                },
            )?
        }
    };
    deliver(arguments, &outputs, report)
}

/// Runs the columns on the scene at every value. `of` returns the scene of a file if it has the same renderer.
fn swept<S: Studied>(
    arguments: &SweepArguments,
    outputs: &Outputs,
    scene: &S,
    columns: &[S::Column],
    of: impl Fn(SceneFile) -> Option<S>,
) -> Result<SweepReport, Failure> {
    let and_values = match &arguments.and_values {
        Some(values) => values.0.iter().copied().map(Some).collect(),
        None => vec![None],
    };
    let with_second = |value: f64| and_values.iter().map(move |and| (value, *and));
    let values = arguments.values()?.into_iter();
    let values: Vec<(f64, Option<f64>)> = values.flat_map(with_second).collect();
    let source = Source::new(
        &arguments.scene.display().to_string(),
        &read_text(&arguments.scene)?,
    );
    let source = source.edited(&arguments.edits.set);
    let at = |&(value, and_value): &(f64, Option<f64>)| {
        let second = arguments.and.as_ref().zip(and_value);
        let second = second.map(|(over, value)| ("--and", over, value));
        let axes = [("--over", &arguments.over, value)].into_iter();
        let axes: Vec<Axis<'_>> = axes.chain(second).collect();
        let (named, varied) = edited(&axes, &source, scene, &of)?;
        let mut point = Point {
            at: named,
            scene: varied,
            columns: columns.to_vec(),
        };
        for (_, over, value) in axes {
            if let Over::Quantity(quantity) = over {
                let varied = point.with(*quantity, value);
                point = varied.map_err(failed(&arguments.scene))?;
            }
        }
        Ok(point)
    };
    let points: Vec<_> = values.iter().map(at).collect::<Result<_, Failure>>()?;
    outputs.spare_inputs()?;
    let progress = Progress::new(values.len());
    progress.begin(arguments.over.name());
    let swept = sweep_points(&points, arguments.heights, || progress.advance());
    let swept = swept.map_err(failed(&arguments.scene))?;
    let names = (
        arguments.over.name(),
        arguments.and.as_ref().map(Over::name),
    );
    let mut report = SweepReport::of_names(scene, names, &values, columns, &swept);
    if let Over::Quantity(quantity) = arguments.over {
        report.unit = quantity.unit();
    }
    Ok(report)
}

/// Flag, quantity or key, and value.
type Axis<'a> = (&'static str, &'a Over, f64);

/// Returns the values in words, and the scene with those of keys.
fn edited<S: Studied>(
    axes: &[Axis<'_>],
    source: &Source,
    scene: &S,
    of: impl Fn(SceneFile) -> Option<S>,
) -> Result<(String, S), Failure> {
    let named = axes
        .iter()
        .map(|(_, over, value)| format!("{} {value}", over.name()));
    let named = named.collect::<Vec<_>>().join(", ");
    let edit = |(flag, over, value): &Axis<'_>| match over {
        Over::Quantity(_) => None,
        Over::Key(key) => Some(
            Edit::number(&format!("{flag} {key}, value {value}"), key, *value)
                .map_err(|error| Failure::Arguments(format!("{flag} {key}: {error}"))),
        ),
    };
    let edits: Vec<Edit> = axes.iter().filter_map(edit).collect::<Result<_, _>>()?;
    if edits.is_empty() {
        return Ok((named, scene.clone()));
    }
    let file = SceneFile::parse_edited(&source.clone().edited(&edits));
    match of(file.map_err(Failure::inputs)?) {
        Some(scene) => Ok((named, scene)),
        None => Err(another_renderer(&named)),
    }
}

fn another_renderer(at: &str) -> Failure {
    Failure::Arguments(format!(
        "--over, at {at}: this value changes whether the scene is one contact along one axis or a world, so its results \
         cannot be compared with the others"
    ))
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

    /// Whether a damping is varied, so that only methods with one are compared.
    fn varies_damping(&self) -> bool {
        let varied = [Some(&self.over), self.and.as_ref()];
        varied.contains(&Some(&Over::Quantity(Quantity::Damping)))
    }

    /// Returns the columns of one contact.
    fn columns(&self) -> Result<Vec<Column>, Failure> {
        let has_setting =
            |method: &MethodName| !self.varies_damping() || tunable(*method).is_some();
        let all = MethodName::ALL.into_iter().filter(has_setting);
        self.compared.columns_or(|| all.map(Column::new).collect())
    }

    /// Returns the methods of a world: the named ones, or all that its file has settings for.
    fn methods_of_world(&self, scene: &WorldScene) -> Result<Vec<&'static str>, Failure> {
        if self.collisions.is_some() {
            return Err(Failure::Arguments(format!(
                "--collisions: {} is a world, whose window is set before its ideal is solved; use --set \
                 measure.duration_s",
                self.scene.display()
            )));
        }
        self.compared.refuse_columns(&self.scene)?;
        compared(self.compared.method.as_ref(), || {
            let mut all = able(scene);
            if self.varies_damping() {
                let mut damped = WorldScene::METHODS.to_vec();
                damped.retain(|name| match scene.at(&[name], Quantity::Damping, 1.0) {
                    Ok((scene, _)) => scene.method(name).is_ok(),
                    Err(_) => false,
                });
                all = damped;
            }
            all
        })
    }
}

/// Writes the requested files, then prints the report.
fn deliver(
    arguments: &SweepArguments,
    outputs: &Outputs,
    mut report: SweepReport,
) -> Result<(), Failure> {
    let table = write_table(outputs, arguments.out.as_ref(), &COLUMNS, report.rows())?;
    report.files.extend(table);
    let figure = draw_study(outputs, &arguments.picture, || palpate_plot::sweep(&report))?;
    report.files.extend(figure);
    print_report(&report, arguments.json)
}
