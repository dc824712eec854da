//! The loop on a manually stepped clock, so that every run is reproducible.

#![allow(clippy::print_stdout)] // tests show what they measured

mod change;
mod faults;
mod foreign;
mod letting_go;
mod lines;
mod local_world;
mod motors_off;
mod recoveries;
mod safety;
mod several;
mod simulated;
mod time;
mod world_change;
mod worlds;

use std::path::Path;

use palpate_device::clock::SteppedClock;
use palpate_device::{ScriptedDevice, Step};
use palpate_rt::ControlLoop;
use palpate_rt::safety::{OscillationParams, SafetyParams};
use palpate_scene::method::MethodName;
use palpate_scene::{ContactFile, Scene, beside};
use palpate_study::sim::device::SimulatedDevice;

/// Loads a scene of `experiments/`.
pub(crate) fn scene(name: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../experiments")
        .join(name);
    #[allow(clippy::disallowed_methods, reason = "set-up")]
    let text = std::fs::read_to_string(&path).unwrap();
    ContactFile::parse_with(name, &text, &mut beside(&path))
        .unwrap()
        .scene
}

/// Returns limits that no scene of the paper reaches.
pub(crate) fn wide() -> SafetyParams {
    SafetyParams {
        largest_force: 1e6,
        largest_speed: 1e6,
        soft_start: 0.0,
        oscillation: OscillationParams {
            energy: f64::INFINITY,
            window: 1.0,
        },
        ..SafetyParams::default()
    }
}

pub(crate) fn simulated(
    scene: &Scene,
    method: MethodName,
    limits: SafetyParams,
) -> (
    ControlLoop<SimulatedDevice<SteppedClock>, SteppedClock>,
    SteppedClock,
) {
    let clock = SteppedClock::new();
    let device = SimulatedDevice::new(scene, clock.clone()).unwrap();
    let rendering = scene.rendering(method).unwrap();
    let control = ControlLoop::new(device, clock.clone(), rendering, limits).unwrap();
    (control, clock)
}

pub(crate) type Scripted = ControlLoop<ScriptedDevice<SteppedClock>, SteppedClock>;

/// Creates a loop at 1 kHz on a pressed wall of 1000 N/m with the plain spring law, on a device that follows
/// `script`: 1 N per millimetre.
pub(crate) fn scripted(script: Vec<Step>, limits: SafetyParams) -> (Scripted, SteppedClock) {
    let mut pressed = scene("wall.toml");
    pressed.contact.stiffness = 1000.0;
    pressed.object.position = 0.0;
    pressed.loop_params.period = 0.001;
    pressed.loop_params.largest_gap = None;
    pressed.virtual_force = 0.0;
    let clock = SteppedClock::new();
    let device = ScriptedDevice::new(clock.clone(), 1, script);
    let rendering = pressed.rendering(MethodName::Basic).unwrap();
    let control = ControlLoop::new(device, clock.clone(), rendering, limits).unwrap();
    (control, clock)
}

/// Returns a step at `millimetres`.
pub(crate) fn at(millimetres: f64) -> Step {
    Step::At([millimetres * 1e-3, 0.0, 0.0])
}
