//! Methods on random worlds: how large the errors are where nobody has chosen the scene.

use std::fmt;

use comfy_table::{Cell, CellAlignment};
use palpate_scene::world::WorldSettings;
use palpate_sim::world::{WorldBench, WorldBenchError, as_rendered};
use palpate_testbed::world::PlantParams;
use palpate_testbed::world::random_worlds::{RandomHands, RandomWorld, random_worlds};
use palpate_world::{CoupledParams, WorldLoop, WorldMethod, WorldRenderer};
use rayon::prelude::*;
use serde::Serialize;

use super::candidates::{Scale, Tunable};
use crate::text::{E, counted, legend, lines, plain_table, short, wrapped};

/// Name and version of the JSON report.
const FORMAT: &str = "palpate world-suite 2";

/// Periods of the loops `[s]`.
const PERIODS: [f64; 3] = [0.001, 0.004, 0.01];
/// Quantum of the sensors of desktop devices `[m]`.
const QUANTUM: f64 = 2e-6;

/// A family of random worlds, and the loops that they are rendered in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WorldSet {
    /// Tools in a hand, with and without a sample of delay.
    Hand,
    /// Tools that a constant force pushes, with perfect sensors and others.
    Free,
}

/// A loop but for its period.
#[derive(Clone, Copy, Debug)]
struct Condition {
    delay_samples: usize,
    /// `[m]`
    quantum: f64,
}

impl WorldSet {
    /// All sets.
    pub const ALL: [Self; 2] = [Self::Hand, Self::Free];

    /// Its name, by which the program knows it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Hand => "worlds",
            Self::Free => "worlds-free",
        }
    }

    fn hands(self) -> RandomHands {
        match self {
            Self::Hand => RandomHands::Springs,
            Self::Free => RandomHands::Pushes,
        }
    }

    fn conditions(self) -> [Condition; 2] {
        let condition = |delay_samples, quantum| Condition {
            delay_samples,
            quantum,
        };
        match self {
            Self::Hand => [condition(0, QUANTUM), condition(1, QUANTUM)],
            Self::Free => [condition(0, 0.0), condition(0, QUANTUM)],
        }
    }

    /// What is drawn, in words.
    fn drawn(self) -> &'static str {
        match self {
            Self::Hand => {
                "a sphere tool in a hand of 60 or 300 N/m with tremor, unequal masses along the axes, told 1.5 or \
                 0.67 times"
            }
            Self::Free => {
                "a sphere tool that a constant force pushes, without a hand, unequal masses along the axes, told 1.5 \
                 times"
            }
        }
    }
}

/// What methods made of random worlds.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct WorldSuiteReport {
    /// Name and version of this JSON.
    #[cfg_attr(any(test, feature = "schema"), schemars(extend("const" = FORMAT)))]
    pub format: &'static str,
    /// Name of the set.
    pub set: &'static str,
    /// Seed of the draws.
    pub seed: u64,
    /// Worlds for each period.
    pub worlds: usize,
    /// One entry for each loop.
    pub loops: Vec<LoopReport>,
}

/// What methods made of random worlds in a loop.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct LoopReport {
    /// Time from sample to sample.
    pub period_s: f64,
    /// Delay, which every renderer is told.
    pub delay_samples: usize,
    /// Quantum of every sensor, which `coupled` is told.
    pub quantum_m: f64,
    /// One entry for each method.
    pub methods: Vec<MethodErrors>,
}

/// Mean-force errors of a method.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct MethodErrors {
    /// Its name; the best of a method has the setting with the least error of each world, found with knowledge of the
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
const NAMES: [&str; 5] = [
    "basic",
    "best damper",
    "best virtual coupling",
    "best god-object",
    "coupled",
];

