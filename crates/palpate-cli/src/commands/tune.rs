//! `palpate tune`: how a method's error and leak depend on its damping.

use std::fmt;

use comfy_table::CellAlignment;
use palpate_scene::Scene;
use palpate_scene::method::{MethodName, Setting};
use palpate_sim::tune::{self, HEIGHT_RANGE, HEIGHTS, Objective, Spread, TuneError, TunedPoint};
use serde::Serialize;

use super::simulate::{explain, read_scene};
use crate::arguments::{CurveArguments, Least, TuneArguments};
use crate::failure::Failure;
use crate::progress::Progress;
use crate::report::{digits, lines, number, percent, plain_table};
use crate::results::{draw, print};
use crate::setup::flag_of_setting;
use palpate_figure::{Figure, Kind, Limits, Panel, Role, Row, Series};

/// Tries every value of the curve at every start height.
pub fn run(arguments: &TuneArguments) -> Result<(), Failure> {
    let flags = &arguments.flags;
    let file = read_scene(&arguments.scene)?;
    let methods = flags.methods(file.scene.method);
    let &[method] = methods.as_slice() else {
        return Err(Failure::Arguments(
            "tune looks at one method; name it with --method".into(),
        ));
    };
    flags.check_settings(&methods)?;
    let setting = tune::tunable(method).ok_or_else(|| {
        let nothing = TuneError::NothingToTune(method);
        Failure::Arguments(format!("{nothing}; name one with --method"))
    })?;
    if flags.settings().has(setting) {
        return Err(Failure::Arguments(format!(
            "{} is what tune looks for; say where with --from and --to",
            flag_of_setting(setting)
        )));
    }
    let mut outputs = arguments.overwriting.outputs();
    outputs.protect(&arguments.scene);
    arguments.picture.plan(&mut outputs)?;
    let mut scene = file.scene.clone();
    flags.change(&mut scene, &methods)?;
    arguments.timing.change(&mut scene);
    // The range of the values follows from stiffness and period, so these come first.
    scene
        .renderer(method)
        .map_err(|error| explain((flags, &arguments.timing), &file, method, error.into()))?;
    let values = values(&arguments.curve, &scene, method, setting)?;
    let progress = Progress::new(HEIGHTS);
    progress.begin("start heights");
    let points =
        tune::tune(&scene, method, &values, || progress.advance()).map_err(
            |error| match error {
                TuneError::Loop(error) => explain((flags, &arguments.timing), &file, method, error),
                other => Failure::input(other),
            },
        )?;
    drop(progress);

    let mut report = Report::new(&scene, method, setting, arguments.curve.least, points);
    if let Some(path) = &arguments.picture.plot {
        draw(&outputs, path, &report.figure(), arguments.picture.size)?;
        report.files.push(path.display().to_string());
    }
    print(&if arguments.json {
        serde_json::to_string_pretty(&report).expect("a report has string keys only") + "\n"
    } else {
        report.to_string()
    })
}

/// The values to try `[N s/m]`.
fn values(
    curve: &CurveArguments,
    scene: &Scene,
    method: MethodName,
    setting: Setting,
) -> Result<Vec<f64>, Failure> {
    let impedance = scene.contact.stiffness * scene.loop_params.period;
    let to = curve.to.unwrap_or(match (setting, method) {
        (Setting::DampingCap, _) => 8.0 * impedance,
        (_, MethodName::Hfcr) => impedance,
        _ => 4.0 * impedance,
    });
    let from = curve.from.unwrap_or(match setting {
        Setting::DampingCap => to / f64::from(curve.steps),
        _ => 0.0,
    });
    if !(from.is_finite() && to.is_finite() && from >= 0.0 && to > from) {
        return Err(Failure::Arguments(format!(
            "--from {from} --to {to}: the values must be finite, not below 0, and increase"
        )));
    }
    let last = f64::from(curve.steps - 1);
    Ok((0..curve.steps)
        .map(|i| from + (to - from) * (f64::from(i) / last))
        .collect())
}

#[derive(Serialize)]
struct Report {
    format: &'static str,
    title: String,
    method: &'static str,
    setting: &'static str,
    start_heights: usize,
    height_range: f64,
    least: &'static str,
    best: PointReport,
    best_at_own_height: PointReport,
    curve: Vec<PointReport>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    files: Vec<String>,
}

#[derive(Serialize, Clone, Copy)]
struct PointReport {
    value_n_s_per_m: f64,
    mean_force_error_percent: SpreadReport,
    absolute_leak_j: SpreadReport,
    diverged: usize,
}

#[derive(Serialize, Clone, Copy)]
struct SpreadReport {
    own: f64,
    median: f64,
    worst: f64,
}

impl From<Spread> for SpreadReport {
    fn from(spread: Spread) -> Self {
        Self {
            own: spread.own,
            median: spread.median,
            worst: spread.worst,
        }
    }
}

impl From<&TunedPoint> for PointReport {
    fn from(point: &TunedPoint) -> Self {
        Self {
            value_n_s_per_m: point.value,
            mean_force_error_percent: point.mean_force_error.into(),
            absolute_leak_j: point.leak.into(),
            diverged: point.diverged,
        }
    }
}

