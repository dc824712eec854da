//! `palpate render` with a world: the recorded motion of its devices, rendered.

use std::path::Path;

use palpate_files::outputs::Outputs;
use palpate_record::trace::read_world;
use palpate_scene::world::WorldFile;
use palpate_sim::world::{WorldBench, WorldBenchError};
use palpate_study::world::{WorldReport, forces};
use palpate_testbed::world::LedPath;

use crate::arguments::{Flags, RenderArguments, Results};
use crate::commands::simulate::{AnyScene, read_any};
use crate::failure::Failure;
use crate::progress::Progress;
use crate::results::print_report;
use crate::worlds::{self, wrong_world};

/// What rendering a motion in a world takes.
const FLAGS: [&str; 6] = ["trace", "input", "method", "out", "overwrite", "json"];

/// Renders the motion in `input` in the world of the scene file, by the methods that were named or by its own.
pub fn run(arguments: &RenderArguments, input: &Path) -> Result<(), Failure> {
    let path = &arguments.trace;
    let file = match read_any(path)? {
        AnyScene::World(file) => file,
        AnyScene::Contact(_) => {
            return Err(Failure::Arguments(format!(
                "--input: {} is one contact; a motion is rendered there by render TRACE.csv --stiffness ...",
                path.display()
            )));
        }
    };
    worlds::only(&arguments.given, &FLAGS, path)?;
    palpate_files::inputs::note(input);
    let outputs = arguments.results.check(path)?;
    let name = input.display().to_string();
    let opened =
        std::fs::File::open(input).map_err(|error| Failure::System(format!("{name}: {error}")))?;
    let devices = file.scene.devices.iter();
    let turns: Vec<bool> = devices.map(|device| device.turning.is_some()).collect();
    let trace = read_world(opened, &name, &turns).map_err(Failure::input)?;
    let path = LedPath::new(trace.t_s, trace.positions_m);
    let path = match trace.orientations {
        none if none.is_empty() => path,
        orientations => path.and_then(|path| path.turned(orientations)),
    };
    let path = path.map_err(|error| Failure::input(format!("{name}: {error}")))?;
    let name = arguments.trace.display().to_string();
    deliver(
        &arguments.flags,
        (&arguments.results, &outputs),
        (&file, &name),
        path,
    )
}

/// Leads the devices of the world called `name` along a path, by the methods that were named or by its own, and prints
/// what came out.
pub fn deliver(
    flags: &Flags,
    (results, outputs): (&Results, &Outputs),
    (file, name): (&WorldFile, &str),
    path: LedPath,
) -> Result<(), Failure> {
    let scene = file.scene.led();
    let mut renderers = Vec::new();
    for method in worlds::methods(flags, &scene) {
        let renderer = scene.renderer(method);
        let renderer = renderer.map_err(|faults| wrong_world(flags, file, &faults))?;
        renderers.push((method, renderer));
    }
    let failure = |error: WorldBenchError| Failure::input(format!("{name}: {error}"));
    let progress = Progress::new(renderers.len());
    progress.begin("ideal");
    let bench = WorldBench::led(&scene, path).map_err(failure)?;
    let mut runs = Vec::with_capacity(renderers.len());
    for (method, renderer) in &renderers {
        progress.begin(method);
        runs.push(bench.run(method, renderer).map_err(failure)?);
        progress.advance();
    }
    drop(progress);
    if let Some(out) = &results.out {
        outputs.write(out, |writer| forces::write(writer, &scene, &runs))?;
    }
    let mut report = WorldReport::new(&scene, &bench, &runs);
    if (flags.method.as_ref()).is_some_and(|methods| methods.are_all) {
        report.all_methods(&scene);
    }
    print_report(&report, results.json)
}
