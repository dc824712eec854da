use palpate_scene::method::MethodName;
use palpate_sim::closed_loop::Bench;
use palpate_study::suite::{Condition, Set, Telling};
use rayon::prelude::*;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let seed: u64 = a[1].parse().unwrap();
    let n: usize = a[2].parse().unwrap();
    let set = *Set::ALL.iter().find(|s| s.name() == a[3]).unwrap();
    let rows: Vec<_> = (0..n).into_par_iter().map(|i| {
        let plant = set.draw(seed, i).unwrap();
        let mut errors = vec![];
        let last = if set == Set::Calibrated { Telling::Measured } else { Telling::Calibrated };
        let f = |n: &str| std::env::var(n).ok().and_then(|v| v.parse::<f64>().ok()).unwrap_or(1.0);
        let mut plant = plant;
        plant.scene.device.coulomb_friction *= f("FRIC");
        if let Some(c) = &mut plant.scene.device.cogging { c.amplitude *= f("COG"); }
        plant.scene.device.encoder_quantum *= f("QUANT");
        if f("LAG") == 0.0 { plant.scene.actuator.lag = 0.0; plant.scene.timing.delay_seconds = 0.0; }
        if f("HAND") == 0.0 { plant.scene.grip = None; plant.scene.tremor = None; }
        for telling in [Telling::Truth, last] {
            for without in [true, false] {
                let mut scene = Condition::Told(telling).of(&plant);
                if without { scene.told.transmission = None; }
                let bench = Bench::new(&scene).unwrap();
                let run = bench.run_varied(&scene, MethodName::Coupled).unwrap();
                errors.push(run.force.fidelity.unwrap().mean_force_error);
            }
        }
        (i, plant, errors)
    }).collect();
    for (i, plant, errors) in &rows {
        let d = &plant.scene.device;
        let t = d.transmission.unwrap_or(palpate_scene::Transmission{resonance_hz:0.,damping_ratio:0.,motor_share:1.,backlash:0.});
        let m = plant.scene.told.transmission;
        println!("{i} {} K {:.0} M {:.3} m {:.3} f {:.0} z {:.3} s {:.2} bl {:.0e} q {:.0e} hand {:.3} | told {:?} | {}",
            if plant.scene.title.contains("stiffer") {"STIFF"} else {"-"},
            plant.scene.contact.stiffness, match plant.scene.contact.object_mass {palpate::Mass::Finite(m)=>m, _=>0.}, d.mass, t.resonance_hz, t.damping_ratio, t.motor_share, t.backlash, d.encoder_quantum,
            plant.scene.grip.as_ref().map_or(0.0, |g| g.mass),
            m.map(|m| ((m.resonance*10.).round()/10., (m.damping_ratio*1e3).round()/1e3, (m.flexible_mass_fraction*100.).round()/100.)),
            errors.iter().map(|e| format!("{e:7.1}")).collect::<Vec<_>>().join(" "));
    }
    for kind in ["all", "soft", "stiff"] {
        for c in 0..4 {
            let mut e: Vec<f64> = rows.iter().filter(|(_, p, _)| match kind { "all" => true, "stiff" => p.scene.title.contains("stiffer"), _ => !p.scene.title.contains("stiffer") }).map(|r| r.2[c]).collect();
            e.sort_by(f64::total_cmp);
            if e.is_empty() { continue; }
            let q = |p: f64| e[((e.len()-1) as f64 * p).round() as usize];
            println!("{kind} {} {}: {:.1} / {:.1} / {:.1}  n {}", if c < 2 {"truth"} else {"measured"}, ["untold", "told"][c % 2], q(0.5), q(0.9), q(1.0), e.len());
        }
    }
}
