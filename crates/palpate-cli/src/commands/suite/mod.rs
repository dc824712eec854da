//! `palpate suite`: methods on plants drawn at random.

mod worlds;

use std::path::{Path, PathBuf};

use palpate_files::outputs::Outputs;
use palpate_scene::method::MethodName;
use palpate_study::suite::report::SuiteReport;
use palpate_study::suite::{self, Column, Judged, Set, table};

use crate::arguments::{Compared, SuiteArguments};
use crate::failure::Failure;
use crate::plots;
use crate::progress::Progress;
use crate::results::{draw, print_report};
use crate::values::PlantSet;
use palpate_figure::{Figure, Kind, Limits, Panel, Role, Row, Series};

/// Draws the plants, judges every column on them, and writes what was asked for.
pub fn run(arguments: &SuiteArguments) -> Result<(), Failure> {
    let plants = arguments.plants as usize;
    let set = match arguments.set {
        PlantSet::Contact(set) => set,
        PlantSet::Worlds => return worlds::run(arguments),
    };
    let outputs = outputs(arguments, plants)?;
    let columns = arguments.compared.columns_or(|| set.columns())?;
    let progress = Progress::new(plants);
    progress.begin("plants");
    let judged = suite::run(set, arguments.seed, plants, &columns, || progress.advance())
        .map_err(Failure::input)?;
    drop(progress);

    let mut report = SuiteReport::new(set, arguments.seed, &columns, &judged);
    if let Some(folder) = &arguments.write_scenes {
        report.wrote(&write_scenes(&outputs, folder, &judged)?);
    }
    if let Some(path) = &arguments.out {
        outputs.write(path, |writer| {
            table::write(writer, set, arguments.seed, &columns, &judged)
                .map_err(std::io::Error::from)
        })?;
        report.wrote(path);
    }
    if let Some(path) = &arguments.picture.plot {
        let drawn = arguments.compared.drawn(&columns);
        let figure = figure(set, arguments.seed, &columns, &drawn, &judged);
        draw(&outputs, path, &figure, arguments.picture.size)?;
        report.wrote(path);
    }
    print_report(&report, arguments.json)
}

impl Compared {
    /// What is compared: methods with their defaults, or the columns of a file; every method where none is
    /// named.
    pub fn columns(&self) -> Result<Vec<Column>, Failure> {
        self.columns_or(|| MethodName::ALL.map(Column::of).to_vec())
    }

    /// The same, with `otherwise` where nothing is named.
    pub fn columns_or(
        &self,
        otherwise: impl FnOnce() -> Vec<Column>,
    ) -> Result<Vec<Column>, Failure> {
        let Some(path) = &self.columns else {
            let Some(methods) = &self.method else {
                return Ok(otherwise());
            };
            return Ok(methods.0.iter().copied().map(Column::of).collect());
        };
        let name = path.display();
        let text = std::fs::read_to_string(path)
            .map_err(|error| Failure::System(format!("{name}: {error}")))?;
        Column::parse(&text).map_err(|error| Failure::input(format!("{name}: {error}")))
    }
}

impl Compared {
    /// Which of the columns a figure shows: those that are named, or the ones that figures show of many.
    fn drawn(&self, columns: &[Column]) -> Vec<usize> {
        let is_named = self.method.is_some() || self.columns.is_some();
        let is_shown = |column: &Column| is_named || plots::SHOWN.contains(&column.method);
        (0..columns.len())
            .filter(|number| is_shown(&columns[*number]))
            .collect()
    }
}

/// The files that are asked for, with the folder of the scenes made.
fn outputs(arguments: &SuiteArguments, plants: usize) -> Result<Outputs, Failure> {
    let mut outputs = arguments.overwriting.outputs();
    if let Some(columns) = &arguments.compared.columns {
        outputs.protect(columns);
    }
    if let Some(path) = &arguments.out {
        outputs.plan("--out", path)?;
    }
    arguments.picture.plan(&mut outputs)?;
    if let Some(folder) = &arguments.write_scenes {
        std::fs::create_dir_all(folder)
            .map_err(|error| Failure::System(format!("{}: {error}", folder.display())))?;
        for index in 0..plants {
            outputs.plan("--write-scenes", &scene_file(folder, index))?;
        }
    }
    Ok(outputs)
}

