//! Comparison of many scenes and methods in one table.

use std::fmt;

use crate::map::bounds::least_explicit_mass;
use crate::sim::integrated::Integrator;
use crate::sim::run::{Reference, Run};
use comfy_table::{Cell, CellAlignment};
use palpate_scene::method::MethodName;
use serde::Serialize;
use serde_json::Value;

use crate::report::{MethodReport, Report, Subject};
use crate::seeded::Seeded;
use crate::text::{
    ABSOLUTE_LEAK, E, FRE, WIDTH, digits, legend, lines, percent, plain_table, within, wrapped,
};

/// Name and version of the JSON report.
const FORMAT: &str = "palpate compare 1";

/// Columns of the table as CSV.
pub const COLUMNS: [&str; 15] = [
    "scene",
    "title",
    "method",
    "kappa",
    "hold_bound_percent",
    "mean_force_error_percent",
    "force_rendering_error_percent",
    "error_over_bound",
    "peak_over_ideal",
    "absolute_leak_held_j",
    "diverged",
    "left_box_at_s",
    "jammed_at_s",
    "refused_samples",
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
    /// K T²/m.
    pub kappa: Option<f64>,
    /// Zero-order-hold bound: minimum FRE of any held force `[%]`.
    pub hold_bound_percent: Option<f64>,
    /// Strongest force of the ideal `[N]`.
    pub ideal_peak_force_n: Option<f64>,
    /// Error of the ideal's impulses relative to the largest; 0 if it is exact.
    pub ideal_error: f64,
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

/// Result of a method, or the reason why it cannot be set up.
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
}

/// Results of a method on a scene.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
pub struct Figures {
    /// Parameters by key, with the unit at the end of the key.
    pub parameters: serde_json::Map<String, Value>,
    /// Mean-force error E `[%]`; none without contact.
    pub mean_force_error_percent: Option<f64>,
    /// FRE `[%]`; none without contact.
    pub force_rendering_error_percent: Option<f64>,
    /// FRE over the zero-order-hold bound; none if the bound is 0.
    pub error_over_bound: Option<f64>,
    /// Peak force over that of the ideal.
    pub peak_over_ideal: Option<f64>,
    /// Sum of the absolute leaks of the held force `[J]`.
    pub absolute_leak_held_j: f64,
    /// Whether the loop diverged.
    pub diverged: Option<bool>,
    /// Time at which the device left its safety box `[s]`.
    pub left_box_at_s: Option<f64>,
    /// Time at which a linkage jammed `[s]`.
    pub jammed_at_s: Option<f64>,
    /// Number of samples that the renderer rejected.
    pub refused_samples: usize,
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

    /// Adds a written file.
    pub fn wrote(&mut self, path: &std::path::Path) {
        self.files.push(path.display().to_string());
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
            kappa: report.kappa,
            hold_bound_percent: report.hold_bound_percent,
            ideal_peak_force_n: (peak > 0.0).then_some(peak),
            ideal_error: report.ideal_error,
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
                Outcome::Ran(run) if run.is_whole() => run.mean_force_error_percent,
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
        row[3] = text(self.kappa);
        row[4] = text(self.hold_bound_percent);
        match &method.result {
            Outcome::Ran(run) => {
                row[5] = text(run.mean_force_error_percent);
                row[6] = text(run.force_rendering_error_percent);
                row[7] = text(run.error_over_bound);
                row[8] = text(run.peak_over_ideal);
                row[9] = run.absolute_leak_held_j.to_string();
                row[10] = run.diverged.map_or_else(String::new, |it| it.to_string());
                row[11] = text(run.left_box_at_s);
                row[12] = text(run.jammed_at_s);
                row[13] = run.refused_samples.to_string();
            }
            Outcome::Cannot { cannot } => row[14].clone_from(cannot),
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
            parameters: report.parameters,
            mean_force_error_percent: report.mean_force_error_percent,
            force_rendering_error_percent: report.force_rendering_error_percent,
            error_over_bound: report.error_over_bound,
            peak_over_ideal: (ideal_peak > 0.0).then_some(report.peak_force_n / ideal_peak),
            absolute_leak_held_j: report.absolute_leak_held_j,
            diverged: report.diverged,
            left_box_at_s: report.left_box_at_s,
            jammed_at_s: report.jammed_at_s,
            refused_samples: report.faults,
        }
    }

