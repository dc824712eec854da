//! Comparison of many scenes and methods in one table.

mod text;
mod world;

use crate::map::bounds::least_explicit_mass;
use crate::sim::integrated::Integrator;
use crate::sim::run::{Reference, Run};
use palpate_scene::method::MethodName;
use serde::Serialize;
use serde_json::Value;

use crate::report::{MethodReport, Report, Subject};
use crate::seeded::Seeded;
use crate::world::SettingReport;

/// Name and version of the JSON report.
const FORMAT: &str = "palpate compare 1";

/// Columns of the table as CSV.
pub const COLUMNS: [&str; 21] = [
    "scene",
    "title",
    "method",
    "tuned",
    "period_s",
    "kappa",
    "hold_bound_percent",
    "mean_force_error_percent",
    "force_rendering_error_percent",
    "error_over_bound",
    "peak_over_ideal",
    "absolute_leak_held_j",
    "leak_j",
    "diverged",
    "left_box_at_s",
    "jammed_at_s",
    "refused_samples",
    "damping_n_s_per_m",
    "coupling_stiffness_n_per_m",
    "coupling_mass_kg",
    "cannot",
];

/// Comparison of scenes, in the order given.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Comparison {
    /// Name and version of this JSON.
    #[cfg_attr(any(test, feature = "schema"), schemars(extend("const" = FORMAT)))]
    pub format: &'static str,
    /// One entry for each scene, in the order given.
    pub scenes: Vec<SceneRows>,
    /// Files that were written.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<String>,
}

/// One scene with its methods.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
pub struct SceneRows {
    /// File of the scene.
    pub scene: String,
    /// The scene's title.
    pub title: String,
    /// Difficulty, loop and hold bound as one line, for a terminal.
    #[serde(skip)]
    conditions: String,
    /// Whether it is a world.
    #[serde(skip)]
    pub is_world: bool,
    /// Sampling period `[s]`.
    pub period_s: f64,
    /// Length of the evaluated window `[s]`.
    pub window_s: f64,
    /// K T²/m; none in a world.
    pub kappa: Option<f64>,
    /// Zero-order-hold bound: minimum FRE of any held force `[%]`.
    pub hold_bound_percent: Option<f64>,
    /// Strongest force of the ideal `[N]`.
    pub ideal_peak_force_n: Option<f64>,
    /// Error of the ideal's impulses relative to the largest; 0 if it is exact. One contact only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ideal_error: Option<f64>,
    /// Mean-force error between the ideal and the ideal with coarser steps `[%]`; worlds only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ideal_error_percent: Option<f64>,
    /// One entry for each method, then for each integrator of the object if they are compared.
    pub methods: Vec<MethodRow>,
    /// Least mass of the object that an explicit integrator moves passively, K T²/4 `[kg]`; only if integrators are
    /// compared.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub least_explicit_mass_kg: Option<f64>,
    /// Means over several seeds with their intervals, and differences of the methods.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seeded: Option<Seeded>,
}

/// A method on a scene.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
pub struct MethodRow {
    /// Name of the method.
    pub method: &'static str,
    /// Result of the method, or the reason why it cannot be set up.
    #[serde(flatten)]
    pub result: Outcome,
    /// Remarks for a terminal.
    #[serde(skip)]
    remarks: String,
}

/// Result of a method, or the reason for its absence.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum Outcome {
    /// It ran.
    Ran(Box<Figures>),
    /// It cannot be set up.
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

/// Results of a method on a scene.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
pub struct Figures {
    /// Parameters by key, with the unit at the end of the key; one contact only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parameters: Option<serde_json::Map<String, Value>>,
    /// Number of tried settings; the shown one has the lowest E, selected with knowledge of the ideal. None if the
    /// scene states the settings or there are none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tuned: Option<usize>,
    /// Settings of the method, under the keys of scene files; worlds only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub settings: Option<SettingReport>,
    /// Mean-force error E `[%]`; none without contact.
    pub mean_force_error_percent: Option<f64>,
    /// FRE `[%]`; none without contact.
    pub force_rendering_error_percent: Option<f64>,
    /// FRE over the zero-order-hold bound; none if the bound is 0.
    pub error_over_bound: Option<f64>,
    /// Peak force over that of the ideal.
    pub peak_over_ideal: Option<f64>,
    /// Sum of the absolute leaks of the held force `[J]`; one contact only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub absolute_leak_held_j: Option<f64>,
    /// Generated energy of the held forces `[J]`: the total energy gain of hands, bodies, contacts and dissipation;
    /// worlds only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub leak_j: Option<f64>,
    /// Whether the loop diverged.
    pub diverged: Option<bool>,
    /// Time at which the device left its safety box `[s]`.
    pub left_box_at_s: Option<f64>,
    /// Time at which a linkage jammed `[s]`.
    pub jammed_at_s: Option<f64>,
    /// Number of samples that the renderer rejected.
    pub refused_samples: usize,
    /// Whether the run stayed bounded, inside the safety box and off the end stops of the mechanism; in a world, also
    /// without rejected samples.
    #[serde(skip)]
    pub is_whole: bool,
}

impl Comparison {
    /// Creates the comparison of these scenes.
    #[must_use]
    pub fn new(scenes: Vec<SceneRows>) -> Self {
        Self {
            format: FORMAT,
            scenes,
            files: Vec::new(),
        }
    }

    /// Returns the rows of the table in the order of [`COLUMNS`]; missing values are empty.
    pub fn rows(&self) -> impl Iterator<Item = [String; COLUMNS.len()]> + '_ {
        self.scenes
            .iter()
            .flat_map(|scene| scene.methods.iter().map(|method| scene.row(method)))
    }
}