fn scene_file(folder: &Path, index: usize) -> PathBuf {
    folder.join(format!("plant-{index:04}.toml"))
}

/// Writes each plant into a file of its own in `folder`; their common name.
fn write_scenes(outputs: &Outputs, folder: &Path, judged: &[Judged]) -> Result<PathBuf, Failure> {
    for one in judged {
        let path = scene_file(folder, one.plant.index);
        let text = one.plant.scene.to_toml().map_err(Failure::input)?;
        outputs.write(&path, |writer| writer.write_all(text.as_bytes()))?;
    }
    Ok(folder.join("plant-*.toml"))
}

/// How each column looks: a method with its defaults as everywhere else.
fn role(columns: &[Column], number: usize) -> Role {
    let of_methods = columns
        .iter()
        .all(|column| *column == Column::of(column.method));
    if of_methods {
        plots::role(columns[number].method)
    } else {
        Role::Compared(number)
    }
}

/// Logarithm of the largest error E that is drawn: the force is then lost in any case.
const LARGEST_DRAWN: f64 = 3.0;

/// The distribution of E of every column, a panel for each condition.
fn figure(set: Set, seed: u64, columns: &[Column], drawn: &[usize], judged: &[Judged]) -> Figure {
    let conditions = set.conditions();
    let of_set = match set {
        Set::Paper => String::new(),
        other => format!(" of the set {other}"),
    };
    let panel = |condition: usize| Panel {
        series: (drawn.iter().copied())
            .map(|number| {
                let mut errors: Vec<f64> = judged
                    .iter()
                    .flat_map(|one| &one.trials)
                    .filter(|trial| trial.column == number && trial.condition == condition)
                    .map(|trial| trial.fidelity.mean_force_error.log10())
                    .collect();
                errors.sort_by(f64::total_cmp);
                let all = errors.len() as f64;
                // From nothing at the least error to all at the largest, or at the edge.
                let within = errors.partition_point(|error| *error <= LARGEST_DRAWN);
                let shares = (0..=within).map(|below| 100.0 * below as f64 / all);
                Series {
                    name: columns[number].name.clone(),
                    kind: Kind::Step,
                    role: role(columns, number),
                    y: shares.collect(),
                    x: errors[..within]
                        .first()
                        .into_iter()
                        .chain(&errors[..within])
                        .copied()
                        .collect(),
                }
            })
            .collect(),
    };
    Figure {
        title: finding(set, columns, drawn, judged),
        subtitle: format!("{} random plants{of_set}, seed {seed}", judged.len()),
        footnote: Some(
            "Share of the plants on which E, the error of the mean force of each period, is at most so large: \
             the further left, the better. Errors above 1000 % are not drawn."
                .into(),
        ),
        x_label: "mean-force error E [%]".into(),
        x_decades: true,
        columns: conditions.iter().map(ToString::to_string).collect(),
        rows: vec![Row {
            y_label: "plants [%]".into(),
            y_decades: false,
            limits: Limits::Data,
            panels: (0..conditions.len()).map(panel).collect(),
        }],
    }
}

/// On how many of the plants each column's force is within E < 20 %, for the two best: without a delay in
/// the paper's set, under the last condition of the others.
fn finding(set: Set, columns: &[Column], drawn: &[usize], judged: &[Judged]) -> String {
    const FAITHFUL_PERCENT: f64 = 20.0;
    let conditions = set.conditions();
    let condition = match set {
        Set::Paper => 0,
        Set::Desk | Set::Real | Set::Steps => conditions.len() - 1,
    };
    let mut shares: Vec<(&str, f64)> = (drawn.iter().copied())
        .map(|number| {
            let of_column = judged.iter().flat_map(|one| &one.trials);
            let faithful = of_column
                .filter(|trial| trial.column == number && trial.condition == condition)
                .filter(|trial| trial.fidelity.mean_force_error < FAITHFUL_PERCENT)
                .count();
            (
                &*columns[number].name,
                100.0 * faithful as f64 / judged.len() as f64,
            )
        })
        .collect();
    shares.sort_by(|a, b| b.1.total_cmp(&a.1));
    let best: Vec<String> = (shares.iter().take(2))
        .map(|(name, share)| format!("{name} on {share:.0} %"))
        .collect();
    format!(
        "E below {FAITHFUL_PERCENT} % with {}: {} of the plants",
        conditions[condition],
        best.join(", ")
    )
}
