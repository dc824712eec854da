//! Comparison of many worlds and methods in one table.

use std::fmt;

use crate::sim::world::{WorldBench, WorldBenchError, WorldRun};
use comfy_table::{Cell, CellAlignment};
use palpate_scene::world::WorldScene;
use serde::Serialize;

use super::candidates::Tunable;
use super::setting::SettingReport;
use super::tune::{WorldPointReport, best, none_found, search};
use super::{WorldMethodReport, WorldReport};
use crate::seeded::Seeded;
use crate::text::{E, FRE, digits, legend, percent, plain_table, short, whole, within, wrapped};
use crate::tune::Objective;

/// Name and version of the JSON report.
const FORMAT: &str = "palpate world-compare 1";

/// Columns of the table as CSV.
pub const COLUMNS: [&str; 16] = [
    "scene",
    "title",
    "method",
    "tuned",
    "period_s",
    "hold_bound_percent",
    "mean_force_error_percent",
    "force_rendering_error_percent",
    "error_over_bound",
    "peak_over_ideal",
    "leak_j",
    "refused_samples",
    "damping_n_s_per_m",
    "coupling_stiffness_n_per_m",
    "coupling_mass_kg",
    "cannot",
];

/// Comparison of worlds, in the order given.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct WorldComparison {
    /// Name and version of this JSON.
    #[cfg_attr(any(test, feature = "schema"), schemars(extend("const" = FORMAT)))]
    pub format: &'static str,
    /// One entry for each world, in the order given.
    pub scenes: Vec<WorldRows>,
    /// Files that were written.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<String>,
}

/// One world with its methods.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
pub struct WorldRows {
    /// File of the scene.
    pub scene: String,
    /// The scene's title.
    pub title: String,
    /// Sampling period.
    pub period_s: f64,
    /// Length of the evaluated window.
    pub window_s: f64,
    /// Zero-order-hold bound: minimum FRE of any held force; none if the ideal touches no tool.
    pub hold_bound_percent: Option<f64>,
    /// Mean-force error between the ideal and the ideal with coarser steps.
    pub ideal_error_percent: Option<f64>,
    /// One entry for each method.
    pub methods: Vec<WorldRow>,
    /// Means over several seeds with their intervals, and differences of the methods.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seeded: Option<Seeded>,
}

/// A method on a world.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct WorldRow {
    /// Name of the method.
    pub method: &'static str,
    /// Result of the method, or the reason why it cannot be set up.
    #[serde(flatten)]
    pub result: WorldOutcome,
}

/// Result of a method on a world, or the reason for its absence.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum WorldOutcome {
    /// The method ran.
    Ran(Box<WorldFigures>),
    /// The method cannot be set up.
    Cannot {
        /// Reason.
        cannot: String,
    },
    /// None of the tried settings is usable.
    NoneFound {
        /// Description of the least bad setting.
        none_found: String,
    },
}

/// Results of a method on a world.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct WorldFigures {
    /// Number of tried settings; the shown one has the lowest E, selected with knowledge of the ideal. None if the
    /// scene states the settings or there are none.
    pub tuned: Option<usize>,
    /// Settings of the method, under the keys of scene files.
    pub settings: SettingReport,
    /// Mean-force error E over all devices and axes; none without contact.
    pub mean_force_error_percent: Option<f64>,
    /// FRE over all devices and axes; none without contact.
    pub force_rendering_error_percent: Option<f64>,
    /// FRE over the zero-order-hold bound; none if the bound is 0.
    pub error_over_bound: Option<f64>,
    /// Largest peak force of a device over that of the ideal.
    pub peak_over_ideal: Option<f64>,
    /// Generated energy of the held forces: the total energy gain of hands, bodies, contacts and dissipation.
    pub leak_j: f64,
    /// Number of samples that the renderer rejected.
    pub refused_samples: usize,
}

impl WorldFigures {
    fn new(report: &WorldMethodReport, tuned: Option<usize>, settings: SettingReport) -> Self {
        let peaks = report
            .devices
            .iter()
            .filter_map(|it| it.peak_over_ideal_peak);
        Self {
            tuned,
            settings,
            mean_force_error_percent: report.sum.map(|sum| sum.mean_force_error_percent),
            force_rendering_error_percent: report.sum.map(|sum| sum.force_rendering_error_percent),
            error_over_bound: report.sum.and_then(|sum| sum.error_over_bound),
            peak_over_ideal: peaks.reduce(f64::max),
            leak_j: report.leak_j,
            refused_samples: report.refused_samples,
        }
    }