impl SceneRows {
    /// Creates the rows of a scene from the results of the methods, or the reasons why they cannot run.
    pub fn new(
        scene: String,
        subject: &Subject,
        reference: &Reference,
        outcomes: Vec<(MethodName, Result<Run, String>)>,
    ) -> Self {
        let peak = reference
            .profile
            .collisions()
            .iter()
            .map(|collision| collision.peak_force)
            .fold(0.0, f64::max);
        let sign = subject.contact.side.sign();
        let mut ran = Vec::new();
        let mut methods = Vec::new();
        for (method, outcome) in outcomes {
            let name = method.name();
            methods.push(MethodRow::new(name, outcome.as_ref(), sign, peak));
            ran.extend(outcome);
        }
        let report = Report::new(subject, reference, &ran);
        Self {
            scene,
            conditions: report.in_short(),
            title: report.title,
            is_world: false,
            period_s: report.period_s,
            window_s: report.window_s,
            kappa: report.kappa,
            hold_bound_percent: report.hold_bound_percent,
            ideal_peak_force_n: (peak > 0.0).then_some(peak),
            ideal_error: Some(report.ideal_error),
            ideal_error_percent: None,
            methods,
            least_explicit_mass_kg: None,
            seeded: None,
        }
    }

    /// Adds the sampled spring with an object that each integrator moves.
    #[must_use]
    pub fn with_integrators(
        mut self,
        subject: &Subject,
        outcomes: &[(Integrator, Result<Run, String>)],
    ) -> Self {
        let sign = subject.contact.side.sign();
        let peak = self.ideal_peak_force_n.unwrap_or(0.0);
        let rows = outcomes.iter().map(|(integrator, outcome)| {
            MethodRow::new(integrator.name(), outcome.as_ref(), sign, peak)
        });
        self.methods.extend(rows);
        let (stiffness, period) = (subject.contact.stiffness, subject.loop_params.period);
        self.least_explicit_mass_kg = Some(least_explicit_mass(stiffness, period));
        self
    }

    /// Returns the lowest error of a method whose run stayed bounded.
    fn least(&self) -> Option<f64> {
        self.methods
            .iter()
            .filter_map(|method| match &method.result {
                Outcome::Ran(run) if run.is_whole => run.mean_force_error_percent,
                _ => None,
            })
            .min_by(f64::total_cmp)
    }

    fn row(&self, method: &MethodRow) -> [String; COLUMNS.len()] {
        let text = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
        let mut row: [String; COLUMNS.len()] = Default::default();
        row[0].clone_from(&self.scene);
        row[1].clone_from(&self.title);
        row[2] = method.method.into();
        row[4] = self.period_s.to_string();
        row[5] = text(self.kappa);
        row[6] = text(self.hold_bound_percent);
        match &method.result {
            Outcome::Ran(run) => {
                let setting = |key: &str| match (&run.settings, &run.parameters) {
                    (Some(settings), _) => settings.values().find(|it| it.0 == key).map(|it| it.1),
                    (None, parameters) => parameters.as_ref()?.get(key)?.as_f64(),
                };
                row[3] = text(run.tuned.map(|count| count as f64));
                row[7] = text(run.mean_force_error_percent);
                row[8] = text(run.force_rendering_error_percent);
                row[9] = text(run.error_over_bound);
                row[10] = text(run.peak_over_ideal);
                row[11] = text(run.absolute_leak_held_j);
                row[12] = text(run.leak_j);
                row[13] = run.diverged.map_or_else(String::new, |it| it.to_string());
                row[14] = text(run.left_box_at_s);
                row[15] = text(run.jammed_at_s);
                row[16] = run.refused_samples.to_string();
                for (place, key) in (17..20).zip(&COLUMNS[17..20]) {
                    row[place] = text(setting(key));
                }
            }
            Outcome::Cannot { cannot: why } | Outcome::NoneFound { none_found: why } => {
                row[20].clone_from(why);
            }
        }
        row
    }
}

impl MethodRow {
    /// Returns the row of a run, or of the reason why there is none.
    fn new(
        method: &'static str,
        outcome: Result<&Run, &String>,
        sign: f64,
        ideal_peak: f64,
    ) -> Self {
        let (result, remarks) = match outcome {
            Err(cannot) => (
                Outcome::Cannot {
                    cannot: cannot.clone(),
                },
                String::new(),
            ),
            Ok(run) => {
                let report = MethodReport::new(run, sign);
                let remarks = report.remarks();
                let figures = Figures::new(report, ideal_peak);
                (Outcome::Ran(Box::new(figures)), remarks)
            }
        };
        Self {
            method,
            result,
            remarks,
        }
    }
}

impl Figures {
    fn new(report: MethodReport, ideal_peak: f64) -> Self {
        Self {
            parameters: Some(report.parameters),
            tuned: None,
            settings: None,
            mean_force_error_percent: report.mean_force_error_percent,
            force_rendering_error_percent: report.force_rendering_error_percent,
            error_over_bound: report.error_over_bound,
            peak_over_ideal: (ideal_peak > 0.0).then_some(report.peak_force_n / ideal_peak),
            absolute_leak_held_j: Some(report.absolute_leak_held_j),
            leak_j: None,
            diverged: report.diverged,
            left_box_at_s: report.left_box_at_s,
            jammed_at_s: report.jammed_at_s,
            refused_samples: report.faults,
            is_whole: report.diverged != Some(true)
                && report.left_box_at_s.is_none()
                && report.jammed_at_s.is_none(),
        }
    }
}
