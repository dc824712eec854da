//! `palpate simulate`: a scene in closed loop.

use std::path::Path;

use palpate_sim::closed_loop::{Bench, LoopError};
use palpate_sim::method::MethodName;
use palpate_sim::run::Run;
use palpate_sim::scene::{Scene, SceneError, SceneFile, SetupError};

use crate::arguments::{Flags, SimulateArguments};
use crate::failure::Failure;
use crate::plots;
use crate::progress::Progress;
use crate::report::{Report, Subject};
use crate::results::deliver;
use crate::setup::{receipt, wrong_flag};

/// Simulates a scene by the methods that were named, or by its own.
pub fn run(arguments: &SimulateArguments) -> Result<(), Failure> {
    let flags = &arguments.flags;
    let file = read_scene(&arguments.scene)?;
    let methods = flags.methods(file.scene.method);
    flags.check_settings(&methods)?;
    let mut scene = file.scene.clone();
    flags.change(&mut scene, &methods)?;
    let failure = |method, error| explain(flags, &file, method, error);
    let bench = Bench::new(&scene).map_err(|error| failure(scene.method, error))?;
    let mut progress = Progress::new(methods.len());
    let mut runs = Vec::with_capacity(methods.len());
    for &method in &methods {
        progress.begin(method.name());
        runs.push(bench.run(method).map_err(|error| failure(method, error))?);
        progress.advance();
    }
    drop(progress);
    let subject = subject(&scene);
    let mut receipt = receipt(&subject, scene.object, scene.virtual_force, &runs);
    receipt.push(("scene".into(), arguments.scene.display().to_string()));
    let report = Report::new(&subject, bench.reference(), &runs);
    deliver(&arguments.results, report, &receipt, &runs, || {
        plots::overlay(&scene.title, bench.reference(), &runs)
    })
}

/// What a report says of a scene.
pub fn subject(scene: &Scene) -> Subject<'_> {
    Subject {
        title: scene.title.clone(),
        contact: &scene.contact,
        loop_params: &scene.loop_params,
        device_mass: Some(scene.device.mass),
        delay: scene.delay,
    }
}

/// Runs every method of `methods` on a scene that is known to be sound.
pub fn simulate<'a>(
    scene: &'a Scene,
    methods: &[MethodName],
) -> Result<(Bench<'a>, Vec<Run>), Failure> {
    let bench = Bench::new(scene).map_err(Failure::input)?;
    let runs = methods
        .iter()
        .map(|&method| bench.run(method).map_err(Failure::input))
        .collect::<Result<_, _>>()?;
    Ok((bench, runs))
}

fn read_scene(path: &Path) -> Result<SceneFile, Failure> {
    let text = std::fs::read_to_string(path).map_err(|error| match error.kind() {
        std::io::ErrorKind::InvalidData => {
            Failure::input(format!("{}: a scene is UTF-8 text", path.display()))
        }
        _ => Failure::System(format!("{}: {error}", path.display())),
    })?;
    SceneFile::parse(&path.display().to_string(), &text).map_err(in_file)
}

fn in_file(error: SceneError) -> Failure {
    Failure::input_at(&error, &error.file, &error.source_text, error.span.clone())
}

/// A scene that cannot be run: the fault lies in a flag if one gave the value, else in the file.
fn explain(flags: &Flags, file: &SceneFile, method: MethodName, error: LoopError) -> Failure {
    match error {
        LoopError::Setup(SetupError::Parameter(parameter)) if flags.gives(parameter.parameter) => {
            wrong_flag(&parameter)
        }
        LoopError::Setup(setup) => in_file(file.locate(method, &setup)),
        other => Failure::input(other),
    }
}
