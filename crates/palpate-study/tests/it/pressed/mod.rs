//! A device of six axes that its hand presses for long.

use palpate_scene::world::WorldScene;
use palpate_study::sim::world::as_evaluated;
use palpate_testbed::world::{Overlap, PlantParams, WorldPlant};
use palpate_world::{Sample, WorldRenderer};

/// Ripple of the force and the torque in the last of so many seconds at 1 kHz, each as the standard deviation over the
/// mean's length in percent, and the largest penetration `[m]`. None if a sample was refused.
pub fn pressed(scene: &WorldScene, renderer: &WorldRenderer, seconds: usize) -> Option<[f64; 3]> {
    let evaluated = as_evaluated(scene);
    let overlap = Overlap::new(&evaluated).unwrap();
    let mut plant = WorldPlant::new(&evaluated, PlantParams::perfect(0.001)).unwrap();
    let mut state = renderer.start();
    let mut last = [Vec::new(), Vec::new()];
    let mut deepest = 0.0_f64;
    for sample in 0..1000 * seconds {
        let (measured, turned) = (plant.measure(), plant.measure_orientations());
        let output = renderer.step(&mut state, &Sample::at(&measured).turned(&turned));
        if output.fault.is_some() {
            return None;
        }
        if sample >= 1000 * (seconds - 1) {
            last[0].push(output.forces[0]);
            last[1].push(output.torques[0]);
        }
        let pose = [(plant.positions()[0], plant.orientations()[0])];
        let depths = overlap.penetrations_of_poses(&pose, &[]);
        deepest = depths.into_iter().fold(deepest, f64::max);
        plant.hold_wrenches(output.forces, output.torques);
    }
    let ripple = last.map(|all| {
        let count = all.len() as f64;
        let mean = [0, 1, 2].map(|i: usize| all.iter().map(|one| one[i]).sum::<f64>() / count);
        let size = mean.iter().map(|x| x * x).sum::<f64>().sqrt();
        let apart = |one: &[f64; 3]| -> f64 { (0..3).map(|i| (one[i] - mean[i]).powi(2)).sum() };
        let spread = (all.iter().map(apart).sum::<f64>() / count).sqrt();
        100.0 * spread / size
    });
    Some([ripple[0], ripple[1], deepest])
}
