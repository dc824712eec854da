//! Report on a map, method by method.

use std::fmt;
use std::path::Path;

use comfy_table::CellAlignment;
use palpate_record::map::{Format, Map, Row};
use serde::Serialize;

use super::metadata::{self, NoNumber};
use super::{Class, PRESSED_WITH, Plant, RESTS_BELOW, Stay, classify};
use crate::text::{E, digits, legend, lines, number, percent, plain_table, wrapped};

/// Computing speed.
#[derive(Clone, Copy, Debug)]
pub struct Speed {
    /// Number of ticks of plant, renderer and metrics.
    pub ticks: u64,
    /// Time `[s]`.
    pub seconds: f64,
    /// Number of threads.
    pub threads: usize,
}

/// Name and version of the JSON report.
const FORMAT: &str = "palpate map report 2";

/// Largest error of a faithful rendering, E `[%]`.
pub const FAITHFUL_PERCENT: f64 = 20.0;

/// The report on a map, or a part of one.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct MapReport {
    /// Name and version of this JSON.
    #[cfg_attr(any(test, feature = "schema"), schemars(extend("const" = FORMAT)))]
    pub format: &'static str,
    /// Version of palpate that made the map.
    pub palpate_version: String,
    /// Part of the map, for example `1/1`.
    pub shard: String,
    /// Cells along each axis.
    pub cells_per_axis: usize,
    /// Number of computed cells.
    pub cells: usize,
    /// Scene parameters common to all cells.
    pub scene: SceneReport,
    /// One entry for each method.
    pub methods: Vec<MethodReport>,
    /// Computing effort; none for an existing map.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub work: Option<Work>,
    /// Files that were written.
    pub files: Vec<String>,
    /// Existing files that were not changed.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub kept: Vec<String>,
}

/// Scene parameters common to all cells of a map.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct SceneReport {
    /// Effective mass of the device `[kg]`.
    pub device_mass_kg: f64,
    /// Period of the loop `[s]`.
    pub period_s: f64,
    /// Gap from which the object falls `[m]`.
    pub gap_m: f64,
    /// Forces that drive device and object together, in words.
    pub forces: String,
    /// Viscous friction `[N s/m]`.
    pub viscous_friction_n_s_per_m: f64,
    /// Quantum of the position sensor `[m]`.
    pub encoder_quantum_m: f64,
    /// Delay of the loop `[samples]`.
    pub delay_samples: f64,
    /// Time constant of the actuator `[periods]`; omitted if 0.
    #[serde(skip_serializing_if = "is_zero")]
    pub lag_periods: f64,
    /// Standard deviation of the delay in the renderer's model `[periods]`; omitted if 0.
    #[serde(skip_serializing_if = "is_zero")]
    pub delay_deviation_periods: f64,
    /// Standard deviation of the lag in the renderer's model `[periods]`; omitted if 0.
    #[serde(skip_serializing_if = "is_zero")]
    pub lag_deviation_periods: f64,
    /// Model device mass of the renderer over the true mass.
    pub model_mass_factor: f64,
    /// Model period of the renderer over the true period.
    pub model_period_factor: f64,
    /// Number of start heights.
    pub start_heights: f64,
}

/// Renderable contacts of a method on the map.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct MethodReport {
    /// `undamped` or `damped`.
    pub plant: &'static str,
    /// Name of the method.
    pub method: String,
    /// Share of the cells in which the loop is stable from every start height.
    pub stable_percent: f64,
    /// Share of the cells that are stable with an error below 20 % from every start height.
    pub faithful_percent: f64,
    /// Largest kappa up to which all walls of the map are stable; none if not even the softest is.
    pub stable_wall_kappa: Option<f64>,
    /// Largest kappa up to which all walls are stable with an error below 20 %.
    pub faithful_wall_kappa: Option<f64>,
    /// Largest kappa up to which all objects with Kc nearest to 1 are stable.
    pub stable_light_object_kappa: Option<f64>,
    /// Sustained contacts; none if the map is of an older version without them.
    pub stay: Option<StayReport>,
}

