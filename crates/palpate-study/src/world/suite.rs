//! Methods on random worlds: how large the errors are where nobody has chosen the scene.

use std::fmt;
use std::ops::Range;

use comfy_table::{Cell, CellAlignment};
use palpate_scene::world::WorldSettings;
use palpate_sim::world::{WorldBench, WorldBenchError, as_rendered};
use palpate_testbed::world::PlantParams;
use palpate_testbed::world::random_worlds::{RandomHands, RandomWorld, random_worlds};
use palpate_world::{CoupledParams, WorldLoop, WorldMethod, WorldRenderer};
use rayon::prelude::*;
use serde::Serialize;

use super::candidates::{Scale, Tunable};
use super::tune::NO_FORCE_PERCENT;
use crate::suite::Spread;
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
    /// Seed of the draws, the first of several.
    pub seed: u64,
    /// Number of seeds, which follow each other, if there are several: the quantiles are then those of all worlds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seeds: Option<usize>,
    /// Worlds for each period and seed.
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
    /// Worlds in which no setting of the method has an E below that of no force, 100 %: the least bad one counts. None for
    /// methods without settings.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub none_found: Option<usize>,
    /// How the quantiles of each seed are spread over the seeds, if there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub over_seeds: Option<ErrorsOverSeeds>,
}

/// How the quantiles of each seed's worlds are spread over the seeds.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ErrorsOverSeeds {
    /// Median of E.
    pub median_percent: Spread,
    /// What nine tenths of E are below.
    pub quantile_90_percent: Spread,
    /// Largest E.
    pub largest_percent: Spread,
}

/// Median, 90 % and largest E of a method on the worlds of a seed.
type Quantiles = [f64; 3];

/// The quantiles of errors, of which there is one at least.
fn quantiles(errors: impl IntoIterator<Item = f64>) -> Quantiles {
    let mut sorted: Vec<f64> = errors.into_iter().collect();
    sorted.sort_by(f64::total_cmp);
    [50, 90, 100].map(|share| sorted[(sorted.len() * share / 100).min(sorted.len() - 1)])
}

impl MethodErrors {
    /// Of the errors of the method at this place, on the worlds of each seed.
    fn new(place: usize, of_seeds: &[Vec<[f64; NAMES.len()]>]) -> Self {
        let errors = || of_seeds.iter().flatten().map(|errors| errors[place]);
        let [median_percent, quantile_90_percent, largest_percent] = quantiles(errors());
        let of_each: Vec<Quantiles> = of_seeds
            .iter()
            .map(|errors| quantiles(errors.iter().map(|errors| errors[place])))
            .collect();
        let spread = |quantile: usize| Spread::new(of_each.iter().map(|of| of[quantile]));
        let over_seeds = || {
            Some(ErrorsOverSeeds {
                median_percent: spread(0)?,
                quantile_90_percent: spread(1)?,
                largest_percent: spread(2)?,
            })
        };
        let is_best = place > 0 && place < NAMES.len() - 1;
        let not_found = |error: &f64| error.is_nan() || *error >= NO_FORCE_PERCENT;
        Self {
            name: NAMES[place],
            median_percent,
            quantile_90_percent,
            largest_percent,
            none_found: is_best.then(|| errors().filter(not_found).count()),
            over_seeds: (of_seeds.len() > 1).then(over_seeds).flatten(),
        }
    }
}

/// Names of what is compared.
const NAMES: [&str; 5] = [
    "basic",
    "best damper",
    "best virtual coupling",
    "best god-object",
    "coupled",
];

/// Draws so many worlds of a set for each period and seed and judges methods on them. `judged` is called for each world
/// and loop.
///
/// # Errors
/// A world that cannot be drawn or judged.
pub fn run(
    set: WorldSet,
    worlds: usize,
    seeds: Range<u64>,
    judged: impl Fn() + Sync,
) -> Result<WorldSuiteReport, WorldBenchError> {
    let mut loops = Vec::new();
    for period in PERIODS {
        let drawn = (seeds.clone())
            .map(|seed| random_worlds(set.hands(), worlds, period, seed))
            .collect::<Result<Vec<_>, _>>()?;
        for condition in set.conditions() {
            let of_seed = |drawn: &Vec<RandomWorld>| {
                drawn
                    .par_iter()
                    .map(|world| {
                        let errors = errors(world, period, condition);
                        judged();
                        errors
                    })
                    // A caller that wants to stop lets `judged` panic.
                    .panic_fuse()
                    .collect::<Result<Vec<_>, _>>()
            };
            let of_seeds = drawn.iter().map(of_seed).collect::<Result<Vec<_>, _>>()?;
            let methods = (0..NAMES.len()).map(|place| MethodErrors::new(place, &of_seeds));
            loops.push(LoopReport {
                period_s: period,
                delay_samples: condition.delay_samples,
                quantum_m: condition.quantum,
                methods: methods.collect(),
            });
        }
    }
    let count = seeds.clone().count();
    Ok(WorldSuiteReport {
        format: FORMAT,
        set: set.name(),
        seed: seeds.start,
        seeds: (count > 1).then_some(count),
        worlds,
        loops,
    })
}

