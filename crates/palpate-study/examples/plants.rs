//! Generates the table of `docs/results/devices.md`: calibration results of random virtual devices against their true
//! parameters.
//!
//! `cargo run --release -p palpate-study --example plants [-- COUNT [ROW]]`

#![allow(
    clippy::print_stdout,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "prints a table of counts and quantiles"
)]

#[path = "../tests/it/plant/mod.rs"]
mod plant;

use std::time::Instant;

use palpate_study::calibrate::{Excitation, ExcitationParams, Phase, Quantity, measure};
use plant::draws::{Kind, draw};
use plant::{Plant, PlantParams};

fn main() {
    let mut arguments = std::env::args().skip(1);
    let count: u64 = arguments
        .next()
        .map_or(24, |text| text.parse().expect("a count"));
    let row = arguments.next();
    let verbose = arguments.next().is_some();
    let (f, h, x) = (
        Kind {
            friction: true,
            ..Kind::default()
        },
        Kind {
            friction: true,
            hand: true,
            ..Kind::default()
        },
        Kind {
            friction: true,
            hand: true,
            resonance: true,
        },
    );
    let rows = [
        ("rigid, 10 um", Kind::default(), 1e-3, 1e-5),
        ("friction, 10 um", f, 1e-3, 1e-5),
        ("all, 10 um", h, 1e-3, 1e-5),
        ("all, 1 um", h, 1e-3, 1e-6),
        ("all, 100 um", h, 1e-3, 1e-4),
        ("all, resonance, 10 um", x, 1e-3, 1e-5),
        ("all, resonance, 1 um", x, 1e-3, 1e-6),
        ("all, 0.25 ms, 10 um", h, 2.5e-4, 1e-5),
        ("all, 4 ms, 10 um", h, 4e-3, 1e-5),
        ("all, 10 ms, 10 um", h, 1e-2, 1e-5),
    ];
    println!(
        "row                     median    90 %  bias   cover  mass 90 %  cover  resonance  mm   declined  s"
    );
    for (name, kind, period, quantum) in rows {
        if row.as_ref().is_some_and(|row| !name.contains(row.as_str())) {
            continue;
        }
        let found: Vec<_> = (0..count)
            .map(|seed| one(&draw(kind, period, quantum, 1000 + seed), seed, verbose))
            .collect();
        print(name, kind, &found);
    }
}

struct Found {
    delay: f64,
    delay_deviation: f64,
    mass: f64,
    mass_deviation: f64,
    resonance: Option<f64>,
    true_resonance: Option<f64>,
    excursion: f64,
    seconds: f64,
}

fn one(params: &PlantParams, seed: u64, verbose: bool) -> Result<Found, String> {
    let excitation_params = ExcitationParams {
        seed,
        ..ExcitationParams::new(params.period)
    };
    let mut excitation = Excitation::new(excitation_params).expect("parameters in range");
    let mut plant = Plant::new(*params, seed);
    let (mut positions, mut commands) = (Vec::new(), Vec::new());
    while excitation.phase() == Phase::Running {
        let position = plant.measured();
        let command = excitation.next(position);
        plant.advance(command);
        positions.push(position);
        commands.push(command);
    }
    if let Phase::Stopped(stop) = excitation.phase() {
        return Err(stop.to_string());
    }
    let begun = Instant::now();
    let measured = measure(
        &excitation_params,
        excitation.excited(),
        &positions,
        &commands,
    )
    .map_err(|declined| declined.to_string())?;
    let seconds = begun.elapsed().as_secs_f64();
    let calibration = &measured.fitted.calibration;
    let value = |quantity| calibration.value(quantity).expect("a value");
    let deviation = |quantity| {
        calibration
            .standard_deviation(quantity)
            .expect("a deviation")
    };
    let true_mass = params.moved_mass() / params.gain;
    let found = Found {
        delay: value(Quantity::DelayPlusLag) / params.period - params.delay_plus_lag(),
        delay_deviation: deviation(Quantity::DelayPlusLag) / params.period,
        mass: value(Quantity::DeviceMass) / true_mass - 1.0,
        mass_deviation: deviation(Quantity::DeviceMass) / true_mass,
        resonance: calibration.value(Quantity::Resonance),
        true_resonance: params.resonance(),
        excursion: plant.excursion,
        seconds,
    };
    if verbose {
        println!(
            "{seed}: D {:+.4} sd {:.4}, mass {:+.4} sd {:.4}, resonance {:?} true {:?}, {:.2} s; lag {:.3} true {:.3} ms; delay {:.3} T friction {:.3}/{:.3} m {:.3} cog {:.3} trem {:.2}",
            found.delay,
            found.delay_deviation,
            found.mass,
            found.mass_deviation,
            found.resonance,
            found.true_resonance,
            seconds,
            1e3 * value(Quantity::Lag),
            1e3 * params.lag,
            params.delay,
            value(Quantity::CoulombFriction),
            params.coulomb / params.gain,
            params.moved_mass(),
            params.cogging,
            params.tremor
        );
    }
    Ok(found)
}

fn print(name: &str, kind: Kind, all: &[Result<Found, String>]) {
    let found: Vec<&Found> = all.iter().filter_map(|one| one.as_ref().ok()).collect();
    let quantile = |part: f64, of: &dyn Fn(&Found) -> f64| {
        let mut values: Vec<f64> = found.iter().map(|found| of(found).abs()).collect();
        values.sort_by(f64::total_cmp);
        let at = part * (values.len() - 1) as f64;
        let (low, high) = (values[at.floor() as usize], values[at.ceil() as usize]);
        low + (high - low) * at.fract()
    };
    if found.is_empty() {
        println!(
            "{name:22} all declined: {:?}",
            all.iter().find_map(|one| one.as_ref().err())
        );
        return;
    }
    let n = found.len() as f64;
    let share =
        |is: &dyn Fn(&Found) -> bool| found.iter().filter(|found| is(found)).count() as f64 / n;
    let bias = found.iter().map(|found| found.delay).sum::<f64>() / n;
    let resonances = if kind.resonance {
        let near = |found: &Found| {
            found
                .resonance
                .zip(found.true_resonance)
                .is_some_and(|(found, put_in)| (found / put_in - 1.0).abs() < 0.1)
        };
        format!("{:.0}/{}", n * share(&near), found.len())
    } else {
        format!(
            "{:.0} inv.",
            n * share(&|found: &Found| found.resonance.is_some())
        )
    };
    println!(
        "{name:22} {:7.4} {:7.4} {bias:+.4} {:5.0} % {:7.2} % {:5.0} % {resonances:>10} {:5.1} {:6} {:6.2}",
        quantile(0.5, &|found| found.delay),
        quantile(0.9, &|found| found.delay),
        100.0 * share(&|found: &Found| found.delay.abs() <= 2.0 * found.delay_deviation),
        100.0 * quantile(0.9, &|found| found.mass),
        100.0 * share(&|found: &Found| found.mass.abs() <= 2.0 * found.mass_deviation),
        1e3 * quantile(1.0, &|found| found.excursion),
        all.len() - found.len(),
        quantile(1.0, &|found| found.seconds),
    );
    for declined in all.iter().filter_map(|one| one.as_ref().err()) {
        println!("    declined: {declined}");
    }
}
