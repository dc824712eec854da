//! Many scenes and methods in one table.

use std::fmt;

use comfy_table::{Cell, CellAlignment};
use palpate_scene::method::MethodName;
use palpate_sim::run::{Reference, Run};
use serde::Serialize;
use serde_json::Value;

use crate::plots::{ComparedMethod, ComparedScene};

use super::text::{digits, lines, percent, plain_table};
use super::{MethodReport, Report, Subject};

/// Name and version of the JSON report.
const FORMAT: &str = "palpate compare 1";

/// Columns of the table as CSV.
pub const COLUMNS: [&str; 15] = [
    "scene",
    "title",
    "method",
    "kappa",
    "hold_floor_percent",
    "mean_force_error_percent",
    "force_rendering_error_percent",
    "error_over_floor",
    "peak_over_ideal",
    "absolute_leak_held_j",
    "diverged",
    "left_box_at_s",
    "jammed_at_s",
    "refused_samples",
    "cannot",
];

/// Every scene that was compared, in the order given.
#[derive(Debug, Serialize)]
pub struct Comparison {
    format: &'static str,
    scenes: Vec<SceneRows>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    files: Vec<String>,
}

/// One scene with its methods.
#[derive(Debug, Serialize)]
pub struct SceneRows {
    scene: String,
    title: String,
    #[serde(skip)]
    conditions: String,
    kappa: Option<f64>,
    hold_floor_percent: Option<f64>,
    ideal_peak_force_n: Option<f64>,
    ideal_error: f64,
    methods: Vec<MethodRow>,
}

#[derive(Debug, Serialize)]
struct MethodRow {
    method: &'static str,
    #[serde(flatten)]
    result: Result,
    #[serde(skip)]
    remarks: String,
}

/// What a method did, or why it cannot be set up.
#[derive(Debug, Serialize)]
#[serde(untagged)]
enum Result {
    Ran(Box<Figures>),
    Cannot { cannot: String },
}

#[derive(Debug, Serialize)]
struct Figures {
    parameters: serde_json::Map<String, Value>,
    mean_force_error_percent: Option<f64>,
    force_rendering_error_percent: Option<f64>,
    error_over_floor: Option<f64>,
    peak_over_ideal: Option<f64>,
    absolute_leak_held_j: f64,
    diverged: Option<bool>,
    left_box_at_s: Option<f64>,
    jammed_at_s: Option<f64>,
    refused_samples: usize,
}

impl Comparison {
    /// The table of these scenes.
    pub fn of(scenes: Vec<SceneRows>) -> Self {
        Self {
            format: FORMAT,
            scenes,
            files: Vec::new(),
        }
    }

    /// Adds a file that was written.
    pub fn wrote(&mut self, path: &std::path::Path) {
        self.files.push(path.display().to_string());
    }

    /// The comparison as JSON.
    pub fn json(&self) -> String {
        serde_json::to_string_pretty(self).expect("a report has string keys only")
    }

    /// The force errors of every scene, for a figure.
    pub fn errors(&self) -> Vec<ComparedScene<'_>> {
        let of_method = |method: &MethodRow| match &method.result {
            Result::Ran(run) => ComparedMethod {
                name: method.method,
                error: run.force_rendering_error_percent,
                holds_together: run.is_whole(),
                ran: true,
            },
            Result::Cannot { .. } => ComparedMethod {
                name: method.method,
                error: None,
                holds_together: false,
                ran: false,
            },
        };
        self.scenes
            .iter()
            .map(|scene| ComparedScene {
                title: &scene.title,
                hold_floor: scene.hold_floor_percent,
                methods: scene.methods.iter().map(of_method).collect(),
            })
            .collect()
    }

    /// The table by rows, as [`COLUMNS`] name them; what does not exist is empty.
    pub fn rows(&self) -> impl Iterator<Item = [String; COLUMNS.len()]> + '_ {
        self.scenes
            .iter()
            .flat_map(|scene| scene.methods.iter().map(|method| scene.row(method)))
    }
}

