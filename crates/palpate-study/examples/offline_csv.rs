//! A recorded motion, rendered offline: which method leaks how much on it?
//!
//! `cargo run -p palpate-study --example offline_csv [TRACE.csv]` with the columns `t_s,position_m`;
//! without a file, a recorded press on a wall is made up.

#![allow(clippy::print_stdout)] // an example prints what it found

use std::error::Error;

use palpate_core::{Actuation, Contact, LoopParams, ObjectState};
use palpate_record::trace::{self, Trace};
use palpate_scene::method::{MethodName, Settings};
use palpate_study::sim::replay::{Replay, ReplaySetup};

fn main() -> Result<(), Box<dyn Error>> {
    let recording = match std::env::args().nth(1) {
        Some(path) => trace::read(std::fs::File::open(&path)?, &path)?,
        None => press(),
    };
    let setup = ReplaySetup {
        contact: Contact::wall(1000.0),
        loop_params: LoopParams::new(0.01),
        object: ObjectState::at_rest(0.0),
        virtual_force: 0.0,
        actuation: Actuation::default(),
        device_mass: None,
        encoder_quantum: 0.0,
    };
    let replay = Replay::new(setup, &recording.t_s, &recording.position_m)?;
    println!("{:16} {:>12} {:>12}", "method", "E [%]", "|leak| [mJ]");
    for method in MethodName::ALL {
        let run = replay.run(method, &Settings::default())?;
        let error = run.force.fidelity.map_or(f64::NAN, |f| f.mean_force_error);
        let leak = 1e3 * run.last().ledger.held_leak.absolute;
        println!("{method:16} {error:12.2} {leak:12.3}");
    }
    Ok(())
}

/// Two presses, 8 mm deep, recorded at 2 kHz.
fn press() -> Trace {
    let t_s: Vec<f64> = (0..4000).map(|i| f64::from(i) * 0.0005).collect();
    let position_m = t_s
        .iter()
        .map(|t| -0.008 * (std::f64::consts::TAU * t).cos())
        .collect();
    Trace { t_s, position_m }
}
