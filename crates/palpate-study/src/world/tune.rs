//! Tuning on a world: dependence of a method's error and leak on its damping and its coupling.
//!
//! Every setting is evaluated on this scene against the ideal, which a renderer does not have. The best setting may
//! be poor for another start or another mass.

use std::fmt;

use crate::sim::world::{WorldBench, WorldBenchError, WorldRun};
use comfy_table::{Cell, CellAlignment};
use palpate_scene::world::{WorldScene, WorldSettings};
use palpate_world::{Tool, WorldRenderer};
use rayon::prelude::*;
use serde::Serialize;

use super::candidates::{Scale, Tunable};
use super::setting::SettingReport;
use crate::sweep::table::text;
use crate::text::{
    E, FRE, counted, digits, legend, number, percent, plain_table, short, whole, wrapped,
};
use crate::tune::Objective;

/// Name and version of the JSON report.
const FORMAT: &str = "palpate world-tune 1";

/// E without any force `[%]`, approximately: a setting with a larger E is worse than no force.
pub const NO_FORCE_PERCENT: f64 = 100.0;

/// A setting and its results.
#[derive(Clone, Debug)]
pub struct Tuned {
    /// The setting.
    pub settings: WorldSettings,
    /// Run of the method with the setting.
    pub run: WorldRun,
}

impl Tuned {
    /// Returns E over all devices and axes `[%]`, infinite if the loop diverged; `None` if the ideal touches no tool.
    #[must_use]
    pub fn error(&self) -> Option<f64> {
        let sum = self.run.evaluation.sum.as_ref();
        sum.map(|sum| sum.mean_force_error)
            .map(|error| if error.is_nan() { f64::INFINITY } else { error })
    }

    /// Whether the renderer rejects no sample and E is below [`NO_FORCE_PERCENT`], the value of no force. Such a loop
    /// does not diverge.
    #[must_use]
    pub fn is_usable(&self) -> bool {
        let error = self.error();
        self.run.refused == 0 && error.is_none_or(|error| error < NO_FORCE_PERCENT)
    }

    fn leak(&self) -> f64 {
        self.run.created()
    }

    fn to_make_small(&self, objective: Objective) -> f64 {
        match objective {
            Objective::Error => self.error().unwrap_or(f64::INFINITY),
            Objective::Leak => self.leak().abs(),
        }
    }
}

/// Evaluates a method with each of these settings, in order. Calls `done` after each.
///
/// # Errors
/// The world cannot be rendered with a setting, for example because the method does not support the shape of a tool.
pub fn tune(
    scene: &WorldScene,
    bench: &WorldBench,
    tunable: Tunable,
    settings: &[WorldSettings],
    done: impl Fn() + Sync,
) -> Result<Vec<Tuned>, WorldBenchError> {
    let feels_torque = scene.world.tools.iter().any(Tool::feels_torque);
    let one = |settings: &WorldSettings| {
        let method = settings.method(tunable.name(), scene.devices.len(), feels_torque);
        let method = method.map_err(|fault| WorldBenchError::Rendering(fault.into()))?;
        let method = method.expect("a method that has something to tune has a name");
        let renderer = WorldRenderer::new(&scene.world, scene.loop_params(), method)?;
        let run = bench.run(tunable.name(), &renderer)?;
        done();
        Ok(Tuned {
            settings: *settings,
            run,
        })
    };
    settings.par_iter().map(one).collect()
}

/// Evaluates a method with its [`candidates`](Tunable::candidates) and, if none of them is usable, with [softer
/// couplings](Tunable::softer). Calls `done` after each.
///
/// # Errors
/// As [`tune`].
pub fn search(
    scene: &WorldScene,
    bench: &WorldBench,
    tunable: Tunable,
    done: impl Fn() + Sync,
) -> Result<Vec<Tuned>, WorldBenchError> {
    let scale = Scale::new(scene);
    let mut tuned = tune(scene, bench, tunable, &tunable.candidates(scale), &done)?;
    if !tuned.iter().any(Tuned::is_usable) {
        tuned.extend(tune(scene, bench, tunable, &tunable.softer(scale), &done)?);
    }
    Ok(tuned)
}

