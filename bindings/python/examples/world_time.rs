//! Times the library for the workload of `measure`: many worlds, one tick of each at a time, in one thread. Prints
//! the shortest time of several runs `[s]`.

use std::path::Path;
use std::time::Instant;

use palpate_rt::BoundedWorld;
use palpate_rt::safety::SafetyParams;
use palpate_scene::world::WorldFile;
use palpate_world::Sample;

/// Equal to those of `measure`.
const WORLDS: u32 = 1000;
const TICKS: u32 = 50;
const RUNS: u32 = 5;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("which scene?")?;
    let path = Path::new(&path);
    let text = std::fs::read_to_string(path)?;
    let file = WorldFile::parse_in("the scene", &text, path.parent().unwrap_or(path))
        .map_err(|errors| format!("{errors}"))?;
    let scene = &file.scene;
    let renderer = scene
        .renderer(&scene.render.method)
        .map_err(|errors| format!("{errors}"))?;
    let limits = SafetyParams::bounding(Some(20.0), None, 0.0);
    let world = BoundedWorld::new(renderer, limits)?;
    let start = scene.devices[0].position;
    let mut worlds: Vec<_> = (0..WORLDS).map(|_| world.clone()).collect();
    let mut least = f64::INFINITY;
    for _ in 0..RUNS {
        let begun = Instant::now();
        for tick in 0..TICKS {
            for (number, world) in (0..WORLDS).zip(&mut worlds) {
                let phase = 0.03 * f64::from(tick) + f64::from(number);
                let position = [start[0], start[1], start[2] + 0.002 * phase.sin()];
                world.step(&Sample::at(&[position]));
            }
        }
        least = least.min(begun.elapsed().as_secs_f64());
    }
    #[allow(clippy::print_stdout)]
    {
        println!("{least}");
    }
    Ok(())
}