    /// Whether every sample was rendered and the error is a number.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.refused_samples == 0
            && self
                .mean_force_error_percent
                .is_none_or(|error| error.is_finite())
    }
}

impl WorldRows {
    /// Runs the methods of these names on a world. A tunable method without settings in the scene uses the best of
    /// [`Tunable::candidates`]. Calls `begun` with the name of each method before it runs.
    ///
    /// # Errors
    /// The scene has no ideal.
    pub fn of(
        name: &str,
        scene: &WorldScene,
        methods: &[&'static str],
        mut begun: impl FnMut(&'static str),
    ) -> Result<Self, WorldBenchError> {
        let bench = WorldBench::new(scene)?;
        let mut rows = Vec::new();
        let mut hold_bound_percent = None;
        for &method in methods {
            begun(method);
            let result = match row(scene, &bench, method) {
                Ok((outcome, floor)) => {
                    hold_bound_percent = floor.or(hold_bound_percent);
                    outcome
                }
                Err(WorldBenchError::Rendering(faults)) => WorldOutcome::Cannot {
                    cannot: faults
                        .iter()
                        .map(|fault| fault.message.as_str())
                        .collect::<Vec<_>>()
                        .join("; "),
                },
                Err(other) => return Err(other),
            };
            rows.push(WorldRow { method, result });
        }
        let report = WorldReport::new(scene, &bench, &[]);
        Ok(Self {
            scene: name.to_owned(),
            title: report.title,
            period_s: report.period_s,
            window_s: report.window_s,
            hold_bound_percent,
            ideal_error_percent: report.ideal_error_percent,
            methods: rows,
            seeded: None,
        })
    }

    /// Returns the lowest error of a method whose run stayed bounded.
    fn least(&self) -> Option<f64> {
        let errors = self.methods.iter().filter_map(|row| match &row.result {
            WorldOutcome::Ran(run) if run.is_whole() => run.mean_force_error_percent,
            _ => None,
        });
        errors.min_by(f64::total_cmp)
    }

    fn row(&self, method: &WorldRow) -> [String; COLUMNS.len()] {
        let text = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
        let mut row: [String; COLUMNS.len()] = Default::default();
        row[0].clone_from(&self.scene);
        row[1].clone_from(&self.title);
        row[2] = method.method.into();
        row[4] = self.period_s.to_string();
        row[5] = text(self.hold_bound_percent);
        match &method.result {
            WorldOutcome::Ran(run) => {
                row[3] = run.tuned.map_or_else(String::new, |it| it.to_string());
                row[6] = text(run.mean_force_error_percent);
                row[7] = text(run.force_rendering_error_percent);
                row[8] = text(run.error_over_bound);
                row[9] = text(run.peak_over_ideal);
                row[10] = run.leak_j.to_string();
                row[11] = run.refused_samples.to_string();
                row[12] = text(run.settings.damping_n_s_per_m);
                row[13] = text(run.settings.coupling_stiffness_n_per_m);
                row[14] = text(run.settings.coupling_mass_kg);
            }
            WorldOutcome::Cannot { cannot: why } | WorldOutcome::NoneFound { none_found: why } => {
                row[15].clone_from(why);
            }
        }
        row
    }
}

/// Result of a method, or that no setting is usable, and the zero-order-hold bound `[%]`.
fn row(
    scene: &WorldScene,
    bench: &WorldBench,
    method: &'static str,
) -> Result<(WorldOutcome, Option<f64>), WorldBenchError> {
    let figures = |run: &WorldRun, tuned, settings| {
        let report = WorldReport::new(scene, bench, std::slice::from_ref(run));
        let floor = run.evaluation.sum.as_ref().map(|sum| sum.hold_bound);
        let figures = WorldFigures::new(&report.methods[0], tuned, settings);
        (WorldOutcome::Ran(Box::new(figures)), floor)
    };
    if let (Some(tunable), Err(_)) = (Tunable::named(method), scene.method(method)) {
        let tuned = search(scene, bench, tunable, || ())?;
        let best = best(&tuned, Objective::Error).expect("some setting was tried");
        if !best.is_usable() {
            let none_found = none_found(tuned.len(), &WorldPointReport::new(best));
            return Ok((WorldOutcome::NoneFound { none_found }, None));
        }
        let settings = (&best.settings).into();
        return Ok(figures(&best.run, Some(tuned.len()), settings));
    }
    let renderer = scene.renderer(method)?;
    let run = bench.run(method, &renderer)?;
    let settings = match Tunable::named(method) {
        Some(tunable) => tunable.of_settings(&scene.settings(method)),
        None => Default::default(),
    };
    Ok(figures(&run, None, (&settings).into()))
}

impl WorldComparison {
    /// Creates the comparison of these worlds.
    #[must_use]
    pub fn new(scenes: Vec<WorldRows>) -> Self {
        Self {
            format: FORMAT,
            scenes,
            files: Vec::new(),
        }
    }

    /// Adds a written file.
    pub fn wrote(&mut self, path: &std::path::Path) {
        self.files.push(path.display().to_string());
    }

    /// Returns the rows of the table in the order of [`COLUMNS`]; missing values are empty.
    pub fn rows(&self) -> impl Iterator<Item = [String; COLUMNS.len()]> + '_ {
        let of = |scene: &'_ WorldRows| {
            let rows: Vec<_> = scene
                .methods
                .iter()
                .map(|method| scene.row(method))
                .collect();
            rows
        };
        self.scenes.iter().flat_map(of)
    }
}