/// Returns the result with the lowest error or leak. A setting with more rejected samples ranks below a setting with
/// fewer, because a rejected sample has no force and hence no leak.
#[must_use]
pub fn best(tuned: &[Tuned], objective: Objective) -> Option<&Tuned> {
    tuned.iter().min_by(|one, other| {
        let [least, next] = [one, other].map(|it| it.to_make_small(objective));
        let fewer = one.run.refused.cmp(&other.run.refused);
        fewer.then(least.total_cmp(&next))
    })
}

/// Dependence of a method on its settings on a world.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct WorldTuneReport {
    /// Name and version of this JSON.
    #[cfg_attr(any(test, feature = "schema"), schemars(extend("const" = FORMAT)))]
    pub format: &'static str,
    /// Title of the scene.
    pub title: String,
    /// Name of the method.
    pub method: &'static str,
    /// Minimised quantity: `error` or `leak`.
    pub least: &'static str,
    /// Sampling period.
    pub period_s: f64,
    /// Zero-order-hold bound: minimum FRE of any held force; none if the ideal touches no tool.
    pub hold_bound_percent: Option<f64>,
    /// Mean-force error between the ideal and the ideal with coarser steps.
    pub ideal_error_percent: Option<f64>,
    /// Whether a setting is usable: the renderer rejects no sample, and E is below that of no force, 100 %.
    pub found: bool,
    /// The chosen setting; the least bad one if none is usable.
    pub best: WorldPointReport,
    /// Every setting that was tried.
    pub curve: Vec<WorldPointReport>,
    /// Files that were written.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<String>,
}

/// A setting and its results.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct WorldPointReport {
    /// The setting, under the keys of scene files.
    pub settings: SettingReport,
    /// E over all devices and axes; `null` if the loop diverged.
    pub mean_force_error_percent: Option<f64>,
    /// FRE over all devices and axes.
    pub force_rendering_error_percent: Option<f64>,
    /// Generated energy of the held forces: the total energy gain of hands, bodies, contacts and dissipation.
    pub leak_j: f64,
    /// Number of samples that the renderer rejected.
    pub refused_samples: usize,
}

impl WorldPointReport {
    pub(crate) fn new(tuned: &Tuned) -> Self {
        let sum = tuned.run.evaluation.sum.as_ref();
        Self {
            settings: (&tuned.settings).into(),
            mean_force_error_percent: sum.map(|sum| sum.mean_force_error),
            force_rendering_error_percent: sum.map(|sum| sum.force_rendering_error),
            leak_j: tuned.leak(),
            refused_samples: tuned.run.refused,
        }
    }
}

/// Columns of the tried settings as CSV.
pub const COLUMNS: [&str; 8] = [
    "method",
    "damping_n_s_per_m",
    "coupling_stiffness_n_per_m",
    "coupling_mass_kg",
    "mean_force_error_percent",
    "force_rendering_error_percent",
    "leak_j",
    "refused_samples",
];

impl WorldTuneReport {
    /// Returns a row for each tried setting, in the order of [`COLUMNS`]; missing values are empty.
    pub fn rows(&self) -> impl Iterator<Item = [String; COLUMNS.len()]> + '_ {
        self.curve.iter().map(|point| {
            [
                self.method.into(),
                text(point.settings.damping_n_s_per_m),
                text(point.settings.coupling_stiffness_n_per_m),
                text(point.settings.coupling_mass_kg),
                text(point.mean_force_error_percent),
                text(point.force_rendering_error_percent),
                point.leak_j.to_string(),
                point.refused_samples.to_string(),
            ]
        })
    }

    /// Creates the report of the tried settings; `None` if there are none.
    #[must_use]
    pub fn new(
        scene: &WorldScene,
        bench: &WorldBench,
        tunable: Tunable,
        objective: Objective,
        tuned: &[Tuned],
    ) -> Option<Self> {
        let best = best(tuned, objective)?;
        let sum = best.run.evaluation.sum.as_ref();
        Some(Self {
            format: FORMAT,
            title: scene.title.clone(),
            method: tunable.name(),
            least: objective.name(),
            period_s: scene.timing.period,
            hold_bound_percent: sum.map(|sum| sum.hold_bound),
            ideal_error_percent: bench.self_check().map(|check| check.error),
            found: best.is_usable(),
            best: WorldPointReport::new(best),
            curve: tuned.iter().map(WorldPointReport::new).collect(),
            files: Vec::new(),
        })
    }

    /// Whether the best setting has the largest tried damping of its coupling, so that a larger one may be better.
    #[must_use]
    pub fn has_largest_damping(&self) -> bool {
        let damping = |point: &WorldPointReport| point.settings.damping_n_s_per_m;
        let coupling = |point: &WorldPointReport| {
            let setting = &point.settings;
            (setting.coupling_stiffness_n_per_m, setting.coupling_mass_kg)
        };
        let same = (self.curve.iter()).filter(|point| coupling(point) == coupling(&self.best));
        let most = same.filter_map(damping).fold(f64::NEG_INFINITY, f64::max);
        damping(&self.best).is_some_and(|best| best >= most)
    }
}

