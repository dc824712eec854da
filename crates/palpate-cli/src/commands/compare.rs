//! `palpate compare`: many scenes and methods in one table.

use std::path::{Path, PathBuf};

use palpate_scene::method::MethodName;
use palpate_scene::world::{WorldFile, WorldScene};
use palpate_scene::{ContactFile, SceneFile, SetupError};
use palpate_study::sim::closed_loop::{Bench, LoopError};
use palpate_study::sim::integrated::Integrator;
use palpate_study::studied::StudyError;
use palpate_study::suite::Column;

use super::simulate::{explain, read_any};
use crate::arguments::{CompareArguments, Flags, TimingFlags};
use crate::failure::Failure;
use crate::progress::Progress;
use crate::results::{draw_study, print_report, write_table};
use crate::setup::only_for_worlds;
use crate::worlds::{compared, failed};
use palpate_study::compare::{COLUMNS, Comparison, SceneRows};
use palpate_study::report::Subject;

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
    let read = |path: &PathBuf| read_any(path, &arguments.edits);
    let files = (arguments.scenes.iter().map(read)).collect::<Result<Vec<_>, _>>()?;
    // Input files include the files that the scenes name.
    outputs.spare_inputs()?;
    let of_worlds = compared(arguments.method.as_ref(), || WorldScene::METHODS.to_vec());
    let of_contacts = match &arguments.method {
        Some(methods) => match methods.of_worlds_only() {
            Some(name) => Err(only_for_worlds(name)),
            None => Ok(methods.of_contact()),
        },
        None => Ok(MethodName::ALL.to_vec()),
    };
    let mut steps = 0;
    for file in &files {
        steps += match (file, &of_contacts, &of_worlds) {
            (SceneFile::Contact(_), Ok(methods), _) => methods.len(),
            (SceneFile::World(_), _, Ok(methods)) => methods.len() + 1,
            (SceneFile::Contact(_), Err(_), _) => return of_contacts.map(drop),
            (SceneFile::World(_), _, Err(_)) => return of_worlds.map(drop),
        };
    }
    let (of_contacts, of_worlds) = (
        of_contacts.unwrap_or_default(),
        of_worlds.unwrap_or_default(),
    );
    let progress = Progress::new(steps);
    let mut scenes = Vec::with_capacity(files.len());
    for (path, file) in arguments.scenes.iter().zip(&files) {
        progress.begin(&format!("ideal of {}", path.display()));
        scenes.push(match file {
            SceneFile::Contact(file) => contact(arguments, path, file, &of_contacts, &progress)?,
            SceneFile::World(file) => world(arguments, path, file, &of_worlds, &progress)?,
        });
    }
    drop(progress);
    let mut comparison = Comparison::new(scenes);
    let table = write_table(
        &outputs,
        arguments.out.as_ref(),
        &COLUMNS,
        comparison.rows(),
    )?;
    comparison.files.extend(table);
    let figure = draw_study(&outputs, &arguments.picture, || {
        palpate_plot::compared(&comparison)
    })?;
    comparison.files.extend(figure);
    print_report(&comparison, arguments.json)
}

/// Runs every method on one contact.
fn contact(
    arguments: &CompareArguments,
    path: &Path,
    file: &ContactFile,
    methods: &[MethodName],
    progress: &Progress,
) -> Result<SceneRows, Failure> {
    let scene = &file.scene;
    let no_flags = (&Flags::default(), &TimingFlags::default());
    let bench = Bench::new(scene).map_err(|error| explain(no_flags, file, scene.method, error))?;
    let mut outcomes = Vec::with_capacity(methods.len());
    for &method in methods {
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
    let able: Vec<_> = able.map(|(method, _)| Column::new(*method)).collect();
    let name = path.display().to_string();
    let subject = Subject::new(scene);
    let mut rows = SceneRows::new(name, &subject, bench.reference(), outcomes);
    if arguments.integrators {
        let own = Integrator::ALL.map(|integrator| {
            let run = bench.run_own(integrator);
            (integrator, run.map_err(|error| error.to_string()))
        });
        rows = rows.with_integrators(&subject, &own);
    }
    if arguments.several.are_several() {
        let failure = |error| match error {
            StudyError::Contact(error) => explain(no_flags, file, scene.method, error),
            other => failed(path)(other),
        };
        rows.seeded = Some(arguments.several.over(scene, &able, failure)?);
    }
    Ok(rows)
}

/// Runs every method on a world. A method without a setting in the scene uses the best of some settings.
fn world(
    arguments: &CompareArguments,
    path: &Path,
    file: &WorldFile,
    methods: &[&'static str],
    progress: &Progress,
) -> Result<SceneRows, Failure> {
    if arguments.integrators {
        return Err(Failure::Arguments(format!(
            "--integrators moves the object of one contact, and {} is a world; omit one of them",
            path.display()
        )));
    }
    let (name, scene) = (path.display().to_string(), &file.scene);
    let rows = SceneRows::of_world(&name, scene, methods, |method| {
        progress.advance();
        progress.begin(&format!("{method} on {name}"));
    });
    let mut rows = rows.map_err(failed(path))?;
    progress.advance();
    if arguments.several.are_several() {
        // A method whose settings are searched has other ones with each start.
        let able = methods.iter().filter(|name| scene.method(name).is_ok());
        let able: Vec<_> = able.copied().collect();
        rows.seeded = Some(arguments.several.over(scene, &able, failed(path))?);
    }
    Ok(rows)
}

fn cannot(error: &SetupError) -> String {
    match error {
        SetupError::Parameter(parameter) => parameter.to_string(),
        SetupError::Settings(settings) => settings.to_string(),
        SetupError::HoldsConstant(_) => error.to_string(),
    }
}
