//! Methods on random worlds: how large the errors are where nobody has chosen the scene.

use std::fmt;

use comfy_table::{Cell, CellAlignment};
use palpate_sim::world::{WorldBench, WorldBenchError, as_rendered};
use palpate_testbed::world::PlantParams;
use palpate_testbed::world::random_worlds::{RandomWorld, random_worlds};
use palpate_world::{BasicParams, CoupledParams, WorldLoop, WorldMethod, WorldRenderer};
use rayon::prelude::*;
use serde::Serialize;

use crate::text::{E, counted, legend, lines, plain_table, short, wrapped};

/// Name and version of the JSON report.
const FORMAT: &str = "palpate world-suite 1";

/// Periods of the loops `[s]`.
const PERIODS: [f64; 3] = [0.001, 0.004, 0.01];
/// Delays of the loops `[samples]`.
const DELAYS: [usize; 2] = [0, 1];
/// Quantum of every sensor `[m]`.
const QUANTUM: f64 = 2e-6;
/// What a damper is tried with, over K T of the tool's contacts.
const DAMPERS: [f64; 13] = [
    0.0, 0.02, 0.04, 0.07, 0.1, 0.14, 0.2, 0.28, 0.4, 0.56, 0.8, 1.1, 1.6,
];

/// What methods made of random worlds.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct WorldSuiteReport {
    /// Name and version of this JSON.
    #[cfg_attr(feature = "schema", schemars(extend("const" = FORMAT)))]
    pub format: &'static str,
    /// Seed of the draws.
    pub seed: u64,
    /// Worlds for each period.
    pub worlds: usize,
    /// Quantum of every sensor.
    pub quantum_m: f64,
    /// One entry for each loop.
    pub loops: Vec<LoopReport>,
}

/// What methods made of random worlds in a loop.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct LoopReport {
    /// Time from sample to sample.
    pub period_s: f64,
    /// Delay, which every renderer is told.
    pub delay_samples: usize,
    /// One entry for each method.
    pub methods: Vec<MethodErrors>,
}

/// Mean-force errors of a method.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct MethodErrors {
    /// Its name; the best damper is the virtual damper with the least error of each world, found with knowledge of the
    /// ideal.
    pub name: &'static str,
    /// E that half of the worlds are below.
    pub median_percent: f64,
    /// E that nine tenths are below.
    pub quantile_90_percent: f64,
    /// The largest E.
    pub largest_percent: f64,
}

/// Names of what is compared.
const NAMES: [&str; 3] = ["basic", "best damper", "coupled"];

/// Draws so many worlds for each period and judges methods on them. `judged` is called for each world and loop.
///
/// # Errors
/// A world that cannot be drawn or judged.
pub fn run(
    worlds: usize,
    seed: u64,
    judged: impl Fn() + Sync,
) -> Result<WorldSuiteReport, WorldBenchError> {
    let mut loops = Vec::new();
    for period in PERIODS {
        let drawn = random_worlds(worlds, period, seed)?;
        for delay in DELAYS {
            let errors: Vec<[f64; 3]> = drawn
                .par_iter()
                .map(|world| {
                    let errors = errors(world, period, delay);
                    judged();
                    errors
                })
                .collect::<Result<_, _>>()?;
            let of = |(place, name): (usize, &'static str)| {
                let mut sorted: Vec<f64> = errors.iter().map(|errors| errors[place]).collect();
                sorted.sort_by(f64::total_cmp);
                let at = |share: usize| sorted[(sorted.len() * share / 100).min(sorted.len() - 1)];
                MethodErrors {
                    name,
                    median_percent: at(50),
                    quantile_90_percent: at(90),
                    largest_percent: at(100),
                }
            };
            loops.push(LoopReport {
                period_s: period,
                delay_samples: delay,
                methods: NAMES.into_iter().enumerate().map(of).collect(),
            });
        }
    }
    Ok(WorldSuiteReport {
        format: FORMAT,
        seed,
        worlds,
        quantum_m: QUANTUM,
        loops,
    })
}

/// Number of calls of `judged` in [`run`].
#[must_use]
pub fn steps(worlds: usize) -> usize {
    worlds * PERIODS.len() * DELAYS.len()
}

/// E of what is compared on one world `[%]`.
fn errors(world: &RandomWorld, period: f64, delay: usize) -> Result<[f64; 3], WorldBenchError> {
    let mut scene = world.scene.clone();
    for device in &mut scene.devices {
        device.quantum = [QUANTUM; 3];
    }
    let rendered = as_rendered(&scene);
    let devices = scene.devices.len();
    let delay_s = delay as f64 * period;
    let params = PlantParams {
        delay: delay_s,
        ..PlantParams::perfect(period)
    };
    let bench = WorldBench::of(scene, params, world.ideal.clone());
    let in_loop = WorldLoop::new(period).with_actuation(palpate::Actuation {
        delay: delay_s,
        ..palpate::Actuation::default()
    });
    let error = |method: WorldMethod| -> Result<f64, WorldBenchError> {
        let renderer = WorldRenderer::new(&rendered, in_loop.clone(), method)
            .map_err(WorldBenchError::Rendering)?;
        let run = bench.run("", &renderer)?;
        let fidelity = run.judgement.sum;
        Ok(fidelity.map_or(0.0, |fidelity| fidelity.mean_force_error))
    };
    let damped = |share: f64| {
        error(
            BasicParams {
                damping: vec![share * world.stiffness * period; devices],
                ..BasicParams::default()
            }
            .into(),
        )
    };
    let mut best = f64::INFINITY;
    for share in DAMPERS {
        best = best.min(damped(share)?);
    }
    let told = CoupledParams::new(vec![world.told_mass; devices]).with_encoder_quantum(QUANTUM);
    Ok([damped(0.0)?, best, error(told.into())?])
}

impl fmt::Display for WorldSuiteReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let drawn = format!(
            "{} for each period, seed {}: a sphere tool in a hand of 60 or 300 N/m with tremor, unequal masses along \
             the axes, told 1.5 or 0.67 times; sensors of {} um. A loop is its period and its delay in samples, which \
             every renderer is told. E in percent, median / 90 % / largest",
            counted(self.worlds, "random world"),
            self.seed,
            1e6 * self.quantum_m
        );
        writeln!(f, "{}\n", wrapped(&drawn))?;
        let mut header = vec!["loop"];
        header.extend(NAMES);
        let mut table = plain_table(CellAlignment::Left, &header);
        for one in &self.loops {
            let cell = |text: String| Cell::new(text).set_alignment(CellAlignment::Right);
            let mut row = vec![Cell::new(format!(
                "{} ms, {}",
                1e3 * one.period_s,
                one.delay_samples
            ))];
            row.extend(one.methods.iter().map(|method| {
                let parts = [
                    method.median_percent,
                    method.quantile_90_percent,
                    method.largest_percent,
                ];
                cell(parts.map(|error| short(error, 1)).join(" / "))
            }));
            table.add_row(row);
        }
        writeln!(f, "{}\n", lines(&table))?;
        let best = "Best damper: the virtual damper with the least E of each world, found with knowledge of its ideal.";
        writeln!(f, "{}", legend(&[E, best]))
    }
}
