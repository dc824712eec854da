//! `palpate compare`: many scenes and methods in one table.

mod world;

use palpate_scene::SceneFile;
use palpate_scene::SetupError;
use palpate_scene::method::MethodName;
use palpate_study::sim::closed_loop::{Bench, LoopError};
use palpate_study::sim::integrated::Integrator;

use super::simulate::{explain, read_any};
use crate::arguments::{CompareArguments, Flags, TimingFlags};
use crate::failure::Failure;
use crate::progress::Progress;
use crate::results::{draw, print_report};
use crate::setup::only_for_worlds;
use palpate_plot as plots;
use palpate_study::compare::{COLUMNS, Comparison, SceneRows};
use palpate_study::report::Subject;
use palpate_study::table::TableFormat;

/// Runs every method on every scene.
pub fn run(arguments: &CompareArguments) -> Result<(), Failure> {
    let mut outputs = arguments.overwriting.outputs();
    for scene in &arguments.scenes {
        outputs.protect(scene);
    }
    if let Some(out) = &arguments.out {
        outputs.plan("--out", out)?;
    }
    arguments.picture.plan(&mut outputs)?;
    // Read every file before any work.
    let (mut files, mut worlds) = (Vec::new(), Vec::new());
    for path in &arguments.scenes {
        match read_any(path, &arguments.edits)? {
            SceneFile::Contact(file) => files.push((path, file)),
            SceneFile::World(file) => worlds.push((path, file)),
        }
    }
    // Input files include the files that the scenes name.
    outputs.spare_inputs()?;
    if let (Some((path, _)), Some((contact, _))) = (worlds.first(), files.first()) {
        return Err(Failure::Arguments(format!(
            "{} is a world and {} is one contact: their methods differ, so compare them in two tables",
            path.display(),
            contact.display()
        )));
    }
    if !worlds.is_empty() && arguments.integrators {
        return Err(Failure::Arguments(
            "--integrators moves the object of one contact; leave it out for worlds".into(),
        ));
    }
    if !worlds.is_empty() {
        return world::run(arguments, &outputs, &worlds);
    }
    let methods = match &arguments.method {
        Some(methods) => match methods.of_worlds_only() {
            Some(name) => return Err(only_for_worlds(name)),
            None => methods.of_contact(),
        },
        None => MethodName::ALL.to_vec(),
    };
    let progress = Progress::new(files.len() * methods.len());
    let mut scenes = Vec::with_capacity(files.len());
    for (path, file) in &files {
        let scene = &file.scene;
        let no_flags = (&Flags::default(), &TimingFlags::default());
        progress.begin(&format!("ideal of {}", path.display()));
        let bench =
            Bench::new(scene).map_err(|error| explain(no_flags, file, scene.method, error))?;
        let mut outcomes = Vec::with_capacity(methods.len());
        for &method in &methods {
            progress.begin(&format!("{method} on {}", path.display()));
            let outcome = match bench.run(method) {
                Ok(run) => Ok(run),
                Err(LoopError::Setup(error)) => Err(cannot(&error)),
                Err(error) => return Err(explain(no_flags, file, method, error)),
            };
            outcomes.push((method, outcome));
            progress.advance();
        }
        let able = outcomes.iter().filter(|(_, outcome)| outcome.is_ok());
        let able: Vec<_> = able.map(|(method, _)| *method).collect();
        let mut rows = SceneRows::new(
            path.display().to_string(),
            &Subject::new(scene),
            bench.reference(),
            outcomes,
        );
        if arguments.integrators {
            let own = Integrator::ALL.map(|integrator| {
                let run = bench.run_own(integrator);
                (integrator, run.map_err(|error| error.to_string()))
            });
            rows = rows.with_integrators(&Subject::new(scene), &own);
        }
        if arguments.several.are_several() {
            let failure = |error| explain(no_flags, file, scene.method, error);
            rows.seeded = Some(arguments.several.contact(scene, &able, failure)?);
        }
        scenes.push(rows);
    }
    drop(progress);
    let mut comparison = Comparison::new(scenes);
    if let Some(out) = &arguments.out {
        outputs.write(out, |writer| {
            TableFormat::from_path(out).write(writer, &COLUMNS, comparison.rows())
        })?;
        comparison.wrote(out);
    }
    if let Some(path) = &arguments.picture.plot {
        let figure = plots::compared(&comparison);
        draw(&outputs, path, &figure, &arguments.picture.look)?;
        comparison.wrote(path);
    }
    print_report(&comparison, arguments.json)
}

fn cannot(error: &SetupError) -> String {
    match error {
        SetupError::Parameter(parameter) => parameter.to_string(),
        SetupError::Settings(settings) => settings.to_string(),
        SetupError::HoldsConstant(_) => error.to_string(),
    }
}
