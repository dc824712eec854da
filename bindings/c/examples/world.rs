//! Prints the output of tests/c/world.c without C: both must agree bit for bit.

use palpate_device::Wrench;
use palpate_rt::BoundedWorld;
use palpate_rt::safety::SafetyParams;
use palpate_scene::world::WorldFile;
use palpate_world::Sample;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [scene, line @ ..] = &arguments[..] else {
        return Err("usage: world SCENE X Y Z VX VY VZ".into());
    };
    let line: Vec<f64> = line
        .iter()
        .map(|number| number.parse())
        .collect::<Result<_, _>>()?;
    let mut file = WorldFile::parse(scene, &std::fs::read_to_string(scene)?)?;
    file.scene.render.force_limit = Some(5.0);
    file.scene.render.torque_limit = Some(1.0);
    let renderer = file.scene.renderer(&file.scene.render.method);
    let renderer = renderer.map_err(|faults| format!("{faults:?}"))?;
    let limits = SafetyParams::bounding(Some(5.0), Some(1.0), 0.2);
    let period = file.scene.timing.period;
    let mut world = BoundedWorld::new(renderer, limits)?;
    for tick in 0..400 {
        let time = f64::from(tick) * period;
        let mut position = [0, 1, 2].map(|axis| line[axis] + line[3 + axis] * time);
        if tick == 100 {
            position[1] = f64::NAN;
        }
        let positions = [position];
        let mut sample = Sample::at(&positions).turned(&[[1.0, 0.0, 0.0, 0.0]]);
        if tick == 150 {
            sample = sample.after(0.0013);
        }
        let held = world.step(&sample);
        let mut wrench = held.wrenches[0];
        let (fault, sub_steps) = (held.fault.is_some(), held.effort.sub_steps);
        if tick == 200 {
            wrench.force[0] *= 0.5;
            world.report_sent(0, wrench, [0.0; 3]);
        }
        let Wrench { force, torque } = wrench;
        for number in force.iter().chain(&torque) {
            print!("{:016x} ", number.to_bits());
        }
        // Fault 1 is a non-finite position.
        println!("{} {sub_steps}", u32::from(fault));
    }
    Ok(())
}
