//! `palpate compare` with worlds.

use std::path::PathBuf;

use palpate_record::files::outputs::Outputs;
use palpate_scene::world::{WorldFile, WorldScene};
use palpate_study::table::TableFormat;
use palpate_study::world::compare::{COLUMNS, WorldComparison, WorldRows};

use crate::arguments::CompareArguments;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::results::{draw, print_report};

/// Runs every method on every world. A method without a setting in the scene uses the best of some settings.
pub fn run(
    arguments: &CompareArguments,
    outputs: &Outputs,
    worlds: &[(&PathBuf, Box<WorldFile>)],
) -> Result<(), Failure> {
    let methods = match &arguments.method {
        Some(methods) if !methods.are_all => methods.names.clone(),
        _ => WorldScene::METHODS.to_vec(),
    };
    if let Some(other) = methods
        .iter()
        .find(|name| !WorldScene::METHODS.contains(name))
    {
        return Err(Failure::Arguments(format!(
            "--method: {other} does not render worlds; the methods are {}",
            WorldScene::METHODS.join(", ")
        )));
    }
    let progress = Progress::new(worlds.len() * (methods.len() + 1));
    let mut scenes = Vec::with_capacity(worlds.len());
    for (path, file) in worlds {
        let name = path.display().to_string();
        progress.begin(&format!("ideal of {name}"));
        let rows = WorldRows::of(&name, &file.scene, &methods, |method| {
            progress.advance();
            progress.begin(&format!("{method} on {name}"));
        });
        let failure = |error| Failure::input(format!("{name}: {error}"));
        let mut rows = rows.map_err(failure)?;
        if arguments.several.are_several() {
            // A method whose settings are searched has other ones with each start.
            let able = methods
                .iter()
                .filter(|name| file.scene.method(name).is_ok());
            let able: Vec<_> = able.copied().collect();
            rows.seeded = Some(arguments.several.world(&file.scene, &able, failure)?);
        }
        scenes.push(rows);
        progress.advance();
    }
    drop(progress);
    let mut comparison = WorldComparison::new(scenes);
    if let Some(out) = &arguments.out {
        outputs.write(out, |writer| {
            TableFormat::from_path(out).write(writer, &COLUMNS, comparison.rows())
        })?;
        comparison.wrote(out);
    }
    if let Some(path) = &arguments.picture.plot {
        let figure = palpate_plot::compared_worlds(&comparison);
        draw(outputs, path, &figure, &arguments.picture.look)?;
        comparison.wrote(path);
    }
    print_report(&comparison, arguments.json)
}