/// Number of calls of `judged` in [`run`] for one seed.
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
        for all in [tunable.candidates(scale), tunable.softer(scale)] {
            // Softer couplings only if no other comes nearer to the ideal than no force.
            if *best < NO_FORCE_PERCENT {
                break;
            }
            for settings in all {
                *best = best.min(setting(&settings, tunable.name())?);
            }
        }
    }
    let told = CoupledParams::new(vec![world.told_mass; devices]).with_encoder_quantum(quantum);
    errors[NAMES.len() - 1] = error(told.into())?;
    Ok(errors)
}

impl LoopReport {
    /// Period, delay in samples, quantum.
    fn in_short(&self) -> String {
        format!(
            "{} ms, {}, {} um",
            1e3 * self.period_s,
            self.delay_samples,
            1e6 * self.quantum_m
        )
    }
}

impl fmt::Display for WorldSuiteReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let set = WorldSet::ALL.into_iter().find(|set| set.name() == self.set);
        let drawn = format!(
            "{} for each period, {}: {}. A loop is its period, its delay in samples, which every renderer is \
             told, and the quantum of its sensors. E in percent, median / 90 % / largest{}",
            counted(self.worlds, "random world"),
            match self.seeds {
                None => format!("seed {}", self.seed),
                Some(seeds) => format!(
                    "of each of the seeds {} to {}",
                    self.seed,
                    self.seed + seeds as u64 - 1
                ),
            },
            set.map_or("", WorldSet::drawn),
            if self.seeds.is_some() {
                ", each as the median over the seeds (least-largest of a seed)"
            } else {
                ""
            },
        );
        writeln!(f, "{}\n", wrapped(&drawn))?;
        let mut header = vec!["loop"];
        header.extend(NAMES);
        let mut table = plain_table(CellAlignment::Left, &header);
        for one in &self.loops {
            let cell = |text: String| Cell::new(text).set_alignment(CellAlignment::Right);
            let mut row = vec![Cell::new(one.in_short())];
            row.extend(one.methods.iter().map(|method| {
                let parts = match method.over_seeds {
                    None => [
                        method.median_percent,
                        method.quantile_90_percent,
                        method.largest_percent,
                    ]
                    .map(|error| short(error, 1)),
                    Some(over) => [
                        over.median_percent,
                        over.quantile_90_percent,
                        over.largest_percent,
                    ]
                    .map(|spread| spread.in_short(1)),
                };
                cell(parts.join(" / "))
            }));
            table.add_row(row);
        }
        writeln!(f, "{}\n", lines(&table))?;
        for one in &self.loops {
            let missing = (one.methods.iter())
                .filter_map(|method| Some((method.name, method.none_found.filter(|n| *n > 0)?)));
            for (name, count) in missing {
                let line = format!(
                    "{}: no setting found for the {name} in {} of {}: none has an E below that of no force, {NO_FORCE_PERCENT} %; \
                     the least counts.",
                    one.in_short(),
                    count,
                    counted(self.worlds * self.seeds.unwrap_or(1), "world"),
                );
                writeln!(f, "{}", wrapped(&line))?;
            }
        }
        let best = "Best: with the setting of the least E of each world, of 15 to 24 and, where none of them has an E \
                    below 100 %, softer couplings, found with knowledge of its ideal.";
        writeln!(f, "{}", legend(&[E, best]))?;
        if self.seeds.is_none() {
            let one = "These are the worlds of one seed; --seeds 7 shows how the numbers vary from seed to seed.";
            writeln!(f, "\n{}", wrapped(one))?;
        }
        Ok(())
    }
}