/// Sustained contacts of a method.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct StayReport {
    /// Share of the objects, walls excluded, that come to rest on the device under their weight.
    pub rests_percent: f64,
    /// Share of the cells with a steady pressed contact.
    pub pressed_percent: f64,
    /// Share of the cells that rest, are steady when pressed, and are stable with an error below 20 %.
    pub stays_faithful_percent: f64,
    /// Largest kappa up to which all walls of the map are steady when pressed.
    pub pressed_wall_kappa: Option<f64>,
    /// Largest kappa up to which all objects with Kc nearest to 1 come to rest.
    pub resting_light_object_kappa: Option<f64>,
}

/// Computing effort of a map.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Work {
    /// Number of ticks.
    pub ticks: u64,
    /// Time `[s]`.
    pub seconds: f64,
    /// Number of threads.
    pub threads: usize,
    /// Ticks per second and thread.
    pub ticks_per_second_and_thread: f64,
}

impl MapReport {
    /// Creates the report on `map`.
    pub fn new(map: &Map, speed: Option<Speed>) -> Result<Self, NoNumber> {
        let value = |key: &str| map.value(key).unwrap_or("unknown").to_owned();
        let number = |key: &str| metadata::number(map, key);
        let or_zero = |key: &str| match map.value(key) {
            None => Ok(0.0),
            Some(_) => metadata::number(map, key),
        };
        let forces = match map.value("forces") {
            Some("balanced") => format!(
                "equal and opposite, approaching at {} m/s²",
                value("approach_m_per_s2")
            ),
            _ => format!(
                "hand {} N, gravity {} m/s²",
                value("user_force_n"),
                value("gravity_m_per_s2")
            ),
        };
        let methods = value("methods");
        let mut reports = Vec::new();
        for plant in Plant::ALL {
            for method in methods.split(' ') {
                let of_method = |row: &&Row| row.plant == plant.name() && row.method == method;
                let rows: Vec<&Row> = map.rows.iter().filter(of_method).collect();
                reports.push(MethodReport::new(plant, method, &rows, map.format()));
            }
        }
        let lines_per_cell = metadata::count(map, palpate_record::map::LINES_PER_CELL)?;
        Ok(Self {
            format: FORMAT,
            palpate_version: value("palpate_version"),
            shard: value(palpate_record::map::SHARD),
            cells_per_axis: metadata::count(map, "cells_per_axis")?,
            cells: map.rows.len() / lines_per_cell.max(1),
            scene: SceneReport {
                device_mass_kg: number("device_mass_kg")?,
                period_s: number("period_s")?,
                gap_m: number("gap_m")?,
                forces,
                viscous_friction_n_s_per_m: number("viscous_friction_n_s_per_m")?,
                encoder_quantum_m: number("encoder_quantum_m")?,
                delay_samples: number("delay_samples")?,
                lag_periods: or_zero("lag_periods")?,
                delay_deviation_periods: or_zero("delay_deviation_periods")?,
                lag_deviation_periods: or_zero("lag_deviation_periods")?,
                model_mass_factor: number("model_mass_factor")?,
                model_period_factor: number("model_period_factor")?,
                start_heights: number("start_heights")?,
            },
            methods: reports,
            work: speed.map(|speed| Work {
                ticks: speed.ticks,
                seconds: speed.seconds,
                threads: speed.threads,
                ticks_per_second_and_thread: speed.ticks as f64
                    / (speed.seconds * speed.threads as f64),
            }),
            files: Vec::new(),
            kept: Vec::new(),
        })
    }

    /// Adds a written file.
    pub fn wrote(&mut self, path: &Path) {
        self.files.push(path.display().to_string());
    }