/// Maximum number of rows of a table; of more settings it shows only the best.
const MAX_ROWS: usize = 26;

impl fmt::Display for WorldTuneReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", wrapped(&self.title))?;
        let floor = self.hold_bound_percent.map_or_else(String::new, |floor| {
            format!(", hold bound {} %", percent(floor))
        });
        writeln!(
            f,
            "{}: {} settings, period {} s{floor}\n",
            self.method,
            self.curve.len(),
            digits(self.period_s)
        )?;
        let mut header = vec!["", "B N s/m", "k N/m", "m kg", "E %", "FRE %", "leak mJ"];
        let are_refused = self.curve.iter().any(|point| point.refused_samples > 0);
        if are_refused {
            header.push("refused");
        }
        let mut table = plain_table(CellAlignment::Left, &header);
        let is_best = |point: &WorldPointReport| std::ptr::eq(point, &self.best);
        let shown: Vec<&WorldPointReport> = if self.curve.len() <= MAX_ROWS {
            self.curve.iter().chain([&self.best]).collect()
        } else {
            vec![&self.best]
        };
        for point in shown {
            let setting = &point.settings;
            let mut row = vec![Cell::new(if is_best(point) { "best" } else { "" })];
            let values = [
                setting.damping_n_s_per_m,
                setting.coupling_stiffness_n_per_m,
                setting.coupling_mass_kg,
            ];
            row.extend(values.map(|value| number(value, digits)));
            row.push(number(point.mean_force_error_percent, percent));
            row.push(number(point.force_rendering_error_percent, percent));
            row.push(number(Some(1e3 * point.leak_j), |leak| short(leak, 3)));
            if are_refused {
                row.push(Cell::new(point.refused_samples).set_alignment(CellAlignment::Right));
            }
            table.add_row(row);
        }
        writeln!(f, "{}\n", whole(&table))?;
        if self.best.refused_samples > 0 {
            let words = format!(
                "The renderer refuses samples with every setting, with the best one {}; its force is 0 there.",
                counted(self.best.refused_samples as u64, "sample")
            );
            writeln!(f, "{}", wrapped(&words))?;
        }
        if !self.found {
            writeln!(f, "{}", wrapped(&none_found(self.curve.len(), &self.best)))?;
            return self.end(f);
        }
        let end = match self.best.settings.coupling_stiffness_n_per_m {
            _ if !self.has_largest_damping() => "",
            None => " It has the largest damping that was tried; a larger one may be better.",
            Some(_) => {
                " It has the largest damping that was tried with its coupling; a larger one may be better."
            }
        };
        let best = format!(
            "Best: least {}, selected with knowledge of the ideal, on this scene only.{end} In [methods.{}] of the scene:",
            self.least, self.method
        );
        writeln!(f, "{}", wrapped(&best))?;
        for (key, value) in self.best.settings.values() {
            writeln!(f, "  {key} = {value}")?;
        }
        self.end(f)
    }
}

impl WorldTuneReport {
    fn end(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", legend(&[E, FRE]))?;
        for file in &self.files {
            writeln!(f, "wrote {file}")?;
        }
        Ok(())
    }
}

/// Returns the reason why no setting is usable, with the least bad one.
pub(crate) fn none_found(count: usize, best: &WorldPointReport) -> String {
    let least = match (best.refused_samples, best.mean_force_error_percent) {
        (0, Some(error)) => format!("the least E is {} %", percent(error)),
        (0, None) => "all diverged".into(),
        (refused, _) => format!(
            "the renderer refuses samples with every setting, at least {}",
            counted(refused, "sample")
        ),
    };
    format!(
        "no setting found: none of the {count} tried is nearer to the ideal than zero force, E {NO_FORCE_PERCENT} %; \
         {least}, with {}",
        best.settings.in_short()
    )
}
