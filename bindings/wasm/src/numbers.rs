//! Every number of a run, bit by bit, to compare a browser build with a native one.

use std::fmt::Write as _;

use palpate_scene::method::MethodName;
use palpate_scene::world::WorldScene;
use palpate_scene::{Scene, SceneFile};
use palpate_study::sim::closed_loop::Bench;
use palpate_study::sim::world::as_evaluated;
use palpate_testbed::world::{PlantParams, WorldPlant};
use palpate_world::Sample;

/// Default settings for methods of a world whose file has none: damping `[N s/m]`, stiffness `[N/m]` and mass `[kg]`
/// of the coupling.
const USUAL: (f64, f64, f64) = (1.0, 1000.0, 0.05);

/// Runs a scene or a world by every method over its window and returns the bits of device, force and energy ledger
/// at each tick.
///
/// # Errors
/// A fault of the text, with line and column; a scene that cannot be run.
pub fn numbers(source: &str) -> Result<String, String> {
    match SceneFile::parse("scene", source).map_err(|errors| errors.to_string())? {
        SceneFile::Contact(file) => of_contact(&file.scene),
        SceneFile::World(file) => of_world(file.scene),
    }
}

fn of_contact(scene: &Scene) -> Result<String, String> {
    let bench = Bench::new(scene).map_err(|error| error.to_string())?;
    let mut text = String::new();
    for method in MethodName::ALL {
        let run = bench.run(method).map_err(|error| error.to_string())?;
        for tick in &run.ticks {
            let ledger = &tick.ledger;
            let values = [
                tick.time,
                tick.device_position,
                tick.output.force_on_device,
                tick.held_force_on_object,
                ledger.stored,
                ledger.port_work,
                ledger.original_leak.accumulated,
                ledger.held_leak.accumulated,
            ];
            line(&mut text, method.name(), &values);
        }
        line(&mut text, method.name(), &[run.force.peak_force]);
    }
    Ok(text)
}

fn of_world(mut scene: WorldScene) -> Result<String, String> {
    let (damping, stiffness, mass) = USUAL;
    for method in WorldScene::METHODS {
        let settings = scene.render.settings.entry(method).or_default();
        settings.damping.get_or_insert(damping);
        settings.coupling.stiffness.get_or_insert(stiffness);
        settings.coupling.mass.get_or_insert(mass);
    }
    let params = PlantParams {
        period: scene.timing.period,
        actuator: scene.timing.actuator,
        seed: scene.timing.imperfections.seed,
    };
    if !scene.timing.is_perfect() {
        return Err("this run supports only worlds without delay, jitter and drops".into());
    }
    let evaluated = as_evaluated(&scene);
    let mut text = String::new();
    for method in WorldScene::METHODS {
        let renderer = scene.renderer(method);
        let renderer = renderer.map_err(|errors| errors.to_string())?;
        let mut plant = WorldPlant::new(&evaluated, params).map_err(|error| error.to_string())?;
        let mut state = renderer.start();
        while plant.time() < scene.duration - 0.5 * scene.timing.period {
            let (measured, turned) = (plant.measure(), plant.measure_orientations());
            let sample = Sample::at(&measured).turned(&turned);
            let output = renderer.step(&mut state, &sample);
            let mut values: Vec<f64> = measured.iter().flatten().copied().collect();
            values.extend(output.forces.iter().flatten());
            values.extend(output.torques.iter().flatten());
            plant.hold_wrenches(output.forces, output.torques);
            for body in state.bodies() {
                values.extend(body.position);
                values.extend(body.orientation);
            }
            let ledger = &state.ledger().contacts;
            values.extend(ledger.iter().map(|entry| entry.stored));
            values.extend(ledger.iter().map(|entry| entry.leak()));
            line(&mut text, method, &values);
        }
    }
    Ok(text)
}

/// Appends a line: its label and the bits of its numbers.
fn line(text: &mut String, of: &str, values: &[f64]) {
    text.push_str(of);
    for value in values {
        // Writing to a string does not fail.
        let _ = write!(text, " {:016x}", value.to_bits());
    }
    text.push('\n');
}
