//! `palpate heights`: how much errors depend on the start height.

use std::fmt;

use comfy_table::CellAlignment;
use palpate_study::heights::{HeightsError, OverHeights, over_heights};
use palpate_study::suite::Column;
use palpate_study::tune::{HEIGHT_RANGE, HEIGHTS, Spread};
use serde::Serialize;

use super::simulate::{explain, read_scene};
use crate::arguments::{Flags, HeightsArguments, TimingFlags};
use crate::failure::Failure;
use crate::progress::Progress;
use crate::report::{digits, lines, number, percent, plain_table};
use crate::results::print;

/// Judges every column on every scene.
pub fn run(arguments: &HeightsArguments) -> Result<(), Failure> {
    let factor = arguments.told_mass_factor;
    if !(factor.is_finite() && factor > 0.0) {
        return Err(Failure::Arguments(format!(
            "--told-mass-factor is {factor}, but must be finite and greater than 0"
        )));
    }
    let columns = arguments.compared.columns()?;
    let files = arguments
        .scenes
        .iter()
        .map(|path| read_scene(path))
        .collect::<Result<Vec<_>, _>>()?;
    let progress = Progress::new(HEIGHTS * files.len());
    let mut scenes = Vec::with_capacity(files.len());
    for (path, file) in arguments.scenes.iter().zip(&files) {
        progress.begin(&file.scene.title);
        let mut scene = file.scene.clone();
        if factor != 1.0 {
            scene.told_device_mass = Some(factor * scene.device.mass);
        }
        let found =
            over_heights(&scene, &columns, || progress.advance()).map_err(|error| match error {
                HeightsError::Scene(error) => explain(
                    (&Flags::default(), &TimingFlags::default()),
                    file,
                    scene.method,
                    error,
                ),
                other => Failure::input(format!("{}: {other}", path.display())),
            })?;
        scenes.push(SceneReport::new(&scene.title, &columns, &found));
    }
    drop(progress);
    let report = Report {
        format: "palpate heights 1",
        start_heights: HEIGHTS,
        height_range: HEIGHT_RANGE,
        told_mass_factor: factor,
        scenes,
    };
    print(&if arguments.json {
        serde_json::to_string_pretty(&report).expect("a report has string keys only") + "\n"
    } else {
        report.to_string()
    })
}

#[derive(Serialize)]
struct Report {
    format: &'static str,
    start_heights: usize,
    height_range: f64,
    told_mass_factor: f64,
    scenes: Vec<SceneReport>,
}

#[derive(Serialize)]
struct SceneReport {
    title: String,
    hold_floor_percent: f64,
    columns: Vec<ColumnReport>,
}

#[derive(Serialize)]
struct ColumnReport {
    name: String,
    method: &'static str,
    mean_force_error_percent: ErrorReport,
    force_rendering_error_percent: f64,
    force_rendering_error_over_heights_percent: ErrorReport,
    error_over_floor: Option<f64>,
    diverged: usize,
    /// Of a column that chooses.
    #[serde(skip_serializing_if = "Option::is_none")]
    damping_n_s_per_m: Option<f64>,
}

#[derive(Serialize)]
struct ErrorReport {
    own: f64,
    median: f64,
    worst: f64,
}

impl From<Spread> for ErrorReport {
    fn from(spread: Spread) -> Self {
        let Spread { own, median, worst } = spread;
        Self { own, median, worst }
    }
}

impl SceneReport {
    fn new(title: &str, columns: &[Column], found: &[OverHeights]) -> Self {
        Self {
            title: title.into(),
            // The floor is the ideal's, whatever the column.
            hold_floor_percent: found.first().map_or(0.0, |one| one.own.hold_floor),
            columns: columns
                .iter()
                .zip(found)
                .map(|(column, found)| ColumnReport {
                    name: column.name.clone(),
                    method: column.method.name(),
                    mean_force_error_percent: found.error.into(),
                    force_rendering_error_percent: found.own.force_rendering_error,
                    force_rendering_error_over_heights_percent: found.force_rendering_error.into(),
                    error_over_floor: found.own.error_over_floor,
                    diverged: found.diverged,
                    damping_n_s_per_m: found.damping,
                })
                .collect(),
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{} start heights within ±{} %, told {} times the device's mass",
            self.start_heights,
            100.0 * self.height_range,
            self.told_mass_factor
        )?;
        for scene in &self.scenes {
            writeln!(
                f,
                "\n{}; floor {:.2} %\n",
                scene.title, scene.hold_floor_percent
            )?;
            let header = [
                "method",
                "E % own",
                "median",
                "worst",
                "FRE % own",
                "median",
                "worst",
                "diverged",
                "best B",
            ];
            let chosen = scene
                .columns
                .iter()
                .any(|column| column.damping_n_s_per_m.is_some());
            let header = &header[..header.len() - usize::from(!chosen)];
            let mut table = plain_table(CellAlignment::Left, header);
            for column in &scene.columns {
                let error = &column.mean_force_error_percent;
                let fre = &column.force_rendering_error_over_heights_percent;
                let hundredths = |value: f64| number(Some(value), |value| format!("{value:.2}"));
                let mut cells = vec![
                    (&*column.name).into(),
                    hundredths(error.own),
                    hundredths(error.median),
                    hundredths(error.worst),
                    number(Some(column.force_rendering_error_percent), percent),
                    number(Some(fre.median), percent),
                    number(Some(fre.worst), percent),
                    number(Some(column.diverged as f64), |count| {
                        format!("{count} of {}", self.start_heights)
                    }),
                ];
                if chosen {
                    cells.push(number(column.damping_n_s_per_m, digits));
                }
                table.add_row(cells);
            }
            writeln!(f, "{}", lines(&table))?;
        }
        writeln!(f)
    }
}
