//! `palpate render` with a world: the recorded motion of its devices, rendered.

use std::path::Path;

use palpate_record::files::outputs::Outputs;
use palpate_scene::SceneFile;
use palpate_scene::world::{WorldFile, WorldScene};
use palpate_study::report::RecordedMotion;
use palpate_study::sim::run::MAX_PERIODS;
use palpate_study::sim::world::{WorldBench, WorldBenchError, WorldRun};
use palpate_study::world::{WorldReport, forces};
use palpate_testbed::world::LedPath;

use crate::arguments::{Flags, RenderArguments, Results, TraceFlags};
use crate::commands::simulate::read_any;
use crate::failure::{Failure, tell};
use crate::inside;
use crate::progress::Progress;
use crate::recorded::trace::{read_world_trace, tell_gap};
use crate::results::{STANDARD_OUTPUT, draw, print_report};
use crate::worlds::{self, wrong_world};

/// Flags for rendering a motion in a world.
const FLAGS: [&str; 5] = ["trace", "input", "method", "from", "to"];

/// Renders the motion in `input` in the world of the scene file, by the named methods or by the scene's own.
pub fn run(arguments: &RenderArguments, input: &Path) -> Result<(), Failure> {
    let path = &arguments.trace;
    let file = match read_any(path, &arguments.flags.edits)? {
        SceneFile::World(file) => file,
        SceneFile::Contact(_) => {
            return Err(Failure::Arguments(format!(
                "--input: {} is one contact; use render TRACE.csv --stiffness ...",
                path.display()
            )));
        }
    };
    let known = [&FLAGS[..], &TraceFlags::NAMES, &Results::NAMES].concat();
    worlds::only(&arguments.given, &known, path)?;
    palpate_record::files::inputs::note(input);
    let outputs = arguments.results.check(path)?;
    let name = input.display().to_string();
    let devices = &file.scene.devices;
    let tools = file.scene.world.tools.iter();
    let names: Vec<&str> = tools.map(|tool| tool.name.as_str()).collect();
    let period = file.scene.timing.period;
    let part = arguments.part.part((MAX_PERIODS + 1) as f64 * period)?;
    let trace = read_world_trace(input, &part, &arguments.table, devices, &names)?;
    let motion = RecordedMotion::new(&trace.t_s, period, trace.notes.left_out);
    tell_gap(&name, &motion);
    let is_unit_given = arguments.table.unit.is_some();
    let path = LedPath::new(trace.t_s, trace.positions_m);
    let path = match trace.orientations {
        none if none.is_empty() => path,
        orientations => path.and_then(|path| path.turned(orientations)),
    };
    let path = path.map_err(|error| Failure::input(format!("{name}: {error}")))?;
    let scene_name = arguments.trace.display().to_string();
    deliver(
        &arguments.flags,
        (&arguments.results, &outputs),
        (&file, &scene_name),
        path,
        |report| {
            if let Some(deep) = inside::deep(report.deepest_m, is_unit_given) {
                tell(format_args!("warning: {name}: {deep}"));
            }
            report.moved(motion);
        },
    )
}

/// Moves the devices of the world called `name` along a path, by the named methods or by the scene's own, and prints
/// the report after `change` has edited it.
pub fn deliver(
    flags: &Flags,
    (results, outputs): (&Results, &Outputs),
    (file, name): (&WorldFile, &str),
    path: LedPath,
    change: impl FnOnce(&mut WorldReport),
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
    let mut report = WorldReport::new(&scene, &bench, &runs);
    change(&mut report);
    if (flags.method.as_ref()).is_some_and(|methods| methods.are_all) {
        report.all_methods(&scene);
    }
    deliver_files((results, outputs), &scene, &bench, &runs)?;
    print_report(&report, results.json)
}

/// Writes the requested signals and the figure.
pub fn deliver_files(
    (results, outputs): (&Results, &Outputs),
    scene: &WorldScene,
    bench: &WorldBench,
    runs: &[WorldRun],
) -> Result<(), Failure> {
    if let Some(out) = &results.out {
        if out == Path::new(STANDARD_OUTPUT) {
            return Err(Failure::Arguments(
                "--out -: the signals of a world are written to a file; name it".into(),
            ));
        }
        outputs.write(out, |writer| forces::write(writer, scene, bench, runs))?;
    }
    if let Some(path) = &results.picture.plot {
        let figure = palpate_plot::world(scene, bench, runs);
        let figure = results.time.cut((&figure).into())?;
        draw(outputs, path, &figure, &results.picture.look)?;
    }
    Ok(())
}
