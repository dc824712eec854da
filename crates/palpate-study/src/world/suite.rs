//! Evaluation of methods on random worlds.

use std::fmt;
use std::ops::Range;

use crate::sim::world::{WorldBench, WorldBenchError, as_rendered};
use comfy_table::{Cell, CellAlignment};
use palpate_scene::world::WorldSettings;
use palpate_testbed::schedule::{ActuationDelay, ScheduleParams};
use palpate_testbed::timeline::Timeline;
use palpate_testbed::world::random_worlds::{RandomHands, RandomWorld, random_worlds};
use palpate_world::{CoupledParams, WorldLoop, WorldMethod, WorldRenderer};
use rayon::prelude::*;
use serde::Serialize;

use super::candidates::{Scale, Tunable};
use super::tune::NO_FORCE_PERCENT;
use crate::spread::Spread;
use crate::text::{E, counted, legend, lines, plain_table, short, wrapped};

/// Name and version of the JSON report.
const FORMAT: &str = "palpate world-suite 2";

/// Periods of the loops `[s]`.
const PERIODS: [f64; 3] = [0.001, 0.004, 0.01];
/// Quantum of the sensors of desktop devices `[m]`.
const QUANTUM: f64 = 2e-6;

/// A family of random worlds, and the loops of their evaluation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WorldSet {
    /// Tools in a hand, with and without a delay of one sample.
    Hand,
    /// Tools pushed by a constant force, with ideal and quantised sensors.
    Free,
}

/// Parameters of a loop except its period.
#[derive(Clone, Copy, Debug)]
struct Condition {
    delay_samples: usize,
    /// Quantum of the sensors `[m]`.
    quantum: f64,
}

impl WorldSet {
    /// All sets.
    pub const ALL: [Self; 2] = [Self::Hand, Self::Free];

    /// Returns the name on the command line.
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

    /// Describes the random worlds of the set.
    fn drawn(self) -> &'static str {
        match self {
            Self::Hand => {
                "a sphere tool in a hand of 60 or 300 N/m with tremor, unequal masses along the axes, model mass 1.5 \
                 or 0.67 times the true one"
            }
            Self::Free => {
                "a sphere tool that a constant force pushes, without a hand, unequal masses along the axes, model \
                 mass 1.5 times the true one"
            }
        }
    }
}

/// Results of methods on random worlds.
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
    /// Number of consecutive seeds, if there are several: the quantiles are then those of all worlds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seeds: Option<usize>,
    /// Number of worlds per period and seed.
    pub worlds: usize,
    /// One entry for each loop.
    pub loops: Vec<LoopReport>,
}

/// Results of methods on random worlds in one loop.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct LoopReport {
    /// Sampling period.
    pub period_s: f64,
    /// Delay, included in every renderer's model.
    pub delay_samples: usize,
    /// Quantum of every sensor, included in the model of `coupled`.
    pub quantum_m: f64,
    /// One entry for each method.
    pub methods: Vec<MethodErrors>,
}

/// Mean-force errors of a method.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct MethodErrors {
    /// Name; "best" entries use the setting with the lowest error on each world, selected with knowledge of the
    /// ideal.
    pub name: &'static str,
    /// Median of E.
    pub median_percent: f64,
    /// 90 % quantile of E.
    pub quantile_90_percent: f64,
    /// The largest E.
    pub largest_percent: f64,
    /// Number of worlds in which no setting of the method has an E below that of no force, 100 %; the least bad one
    /// counts. None for methods without settings.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub none_found: Option<usize>,
    /// Spread of the quantiles of each seed over the seeds, if there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub over_seeds: Option<ErrorsOverSeeds>,
}

/// Spread of the quantiles of each seed's worlds over the seeds.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ErrorsOverSeeds {
    /// Median of E.
    pub median_percent: Spread,
    /// 90 % quantile of E.
    pub quantile_90_percent: Spread,
    /// Largest E.
    pub largest_percent: Spread,
}

/// Median, 90 % and largest E of a method on the worlds of a seed.
type Quantiles = [f64; 3];

/// Returns the quantiles of a non-empty set of errors.
fn quantiles(errors: impl IntoIterator<Item = f64>) -> Quantiles {
    let mut sorted: Vec<f64> = errors.into_iter().collect();
    sorted.sort_by(f64::total_cmp);
    [50, 90, 100].map(|share| sorted[(sorted.len() * share / 100).min(sorted.len() - 1)])
}

