//! `palpate render` with a world: the recorded motion of its devices, rendered.

use std::io::Write;
use std::path::Path;

use palpate_files::outputs::Outputs;
use palpate_record::trace::read_world;
use palpate_scene::world::{WorldFile, WorldScene};
use palpate_sim::world::{WorldBench, WorldBenchError, WorldRun};
use palpate_study::world::WorldReport;
use palpate_testbed::world::LedPath;
use palpate_world::Tool;

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
        outputs.write(out, |writer| write_forces(writer, &scene, &runs))?;
    }
    print_report(&WorldReport::new(&scene, &bench, &runs), results.json)
}

/// A row for each method, sample and device: where it was, and the force that was commanded then; where a device turns, also
/// how it was turned, and where one gives a torque, that.
fn write_forces(
    writer: &mut dyn Write,
    scene: &WorldScene,
    runs: &[WorldRun],
) -> std::io::Result<()> {
    let mut csv = csv::Writer::from_writer(writer);
    let turns = scene.devices.iter().any(|device| device.turning.is_some());
    let mut header = vec![
        "method", "device", "t_s", "x_m", "y_m", "z_m", "fx_n", "fy_n", "fz_n",
    ];
    if turns {
        header.extend(["qw", "qx", "qy", "qz"]);
    }
    let gives_torque = scene.world.tools.iter().any(Tool::feels_torque);
    if gives_torque {
        header.extend(["tx_n_m", "ty_n_m", "tz_n_m"]);
    }
    csv.write_record(header)?;
    for run in runs {
        for (sample, positions) in run.positions.iter().enumerate() {
            let time = sample as f64 * scene.timing.period;
            for (device, (tool, position)) in scene.world.tools.iter().zip(positions).enumerate() {
                let forces = &run.commanded[sample][device];
                let mut row = vec![run.method.clone(), tool.name.clone(), time.to_string()];
                row.extend(position.iter().chain(forces).map(ToString::to_string));
                if turns {
                    let orientation = &run.orientations[sample][device];
                    row.extend(orientation.iter().map(ToString::to_string));
                }
                if gives_torque {
                    let torques = &run.commanded_torques[sample][device];
                    row.extend(torques.iter().map(ToString::to_string));
                }
                csv.write_record(row)?;
            }
        }
    }
    csv.flush()
}
