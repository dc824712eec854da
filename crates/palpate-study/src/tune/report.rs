//! Results of tuning, as a table or as JSON.

use std::fmt;

use comfy_table::{Cell, CellAlignment};
use palpate_scene::Scene;
use palpate_scene::method::{MethodName, Setting, SettingKey};
use serde::{Serialize, Serializer};

use super::{HEIGHT_RANGE, HEIGHTS, Objective, Spread, TunedPoint, best};
use crate::text::{
    ABSOLUTE_LEAK, E, digits, drawn_title, legend, lines, number, percent, plain_table, wrapped,
};

/// Name and version of the JSON report.
const FORMAT: &str = "palpate tune 1";

/// Dependence of a method's error and leak on its damping.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct TuneReport {
    /// Name and version of this JSON.
    #[cfg_attr(any(test, feature = "schema"), schemars(extend("const" = FORMAT)))]
    pub format: &'static str,
    /// The scene's title.
    pub title: String,
    /// Seed of the random values of jitter, drops and sensor noise; none if nothing is random. The results are one
    /// draw.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// Name of the method.
    pub method: &'static str,
    /// Scene key of the tuned setting.
    #[serde(serialize_with = "as_text")]
    #[cfg_attr(any(test, feature = "schema"), schemars(with = "String"))]
    pub setting: SettingKey,
    /// Number of start heights.
    pub start_heights: usize,
    /// Largest change of the gap, as a share of the scene's.
    pub height_range: f64,
    /// Minimised quantity: `error` or `leak`.
    pub least: &'static str,
    /// The value with the lowest median.
    pub best: PointReport,
    /// The value with the lowest result at the scene's own start height.
    pub best_at_own_height: PointReport,
    /// Every value that was tried.
    pub curve: Vec<PointReport>,
    /// Files that were written.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<String>,
}

/// A value of the damping and its results.
#[derive(Debug, Serialize, Clone, Copy)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct PointReport {
    /// The damping or cap `[N s/m]`.
    pub value_n_s_per_m: f64,
    /// Mean-force error E `[%]`.
    pub mean_force_error_percent: Spread,
    /// Sum of the absolute leaks of the held force `[J]`.
    pub absolute_leak_j: Spread,
    /// Number of start heights from which the loop diverged.
    pub diverged: usize,
}

impl From<&TunedPoint> for PointReport {
    fn from(point: &TunedPoint) -> Self {
        Self {
            value_n_s_per_m: point.value,
            mean_force_error_percent: point.mean_force_error,
            absolute_leak_j: point.leak,
            diverged: point.diverged,
        }
    }
}

/// Columns of the curve as CSV.
pub const COLUMNS: [&str; 10] = [
    "method",
    "setting",
    "value_n_s_per_m",
    "own_mean_force_error_percent",
    "median_mean_force_error_percent",
    "worst_mean_force_error_percent",
    "own_absolute_leak_j",
    "median_absolute_leak_j",
    "worst_absolute_leak_j",
    "diverged_heights",
];

impl TuneReport {
    /// Returns a row for each tried value, in the order of [`COLUMNS`].
    pub fn rows(&self) -> impl Iterator<Item = [String; COLUMNS.len()]> + '_ {
        self.curve.iter().map(|point| {
            let (error, leak) = (point.mean_force_error_percent, point.absolute_leak_j);
            [
                self.method.into(),
                self.setting.as_str().into(),
                point.value_n_s_per_m.to_string(),
                error.own.to_string(),
                error.median.to_string(),
                error.worst.to_string(),
                leak.own.to_string(),
                leak.median.to_string(),
                leak.worst.to_string(),
                point.diverged.to_string(),
            ]
        })
    }

    /// Creates the report of the result of [`tune`](super::tune) for `method` on `scene`; the best point is selected
    /// by `objective`.
    ///
    /// # Panics
    /// There is no point.
    pub fn new(
        scene: &Scene,
        method: MethodName,
        setting: &Setting,
        objective: Objective,
        points: Vec<TunedPoint>,
    ) -> Self {
        let best = best(&points, objective).expect("one point at least");
        let own = |point: &TunedPoint| match objective {
            Objective::Error => point.mean_force_error.own,
            Objective::Leak => point.leak.own,
        };
        let at_own = points
            .iter()
            .min_by(|a, b| own(a).total_cmp(&own(b)))
            .expect("one point at least");
        Self {
            format: FORMAT,
            title: scene.title.clone(),
            seed: scene.random_seed(),
            method: method.name(),
            setting: setting.key,
            start_heights: HEIGHTS,
            height_range: HEIGHT_RANGE,
            least: objective.name(),
            best: best.into(),
            best_at_own_height: at_own.into(),
            curve: points.iter().map(PointReport::from).collect(),
            files: Vec::new(),
        }
    }

    /// Returns the tuned setting in words: `damping` or `damping cap`.
    #[must_use]
    pub fn setting_in_words(&self) -> &'static str {
        words(self.setting)
    }
}

fn as_text<S: Serializer>(key: &SettingKey, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(key.as_str())
}

/// Returns a scene key in words, without its unit.
fn words(key: SettingKey) -> &'static str {
    if key == SettingKey::DAMPING_CAP {
        "damping cap"
    } else {
        "damping"
    }
}

impl fmt::Display for TuneReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", wrapped(&drawn_title(&self.title, self.seed)))?;
        let tried = format!(
            "{} of {}, {} values, {} start heights within ±{} %",
            words(self.setting),
            self.method,
            self.curve.len(),
            self.start_heights,
            100.0 * self.height_range
        );
        writeln!(f, "{}\n", wrapped(&tried))?;
        let header = [
            &*format!("least {}", self.least),
            "in the median",
            "at the scene's own height",
        ];
        let mut table = plain_table(CellAlignment::Left, &header);
        let points = [&self.best, &self.best_at_own_height];
        let mut row = |name: &str, cell: &dyn Fn(&PointReport) -> Cell| {
            let cells = points.iter().map(|point| cell(point));
            table.add_row(std::iter::once(Cell::new(name)).chain(cells));
        };
        row(&format!("{} N s/m", words(self.setting)), &|point| {
            number(Some(point.value_n_s_per_m), digits)
        });
        type Of = fn(&Spread) -> f64;
        let spreads: [(&str, Of); 3] = [
            ("own height", |spread| spread.own),
            ("median", |spread| spread.median),
            ("worst", |spread| spread.worst),
        ];
        for (name, of) in spreads {
            row(&format!("E %, {name}"), &|point| {
                number(Some(of(&point.mean_force_error_percent)), percent)
            });
        }
        for (name, of) in spreads {
            row(&format!("|leak| mJ, {name}"), &|point| {
                number(Some(1e3 * of(&point.absolute_leak_j)), digits)
            });
        }
        row("diverged", &|point| {
            number(Some(point.diverged as f64), |count| {
                format!("{count} of {}", self.start_heights)
            })
        });
        writeln!(f, "{}\n", lines(&table))?;
        writeln!(f, "{}\n", legend(&[E, ABSOLUTE_LEAK]))?;
        for file in &self.files {
            writeln!(f, "wrote {file}")?;
        }
        Ok(())
    }
}