impl MethodErrors {
    /// Creates the entry from the errors of the method at this index, on the worlds of each seed.
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
        let is_best = NAMES[place].starts_with("best");
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

/// Names of the compared methods.
const NAMES: [&str; 6] = [
    "basic",
    "hfcr",
    "best damper",
    "best virtual coupling",
    "best god-object",
    "coupled",
];

/// Draws `worlds` worlds of a set per period and seed and evaluates methods on them. Calls `evaluated` after each world
/// and loop.
///
/// # Errors
/// A world cannot be drawn or evaluated.
pub fn run(
    set: WorldSet,
    worlds: usize,
    seeds: Range<u64>,
    evaluated: impl Fn() + Sync,
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
                        evaluated();
                        errors
                    })
                    // A caller cancels the rest by a panic in `evaluated`.
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

/// Returns the number of calls of `evaluated` in [`run`] for one seed.
#[must_use]
pub fn steps(set: WorldSet, worlds: usize) -> usize {
    worlds * PERIODS.len() * set.conditions().len()
}

/// Returns E of the compared methods on one world `[%]`.
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
    let schedule = ScheduleParams {
        delay: ActuationDelay {
            samples: u32::try_from(delay_samples).unwrap_or(u32::MAX),
            ..ActuationDelay::default()
        },
        ..ScheduleParams::perfect(period)
    };
    let timeline = Timeline::new(schedule, world.ideal.grid.intervals());
    let timeline = timeline.map_err(WorldBenchError::of_loop)?;
    let bench = WorldBench::of(scene, timeline, world.ideal.clone());
    let loop_params = WorldLoop::new(period).with_actuation(palpate_core::Actuation {
        delay: delay_s,
        ..palpate_core::Actuation::default()
    });
    let error = |method: WorldMethod| -> Result<f64, WorldBenchError> {
        let renderer = WorldRenderer::new(&rendered, loop_params.clone(), method)?;
        let run = bench.run("", &renderer)?;
        let fidelity = run.evaluation.sum;
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
        let method = method.map_err(|fault| WorldBenchError::Rendering(fault.into()))?;
        method.map_or(Ok(f64::NAN), &error)
    };
    let mut errors = [0.0; NAMES.len()];
    errors[0] = setting(&WorldSettings::default(), "basic")?;
    errors[1] = setting(&WorldSettings::default(), "hfcr")?;
    for (best, tunable) in errors[2..].iter_mut().zip(Tunable::ALL) {
        *best = f64::INFINITY;
        for all in [tunable.candidates(scale), tunable.softer(scale)] {
            // Softer couplings are tried only if no other is nearer to the ideal than no force.
            if *best < NO_FORCE_PERCENT {
                break;
            }
            for settings in all {
                *best = best.min(setting(&settings, tunable.name())?);
            }
        }
    }
    let model = CoupledParams::new(vec![world.model_mass; devices]).with_encoder_quantum(quantum);
    errors[NAMES.len() - 1] = error(model.into())?;
    Ok(errors)
}

impl LoopReport {
    /// Returns period, delay in samples and quantum in short form.
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
            "{} for each period, {}: {}. A loop is its period, its delay in samples, which every renderer models, and \
             the quantum of its sensors. E in percent, median / 90 % / largest{}",
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
                    "{}: no setting found for the {name} in {} of {}: none has an E below that of zero force, \
                     {NO_FORCE_PERCENT} %; the least E counts.",
                    one.in_short(),
                    count,
                    counted(self.worlds * self.seeds.unwrap_or(1), "world"),
                );
                writeln!(f, "{}", wrapped(&line))?;
            }
        }
        let best = "Best: with the setting of the least E of each world, of 15 to 24 and, if none of them has an E \
                    below 100 %, softer couplings, selected with knowledge of its ideal.";
        writeln!(f, "{}", legend(&[E, best]))?;
        if self.seeds.is_none() {
            let one = "These are the worlds of one seed; --seeds 7 shows how the results vary from seed to seed.";
            writeln!(f, "\n{}", wrapped(one))?;
        }
        Ok(())
    }
}