impl SceneRows {
    /// The rows of a scene from what each method did, or why it cannot.
    pub fn of(
        scene: String,
        subject: &Subject,
        reference: &Reference,
        outcomes: Vec<(MethodName, std::result::Result<Run, String>)>,
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
            let (result, remarks) = match outcome {
                Err(cannot) => (Result::Cannot { cannot }, String::new()),
                Ok(run) => {
                    let report = MethodReport::new(&run, sign);
                    let remarks = report.remarks();
                    ran.push(run);
                    (Result::Ran(Box::new(Figures::of(report, peak))), remarks)
                }
            };
            methods.push(MethodRow {
                method: method.name(),
                result,
                remarks,
            });
        }
        let report = Report::new(subject, reference, &ran);
        Self {
            scene,
            conditions: report.in_short(),
            title: report.title,
            kappa: report.kappa,
            hold_floor_percent: report.hold_floor_percent,
            ideal_peak_force_n: (peak > 0.0).then_some(peak),
            ideal_error: report.ideal_error,
            methods,
        }
    }

    /// The least error of a method that stayed in one piece.
    fn least(&self) -> Option<f64> {
        self.methods
            .iter()
            .filter_map(|method| match &method.result {
                Result::Ran(run) if run.is_whole() => run.mean_force_error_percent,
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
        row[4] = text(self.hold_floor_percent);
        match &method.result {
            Result::Ran(run) => {
                row[5] = text(run.mean_force_error_percent);
                row[6] = text(run.force_rendering_error_percent);
                row[7] = text(run.error_over_floor);
                row[8] = text(run.peak_over_ideal);
                row[9] = run.absolute_leak_held_j.to_string();
                row[10] = run.diverged.map_or_else(String::new, |it| it.to_string());
                row[11] = text(run.left_box_at_s);
                row[12] = text(run.jammed_at_s);
                row[13] = run.refused_samples.to_string();
            }
            Result::Cannot { cannot } => row[14].clone_from(cannot),
        }
        row
    }
}

impl Figures {
    fn of(report: MethodReport, ideal_peak: f64) -> Self {
        Self {
            parameters: report.parameters,
            mean_force_error_percent: report.mean_force_error_percent,
            force_rendering_error_percent: report.force_rendering_error_percent,
            error_over_floor: report.error_over_floor,
            peak_over_ideal: (ideal_peak > 0.0).then_some(report.peak_force_n / ideal_peak),
            absolute_leak_held_j: report.absolute_leak_held_j,
            diverged: report.diverged,
            left_box_at_s: report.left_box_at_s,
            jammed_at_s: report.jammed_at_s,
            refused_samples: report.faults,
        }
    }

    /// Whether it neither ran away nor ran out of a safety box or into the end of a mechanism.
    fn is_whole(&self) -> bool {
        self.diverged != Some(true) && self.left_box_at_s.is_none() && self.jammed_at_s.is_none()
    }
}

/// Before the name of a method that did not stay in one piece, and of the one with the least error.
const BROKEN: &str = "!";
const LEAST: &str = "*";

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let header = [
            "",
            "method",
            "E %",
            "FRE %",
            "FRE/floor",
            "peak/ideal",
            "|leak| mJ",
            "",
        ];
        let mut table = plain_table(CellAlignment::Left, &header);
        for scene in &self.scenes {
            let least = scene.least();
            for method in &scene.methods {
                let (mark, cells) = match &method.result {
                    Result::Cannot { .. } => ("-", vec![None; 5]),
                    Result::Ran(run) => {
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
                            run.error_over_floor.map(digits),
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
                row.push(Cell::new(&method.remarks));
                table.add_row(row);
            }
        }
        let text = lines(&table);
        let mut text = text.lines();
        for line in text.by_ref().take(2) {
            writeln!(f, "{line}")?;
        }
        for scene in &self.scenes {
            writeln!(f, "\n{}\n  {}", scene.title, scene.conditions)?;
            for (line, method) in text.by_ref().take(scene.methods.len()).zip(&scene.methods) {
                writeln!(f, "{line}")?;
                if let Result::Cannot { cannot } = &method.result {
                    writeln!(f, "     cannot be set up: {cannot}")?;
                }
            }
        }
        writeln!(
            f,
            "\n{LEAST} least E of those that held together, {BROKEN} diverged, left the safety box or \
             jammed.\nE: what a method answers for. Without a setting in the scene a method has its \
             default; see --json\nfor every parameter."
        )?;
        for file in &self.files {
            writeln!(f, "wrote {file}")?;
        }
        Ok(())
    }
}