    /// Adds an existing file that was not changed.
    pub fn kept(&mut self, path: &Path) {
        self.kept.push(path.display().to_string());
    }
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks for it")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// Whether the loop is stable from every start height.
#[must_use]
pub fn is_stable(row: &Row) -> bool {
    classify(row.growth[1]) == Class::Stable
}

/// Whether the loop is stable and near to the ideal from every start height.
#[must_use]
pub fn is_faithful(row: &Row) -> bool {
    is_stable(row) && row.error[1] < FAITHFUL_PERCENT
}

/// Returns the sustained contacts of a row; `None` for a map of an older version.
#[must_use]
pub fn stay(row: &Row) -> Option<Stay> {
    row.stay.map(|stay| Stay {
        resting: stay.resting,
        pressed: stay.pressed,
    })
}

fn rests(row: &Row) -> bool {
    stay(row).is_some_and(|stay| stay.rests())
}

fn is_steady_pressed(row: &Row) -> bool {
    stay(row).is_some_and(|stay| stay.is_steady_pressed())
}

/// Returns a share of rows `[%]`.
fn share(rows: &[&Row], holds: fn(&Row) -> bool) -> f64 {
    let count = rows.iter().filter(|row| holds(row)).count();
    100.0 * count as f64 / rows.len().max(1) as f64
}

impl MethodReport {
    fn new(plant: Plant, method: &str, rows: &[&Row], format: Option<Format>) -> Self {
        // Within a column, rows are in ascending order of kappa.
        let up_to = |object_kappa: f64, holds: fn(&Row) -> bool| {
            rows.iter()
                .filter(|row| row.object_kappa == object_kappa)
                .take_while(|row| holds(row))
                .last()
                .map(|row| row.kappa)
        };
        let near_one = rows
            .iter()
            .map(|row| row.object_kappa)
            .filter(|kappa| *kappa > 0.0)
            .min_by(|a, b| a.ln().abs().total_cmp(&b.ln().abs()));
        Self {
            plant: plant.name(),
            method: method.to_owned(),
            stable_percent: share(rows, is_stable),
            faithful_percent: share(rows, is_faithful),
            stable_wall_kappa: up_to(0.0, is_stable),
            faithful_wall_kappa: up_to(0.0, is_faithful),
            stable_light_object_kappa: near_one.and_then(|kappa| up_to(kappa, is_stable)),
            stay: (format == Some(Format::BouncesAndStays)).then(|| {
                let is_object = |row: &&&Row| row.object_kappa > 0.0;
                let objects: Vec<&Row> = rows.iter().filter(is_object).copied().collect();
                StayReport {
                    rests_percent: share(&objects, rests),
                    pressed_percent: share(rows, is_steady_pressed),
                    stays_faithful_percent: share(rows, |row| {
                        is_faithful(row) && rests(row) && is_steady_pressed(row)
                    }),
                    pressed_wall_kappa: up_to(0.0, is_steady_pressed),
                    resting_light_object_kappa: near_one.and_then(|kappa| up_to(kappa, rests)),
                }
            }),
        }
    }
}

impl MapReport {
    /// Writes the sustained contacts, method by method.
    fn write_stays(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let header = [
            "method",
            "device",
            "rests %\nof objects",
            "pressed %\nof cells",
            "both,\nE < 20 %",
            "pressed\nwalls to",
            "Kc = 1\nrests to",
        ];
        let mut table = plain_table(CellAlignment::Left, &header);
        for method in &self.methods {
            let Some(stay) = &method.stay else {
                let older = "This map was made by an older version and has only bounces, no resting or \
                             pressed contacts.";
                return writeln!(f, "{}\n", wrapped(older));
            };
            table.add_row(vec![
                (&*method.method).into(),
                comfy_table::Cell::new(method.plant).set_alignment(CellAlignment::Right),
                number(Some(stay.rests_percent), percent),
                number(Some(stay.pressed_percent), percent),
                number(Some(stay.stays_faithful_percent), percent),
                number(stay.pressed_wall_kappa, digits),
                number(stay.resting_light_object_kappa, digits),
            ]);
        }
        writeln!(f, "{}\n", lines(&table))?;
        let meaning = format!(
            "Rests by its weight, pressed with {PRESSED_WITH} N: in a light and in a firm hand, the force swings by \
             less than {} % of the pressing force (standard deviation). \"Both\" are also stable.",
            percent(100.0 * RESTS_BELOW)
        );
        writeln!(f, "{}\n", wrapped(&meaning))
    }
}

impl fmt::Display for MapReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let part = if self.shard == "1/1" {
            String::new()
        } else {
            format!(", part {}", self.shard)
        };
        self.write_scene(f, &part)?;
        if part.is_empty() {
            self.write_bounces(f)?;
            self.write_stays(f)?;
        } else {
            writeln!(
                f,
                "{} cells; join all parts with palpate map merge\n",
                self.cells
            )?;
        }
        if let Some(work) = &self.work {
            writeln!(
                f,
                "{:.3e} ticks in {:.1} s on {}: {:.2e} ticks/s each\n",
                work.ticks as f64,
                work.seconds,
                crate::text::counted(work.threads as f64, "thread"),
                work.ticks_per_second_and_thread
            )?;
        }
        for file in &self.files {
            writeln!(f, "wrote {file}")?;
        }
        for file in &self.kept {
            writeln!(f, "kept the existing {file}")?;
        }
        Ok(())
    }
}