    /// Whether the run stayed bounded, inside the safety box and off the end stops of the mechanism.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.diverged != Some(true) && self.left_box_at_s.is_none() && self.jammed_at_s.is_none()
    }
}

/// Formats text below the line of a method, in the column of its name.
fn below(words: &str) -> String {
    const BLANKS: &str = "     ";
    let lines = within(words, WIDTH - BLANKS.len());
    format!("{BLANKS}{}", lines.join(&format!("\n{BLANKS}")))
}

/// Markers before the name of a method that did not stay bounded, and of the method with the lowest error.
const BROKEN: &str = "!";
const LEAST: &str = "*";

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let header = [
            "",
            "method",
            "E %",
            "FRE %",
            "FRE/bound",
            "peak/ideal",
            "|leak| mJ",
        ];
        let mut table = plain_table(CellAlignment::Left, &header);
        for scene in &self.scenes {
            let least = scene.least();
            for method in &scene.methods {
                let (mark, cells) = match &method.result {
                    Outcome::Cannot { .. } => ("-", vec![None; 5]),
                    Outcome::Ran(run) => {
                        let mark = if !run.is_whole() {
                            BROKEN
                        } else if least.is_some() && run.mean_force_error_percent == least {
                            LEAST
                        } else {
                            ""
                        };
                        let cells = vec![
                            run.mean_force_error_percent.map(percent),
                            run.force_rendering_error_percent.map(percent),
                            run.error_over_bound.map(digits),
                            run.peak_over_ideal.map(digits),
                            Some(digits(1e3 * run.absolute_leak_held_j)),
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
        let text = lines(&table);
        let mut text = text.lines();
        for line in text.by_ref().take(2) {
            writeln!(f, "{line}")?;
        }
        for scene in &self.scenes {
            writeln!(f, "\n{}\n  {}", wrapped(&scene.title), scene.conditions)?;
            for (line, method) in text.by_ref().take(scene.methods.len()).zip(&scene.methods) {
                let remarks = &method.remarks;
                if remarks.is_empty() {
                    writeln!(f, "{line}")?;
                } else if line.chars().count() + 2 + remarks.chars().count() <= WIDTH {
                    writeln!(f, "{line}  {remarks}")?;
                } else {
                    writeln!(f, "{line}\n{}", below(remarks))?;
                }
                if let Outcome::Cannot { cannot } = &method.result {
                    writeln!(f, "{}", below(&format!("cannot be set up: {cannot}")))?;
                }
            }
            if let Some(least) = scene.least_explicit_mass_kg {
                let words = format!(
                    "exact to implicit: the sampled spring, with an object that this integrator moves. An explicit one is \
                     passive from K T²/4 = {} kg (Brown-Colgate).",
                    digits(least)
                );
                writeln!(f, "{}", below(&words))?;
            }
            if let Some(seeded) = &scene.seeded {
                write!(f, "\n{seeded}")?;
            }
        }
        let marks = format!(
            "{LEAST} least E of the bounded runs, {BROKEN} diverged, left the safety box or jammed."
        );
        writeln!(f, "\n{}", wrapped(&marks))?;
        writeln!(f, "{}", legend(&[E, FRE, ABSOLUTE_LEAK]))?;
        let settings = "A method without a setting in the scene uses its default; --json lists every parameter.";
        writeln!(f, "{}", wrapped(settings))?;
        for file in &self.files {
            writeln!(f, "wrote {file}")?;
        }
        Ok(())
    }
}