/// Draws so many worlds of a set for each period and judges methods on them. `judged` is called for each world and loop.
///
/// # Errors
/// A world that cannot be drawn or judged.
pub fn run(
    set: WorldSet,
    worlds: usize,
    seed: u64,
    judged: impl Fn() + Sync,
) -> Result<WorldSuiteReport, WorldBenchError> {
    let mut loops = Vec::new();
    for period in PERIODS {
        let drawn = random_worlds(set.hands(), worlds, period, seed)?;
        for condition in set.conditions() {
            let errors: Vec<[f64; NAMES.len()]> = drawn
                .par_iter()
                .map(|world| {
                    let errors = errors(world, period, condition);
                    judged();
                    errors
                })
                // Who wants no more of it lets `judged` panic.
                .panic_fuse()
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
                delay_samples: condition.delay_samples,
                quantum_m: condition.quantum,
                methods: NAMES.into_iter().enumerate().map(of).collect(),
            });
        }
    }
    Ok(WorldSuiteReport {
        format: FORMAT,
        set: set.name(),
        seed,
        worlds,
        loops,
    })
}

/// Number of calls of `judged` in [`run`].
#[must_use]
pub fn steps(set: WorldSet, worlds: usize) -> usize {
    worlds * PERIODS.len() * set.conditions().len()
}

/// E of what is compared on one world `[%]`.
fn errors(
    world: &RandomWorld,
    period: f64,
    Condition {
        delay_samples,
        quantum,
    }: Condition,
) -> Result<[f64; NAMES.len()], WorldBenchError> {
    let mut scene = world.scene.clone();
    for device in &mut scene.devices {
        device.quantum = [quantum; 3];
    }
    let rendered = as_rendered(&scene);
    let devices = scene.devices.len();
    let scene_masses = scene.devices[0].mass;
    let delay_s = delay_samples as f64 * period;
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
    let masses = scene_masses.map(f64::ln);
    let scale = Scale {
        stiffness: world.stiffness,
        period,
        mass: (masses.iter().sum::<f64>() / 3.0).exp(),
        gyration: None,
    };
    let setting = |settings: &WorldSettings, name: &str| {
        let method = settings.method(name, devices, false);
        let method = method.map_err(|fault| WorldBenchError::Rendering(vec![fault]))?;
        method.map_or(Ok(f64::NAN), &error)
    };
    let mut errors = [0.0; NAMES.len()];
    errors[0] = setting(&WorldSettings::default(), "basic")?;
    for (best, tunable) in errors[1..].iter_mut().zip(Tunable::ALL) {
        *best = f64::INFINITY;
        for settings in tunable.candidates(scale) {
            *best = best.min(setting(&settings, tunable.name())?);
        }
    }
    let told = CoupledParams::new(vec![world.told_mass; devices]).with_encoder_quantum(quantum);
    errors[NAMES.len() - 1] = error(told.into())?;
    Ok(errors)
}

impl fmt::Display for WorldSuiteReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let set = WorldSet::ALL.into_iter().find(|set| set.name() == self.set);
        let drawn = format!(
            "{} for each period, seed {}: {}. A loop is its period, its delay in samples, which every renderer is \
             told, and the quantum of its sensors. E in percent, median / 90 % / largest",
            counted(self.worlds, "random world"),
            self.seed,
            set.map_or("", WorldSet::drawn),
        );
        writeln!(f, "{}\n", wrapped(&drawn))?;
        let mut header = vec!["loop"];
        header.extend(NAMES);
        let mut table = plain_table(CellAlignment::Left, &header);
        for one in &self.loops {
            let cell = |text: String| Cell::new(text).set_alignment(CellAlignment::Right);
            let mut row = vec![Cell::new(format!(
                "{} ms, {}, {} um",
                1e3 * one.period_s,
                one.delay_samples,
                1e6 * one.quantum_m
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
        let best = "Best: with the setting of the least E of each world, of 15 to 24, found with knowledge of its ideal.";
        writeln!(f, "{}", legend(&[E, best]))
    }
}
