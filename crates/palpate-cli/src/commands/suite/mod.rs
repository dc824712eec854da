//! `palpate suite`: methods on random plants.

mod worlds;

use std::ops::Range;
use std::path::{Path, PathBuf};

use palpate_record::files::bounded::SCENE;
use palpate_record::files::outputs::Outputs;
use palpate_scene::method::MethodName;
use palpate_study::suite::report::SuiteReport;
use palpate_study::suite::{self, Column, Evaluated, table};

use crate::arguments::{Compared, SuiteArguments};
use crate::failure::Failure;
use crate::progress::Progress;
use crate::results::{draw, print_report};
use crate::setup::only_for_worlds;
use crate::values::PlantSet;

/// Draws the plants, evaluates every column on them, and writes the requested files.
pub fn run(arguments: &SuiteArguments) -> Result<(), Failure> {
    let plants = arguments.plants as usize;
    let set = match arguments.set {
        PlantSet::Contact(set) => set,
        PlantSet::Worlds(set) => return worlds::run(set, arguments),
    };
    let seeds = arguments.seed_range()?;
    let outputs = outputs(arguments, plants)?;
    let columns = arguments.compared.columns_or(|| set.columns())?;
    let progress = Progress::new(plants * arguments.seeds as usize);
    progress.begin("plants");
    let mut evaluated = Vec::new();
    let mut scores = Vec::new();
    for seed in seeds.clone() {
        let of_seed = suite::run(set, seed, plants, &columns, || progress.advance());
        let of_seed = of_seed.map_err(Failure::input)?;
        scores.push(suite::scores(&of_seed));
        // Only the files of rows and scenes need more than the scores.
        if arguments.out.is_some() || arguments.write_scenes.is_some() {
            evaluated.extend(of_seed);
        }
    }
    drop(progress);

    let mut report = SuiteReport::of_seeds(set, arguments.seed, &columns, &scores);
    if let Some(folder) = &arguments.write_scenes {
        report.wrote(&write_scenes(&outputs, folder, &evaluated)?);
    }
    if let Some(path) = &arguments.out {
        outputs.write(path, |writer| {
            table::write(writer, set, &seeds, &columns, &evaluated).map_err(std::io::Error::from)
        })?;
        report.wrote(path);
    }
    if let Some(path) = &arguments.picture.plot {
        let drawn = arguments.compared.drawn(&columns);
        let figure = palpate_plot::suite(set, &seeds, &columns, &drawn, &scores.concat());
        draw(&outputs, path, &figure, &arguments.picture.look)?;
        report.wrote(path);
    }
    print_report(&report, arguments.json)
}

impl SuiteArguments {
    /// Returns the seeds of the draws.
    pub fn seed_range(&self) -> Result<Range<u64>, Failure> {
        let after = self.seed.checked_add(u64::from(self.seeds));
        let after = after.ok_or_else(|| {
            Failure::Arguments(format!(
                "--seeds {} from --seed {} on: the last is beyond 2^64",
                self.seeds, self.seed
            ))
        })?;
        if self.seeds > 1 && self.write_scenes.is_some() {
            return Err(Failure::Arguments(
                "--write-scenes: the files are named after the plants of one seed; omit --seeds"
                    .into(),
            ));
        }
        Ok(self.seed..after)
    }
}

impl Compared {
    /// Returns the compared columns: methods with their defaults, or the columns of a file. Without a name, every
    /// method.
    pub fn columns(&self) -> Result<Vec<Column>, Failure> {
        self.columns_or(|| MethodName::ALL.map(Column::new).to_vec())
    }

    /// Returns the compared columns, or `otherwise` without a name.
    pub fn columns_or(
        &self,
        otherwise: impl FnOnce() -> Vec<Column>,
    ) -> Result<Vec<Column>, Failure> {
        let Some(path) = &self.columns else {
            let Some(methods) = &self.method else {
                return Ok(otherwise());
            };
            if let Some(name) = methods.of_worlds_only() {
                return Err(only_for_worlds(name));
            }
            return Ok(methods.of_contact().into_iter().map(Column::new).collect());
        };
        let name = path.display();
        let text = SCENE
            .text(path)
            .map_err(|error| Failure::System(format!("{name}: {error}")))?;
        Column::parse(&text).map_err(|error| Failure::input(format!("{name}: {error}")))
    }
}

impl Compared {
    /// Rejects a file of columns for the world at `path`.
    pub fn refuse_columns(&self, path: &Path) -> Result<(), Failure> {
        if self.columns.is_none() {
            return Ok(());
        }
        Err(Failure::Arguments(format!(
            "--columns: {} is a world, whose methods take their settings from [methods.NAME]; name them with --method",
            path.display()
        )))
    }

    /// Returns the columns in a figure: the named ones, or the default selection of a figure.
    fn drawn(&self, columns: &[Column]) -> Vec<usize> {
        let is_named = self.method.is_some() || self.columns.is_some();
        let is_shown = |column: &Column| is_named || palpate_plot::SHOWN.contains(&column.method);
        (0..columns.len())
            .filter(|number| is_shown(&columns[*number]))
            .collect()
    }
}

/// Plans the requested files, and creates the folder of the scenes.
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

/// Writes each plant into a separate file in `folder`. Returns their common name.
fn write_scenes(
    outputs: &Outputs,
    folder: &Path,
    evaluated: &[Evaluated],
) -> Result<PathBuf, Failure> {
    for one in evaluated {
        let path = scene_file(folder, one.plant.index);
        let text = one.plant.scene.to_toml().map_err(Failure::input)?;
        outputs.write(&path, |writer| writer.write_all(text.as_bytes()))?;
    }
    Ok(folder.join("plant-*.toml"))
}