impl MapReport {
    /// Writes the range of the map and the scene common to its cells; `part` describes an incomplete map.
    fn write_scene(&self, f: &mut fmt::Formatter<'_>, part: &str) -> fmt::Result {
        let scene = &self.scene;
        let map = format!(
            "Map of kappa = K T²/m and Kc = K T²/M from 0.001 to 10, {n} x {n} cells and walls{part}",
            n = self.cells_per_axis
        );
        writeln!(f, "{}", wrapped(&map))?;
        writeln!(
            f,
            "device {} kg, period {} s, gap {} m ± 5 % in {} start heights",
            scene.device_mass_kg, scene.period_s, scene.gap_m, scene.start_heights
        )?;
        let least = "The object is moved exactly; an explicit integrator is passive for Kc <= 4 only \
                     (K T²/4, Brown-Colgate)";
        writeln!(f, "{}", wrapped(least))?;
        let mut forces = format!(
            "forces {}; damped: {} N s/m",
            scene.forces, scene.viscous_friction_n_s_per_m
        );
        for (name, value, usual) in [
            ("encoder quantum [m]", scene.encoder_quantum_m, 0.0),
            ("delay [periods]", scene.delay_samples, 0.0),
            ("lag [periods]", scene.lag_periods, 0.0),
            (
                "deviation of the delay [periods]",
                scene.delay_deviation_periods,
                0.0,
            ),
            (
                "deviation of the lag [periods]",
                scene.lag_deviation_periods,
                0.0,
            ),
            ("model mass x", scene.model_mass_factor, 1.0),
            ("model period x", scene.model_period_factor, 1.0),
        ] {
            if value != usual {
                forces.push_str(&format!("; {name} {value}"));
            }
        }
        writeln!(f, "{}\n", wrapped(&forces))
    }

    /// Writes the stability and the force error of the bounces, method by method.
    fn write_bounces(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let header = [
            "method",
            "device",
            "stable %\nof cells",
            "and\nE < 20 %",
            "walls\nto kappa",
            "and\nE < 20 %",
            "Kc = 1\nto kappa",
        ];
        let mut table = plain_table(CellAlignment::Left, &header);
        for method in &self.methods {
            table.add_row(vec![
                (&*method.method).into(),
                comfy_table::Cell::new(method.plant).set_alignment(CellAlignment::Right),
                number(Some(method.stable_percent), percent),
                number(Some(method.faithful_percent), percent),
                number(method.stable_wall_kappa, digits),
                number(method.faithful_wall_kappa, digits),
                number(method.stable_light_object_kappa, digits),
            ]);
        }
        writeln!(f, "{}\n", lines(&table))?;
        let stable = "Stable: from every start height, energy grows by at most 1 % per collision. A dash: not \
                      even the softest contact of the map.";
        writeln!(f, "{}\n", legend(&[stable, E]))
    }
}
