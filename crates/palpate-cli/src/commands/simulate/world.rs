//! `palpate simulate` with a world: methods in closed loop, evaluated against the world's ideal.

use std::path::Path;

use palpate_scene::world::WorldFile;
use palpate_study::sim::world::{WorldBench, WorldBenchError};
use palpate_study::world::WorldReport;

use crate::arguments::{Results, SimulateArguments};
use crate::commands::render::deliver_files;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::results::print_report;
use crate::worlds::{self, failed, wrong_world};

/// Flags of a world's simulation; all other values are in its file.
const FLAGS: [&str; 11] = [
    "scene",
    "method",
    "guard",
    "seeds",
    "start_range",
    "guard_speed",
    "guard_acceleration",
    "guard_hand_force",
    "guard_mass",
    "guard_recovery",
    "guard_allowance",
];

/// Simulates a world by the named methods, or by its own.
pub fn run(arguments: &SimulateArguments, path: &Path, file: &WorldFile) -> Result<(), Failure> {
    let known = [&FLAGS[..], &Results::NAMES].concat();
    worlds::only(&arguments.given, &known, path)?;
    let flags = &arguments.flags;
    let outputs = arguments.results.check(path)?;
    let file = &worlds::guarded(flags, file);
    let scene = &file.scene;
    let methods = worlds::methods(flags, scene);
    // Report errors of a method before computing the ideal.
    let mut renderers = Vec::with_capacity(methods.len());
    for method in methods {
        let renderer = scene.renderer(method);
        let renderer = renderer.map_err(|faults| wrong_world(flags, file, &faults))?;
        renderers.push((method, renderer));
    }
    let failure = |error: WorldBenchError| failed(path)(error);
    let progress = Progress::new(renderers.len());
    progress.begin("ideal");
    let bench = WorldBench::new(scene).map_err(failure)?;
    let mut runs = Vec::with_capacity(renderers.len());
    for (method, renderer) in &renderers {
        progress.begin(method);
        runs.push(bench.run(method, renderer).map_err(failure)?);
        progress.advance();
    }
    drop(progress);
    let names: Vec<_> = renderers
        .iter()
        .map(|(method, _)| worlds::known(method))
        .collect();
    let mut report = WorldReport::new(scene, &bench, &runs);
    if (flags.method.as_ref()).is_some_and(|methods| methods.are_all) {
        report.all_methods(scene);
    }
    deliver_files((&arguments.results, &outputs), scene, &bench, &runs)?;
    if arguments.several.are_several() {
        let seeded = arguments.several.over(scene, &names, failed(path));
        report.seeded = Some(seeded?);
    }
    print_report(&report, arguments.results.json)
}