/// Markers before the name of a method that did not stay bounded, and of the method with the lowest error.
const BROKEN: &str = "!";
const LEAST: &str = "*";

impl fmt::Display for WorldComparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let header = [
            "",
            "method",
            "E %",
            "FRE %",
            "FRE/bound",
            "peak/ideal",
            "leak mJ",
        ];
        let mut table = plain_table(CellAlignment::Left, &header);
        for scene in &self.scenes {
            let least = scene.least();
            for method in &scene.methods {
                let (mark, cells) = match &method.result {
                    WorldOutcome::Cannot { .. } | WorldOutcome::NoneFound { .. } => {
                        ("-", [const { None }; 5])
                    }
                    WorldOutcome::Ran(run) => {
                        let mark = if !run.is_whole() {
                            BROKEN
                        } else if least.is_some() && run.mean_force_error_percent == least {
                            LEAST
                        } else {
                            ""
                        };
                        let cells = [
                            run.mean_force_error_percent.map(percent),
                            run.force_rendering_error_percent.map(percent),
                            run.error_over_bound.map(digits),
                            run.peak_over_ideal.map(digits),
                            Some(short(1e3 * run.leak_j, 3)),
                        ];
                        (mark, cells)
                    }
                };
                let mut row = vec![Cell::new(mark), Cell::new(method.method)];
                row.extend(cells.into_iter().map(|cell| {
                    Cell::new(cell.unwrap_or_else(|| "-".into()))
                        .set_alignment(CellAlignment::Right)
                }));
                table.add_row(row);
            }
        }
        let text = whole(&table);
        let mut text = text.lines();
        for line in text.by_ref().take(2) {
            writeln!(f, "{line}")?;
        }
        for scene in &self.scenes {
            writeln!(f, "\n{}\n  {}", wrapped(&scene.title), scene.conditions())?;
            for (line, method) in text.by_ref().take(scene.methods.len()).zip(&scene.methods) {
                writeln!(f, "{line}")?;
                let below = match &method.result {
                    WorldOutcome::Cannot { cannot } => format!("cannot be set up: {cannot}"),
                    WorldOutcome::NoneFound { none_found } => none_found.clone(),
                    WorldOutcome::Ran(run) => match run.tuned {
                        Some(count) => format!("best of {count}: {}", run.settings.in_short()),
                        None => run.settings.in_short(),
                    },
                };
                if below.is_empty() {
                    continue;
                }
                for line in within(&below, crate::text::WIDTH - BLANKS.len()) {
                    writeln!(f, "{BLANKS}{line}")?;
                }
            }
            if let Some(seeded) = &scene.seeded {
                write!(f, "\n{seeded}")?;
            }
        }
        let marks = format!(
            "{LEAST} least E, {BROKEN} refused samples or diverged. Best of N: the scene has no setting; of N tried \
             settings, the one with the least E was selected, with knowledge of the ideal."
        );
        writeln!(f, "\n{}", wrapped(&marks))?;
        writeln!(f, "{}", legend(&[E, FRE]))?;
        for file in &self.files {
            writeln!(f, "wrote {file}")?;
        }
        Ok(())
    }
}

/// Indentation of the lines below a method.
const BLANKS: &str = "     ";

impl WorldRows {
    fn conditions(&self) -> String {
        let floor = number_or(self.hold_bound_percent, |floor| {
            format!(", hold bound {} %", percent(floor))
        });
        format!(
            "period {} s, window {} s{floor}",
            digits(self.period_s),
            digits(self.window_s)
        )
    }
}

fn number_or(value: Option<f64>, text: impl Fn(f64) -> String) -> String {
    value.map_or_else(String::new, text)
}
