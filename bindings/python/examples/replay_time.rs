//! Times the library for the workload of `measure`: a million samples, rendered by the named method. Prints
//! the shortest time of several runs `[s]`.

use std::time::Instant;

use palpate_core::{Actuation, Contact, LoopParams, MethodName, ObjectState, Settings};
use palpate_scene::{Delay, Timing};
use palpate_study::report::{Report, Subject};
use palpate_study::sim::replay::{Replay, ReplaySetup};

/// Equal to those of `measure`.
const SAMPLES: u32 = 1_000_000;
const RUNS: u32 = 5;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let name = std::env::args().nth(1).ok_or("which method?")?;
    let method = MethodName::named(&name).ok_or("no such method")?;
    let times: Vec<f64> = (0..SAMPLES).map(|i| f64::from(i) * 1e-3).collect();
    let positions: Vec<f64> = times.iter().map(|t| 0.01 * (12.0 * t).sin()).collect();
    let setup = ReplaySetup {
        contact: Contact::object(400.0, 0.1),
        loop_params: LoopParams::new(1e-3),
        object: ObjectState::at_rest(0.0),
        virtual_force: 0.0,
        actuation: Actuation::default(),
        device_mass: Some(0.25),
        encoder_quantum: 0.0,
    };
    let subject = Subject {
        title: "a motion".into(),
        contact: &setup.contact,
        loop_params: &setup.loop_params,
        device_mass: setup.device_mass,
        delay: Delay::NONE,
        timing: Timing::default(),
        sensor_noise: 0.0,
        seed: None,
    };
    let mut least = f64::INFINITY;
    for _ in 0..RUNS {
        let begun = Instant::now();
        let replay = Replay::new(setup, &times, &positions)?;
        let run = replay.run(method, &Settings::default())?;
        assert_eq!(run.ticks.len(), SAMPLES as usize);
        let runs = [run];
        let report = Report::new(&subject, replay.reference(), &runs);
        drop((report, replay, runs));
        least = least.min(begun.elapsed().as_secs_f64());
    }
    #[allow(clippy::print_stdout)]
    {
        println!("{least}");
    }
    Ok(())
}