impl Report {
    fn new(
        scene: &Scene,
        method: MethodName,
        setting: Setting,
        least: Least,
        points: Vec<TunedPoint>,
    ) -> Self {
        let (objective, name) = match least {
            Least::Error => (Objective::Error, "error"),
            Least::Leak => (Objective::Leak, "leak"),
        };
        let best = tune::best(&points, objective).expect("two values at least");
        let own = |point: &TunedPoint| match objective {
            Objective::Error => point.mean_force_error.own,
            Objective::Leak => point.leak.own,
        };
        let at_own = points
            .iter()
            .min_by(|a, b| own(a).total_cmp(&own(b)))
            .expect("two values at least");
        Self {
            format: "palpate tune 1",
            title: scene.title.clone(),
            method: method.name(),
            setting: setting.key(),
            start_heights: HEIGHTS,
            height_range: HEIGHT_RANGE,
            least: name,
            best: best.into(),
            best_at_own_height: at_own.into(),
            curve: points.iter().map(PointReport::from).collect(),
            files: Vec::new(),
        }
    }

    fn figure(&self) -> Figure {
        let x: Vec<f64> = self
            .curve
            .iter()
            .map(|point| point.value_n_s_per_m)
            .collect();
        let series = |index, name: &str, value: &dyn Fn(&PointReport) -> f64| Series {
            name: name.into(),
            kind: Kind::Line,
            role: Role::Compared(index),
            x: x.clone(),
            y: self.curve.iter().map(value).collect(),
        };
        let best = self.best.value_n_s_per_m;
        let chosen = format!("chosen: {} N s/m", digits(best));
        let row = |y_label: &str, of: &dyn Fn(&PointReport) -> SpreadReport| {
            let mut all = vec![
                series(1, "own height", &|point| of(point).own),
                series(2, "worst height", &|point| of(point).worst),
                series(0, "median height", &|point| of(point).median),
            ];
            // The line of the chosen value, from the least to the greatest of all that is drawn.
            let heights = || all.iter().flat_map(|series| &series.y).copied();
            let heights = || heights().filter(|height| height.is_finite());
            let (least, most) = (
                heights().fold(f64::INFINITY, f64::min),
                heights().fold(f64::NEG_INFINITY, f64::max),
            );
            let mark = |name: &str, kind, x: Vec<f64>, y: Vec<f64>| Series {
                name: name.into(),
                kind,
                role: Role::Mark,
                x,
                y,
            };
            let at = of(&self.best).median;
            all.push(mark("", Kind::Line, vec![best, best], vec![least, most]));
            all.push(mark(&chosen, Kind::Points, vec![best], vec![at]));
            Row {
                y_label: y_label.into(),
                limits: Limits::Data,
                panels: vec![Panel { series: all }],
                ..Row::default()
            }
        };
        let error = self.best.mean_force_error_percent;
        Figure {
            title: format!(
                "{} with a {} of {} N s/m has the least {}: E {} % in the median, {} % at the worst height",
                self.method,
                words(self.setting),
                digits(best),
                self.least,
                percent(error.median),
                percent(error.worst)
            ),
            subtitle: self.title.clone(),
            footnote: Some(format!(
                "E: error of the mean force of each period. Leak: energy that the held force creates or takes \
                 away. {} start heights within ±{} % of the scene's gap; chosen by the median.",
                self.start_heights,
                100.0 * self.height_range
            )),
            x_label: format!("{} [N s/m]", words(self.setting)),
            x_decades: false,
            columns: Vec::new(),
            rows: vec![
                row("error E [%]", &|point| point.mean_force_error_percent),
                row("sum of leaks [mJ]", &|point| {
                    let leak = point.absolute_leak_j;
                    SpreadReport {
                        own: 1e3 * leak.own,
                        median: 1e3 * leak.median,
                        worst: 1e3 * leak.worst,
                    }
                }),
            ],
        }
    }
}

/// A scene key in words, without its unit.
fn words(key: &str) -> &'static str {
    match key {
        "damping_cap_n_s_per_m" => "damping cap",
        _ => "damping",
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.title)?;
        writeln!(
            f,
            "{} of {}, {} values, {} start heights within ±{} %\n",
            words(self.setting),
            self.method,
            self.curve.len(),
            self.start_heights,
            100.0 * self.height_range
        )?;
        let header = [
            &*format!("least {}", self.least),
            "N s/m",
            "E % own",
            "median",
            "worst",
            "|leak| mJ own",
            "median",
            "worst",
            "diverged",
        ];
        let mut table = plain_table(CellAlignment::Left, &header);
        for (name, point) in [
            ("in the median", &self.best),
            ("at the scene's own height", &self.best_at_own_height),
        ] {
            let (error, leak) = (point.mean_force_error_percent, point.absolute_leak_j);
            let in_millijoules = |leak: f64| number(Some(1e3 * leak), digits);
            table.add_row(vec![
                name.into(),
                number(Some(point.value_n_s_per_m), digits),
                number(Some(error.own), percent),
                number(Some(error.median), percent),
                number(Some(error.worst), percent),
                in_millijoules(leak.own),
                in_millijoules(leak.median),
                in_millijoules(leak.worst),
                number(Some(point.diverged as f64), |count| {
                    format!("{count} of {}", self.start_heights)
                }),
            ]);
        }
        writeln!(f, "{}\n", lines(&table))?;
        for file in &self.files {
            writeln!(f, "wrote {file}")?;
        }
        Ok(())
    }
}
