//! `palpate tune`: how a method's error and leak depend on its damping.

use palpate_scene::Scene;
use palpate_scene::method::{MethodName, SettingKey};
use palpate_study::tune::report::{PointReport, SpreadReport, TuneReport};
use palpate_study::tune::{self, HEIGHTS, Objective, TuneError};

use super::simulate::{explain, read_scene};
use crate::arguments::{CurveArguments, Least, TuneArguments, flag_of_setting};
use crate::failure::Failure;
use crate::progress::Progress;
use crate::results::{draw, print_report};
use palpate_figure::{Figure, Kind, Limits, Panel, Role, Row, Series};
use palpate_study::text::{digits, percent};

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
    if flags.settings().has(setting.key) {
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
    let values = values(&arguments.curve, &scene, method, setting.key)?;
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

    let objective = match arguments.curve.least {
        Least::Error => Objective::Error,
        Least::Leak => Objective::Leak,
    };
    let mut report = TuneReport::new(&scene, method, setting, objective, points);
    if let Some(path) = &arguments.picture.plot {
        draw(&outputs, path, &figure(&report), arguments.picture.size)?;
        report.wrote(path);
    }
    print_report(&report, arguments.json)
}

/// The values to try `[N s/m]`.
fn values(
    curve: &CurveArguments,
    scene: &Scene,
    method: MethodName,
    setting: SettingKey,
) -> Result<Vec<f64>, Failure> {
    let to = curve
        .to
        .unwrap_or_else(|| tune::usual_most(scene, method, setting));
    let from = curve
        .from
        .unwrap_or_else(|| tune::usual_least(setting, to, curve.steps));
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

/// The curves of a report, over the values, and the chosen value.
fn figure(report: &TuneReport) -> Figure {
    let x: Vec<f64> = report
        .curve
        .iter()
        .map(|point| point.value_n_s_per_m)
        .collect();
    let series = |index, name: &str, value: &dyn Fn(&PointReport) -> f64| Series {
        name: name.into(),
        kind: Kind::Line,
        role: Role::Compared(index),
        x: x.clone(),
        y: report.curve.iter().map(value).collect(),
    };
    let best = report.best.value_n_s_per_m;
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
        let at = of(&report.best).median;
        all.push(mark("", Kind::Line, vec![best, best], vec![least, most]));
        all.push(mark(&chosen, Kind::Points, vec![best], vec![at]));
        Row {
            y_label: y_label.into(),
            limits: Limits::Data,
            panels: vec![Panel { series: all }],
            ..Row::default()
        }
    };
    let error = report.best.mean_force_error_percent;
    Figure {
        title: format!(
            "{} with a {} of {} N s/m has the least {}: E {} % in the median, {} % at the worst height",
            report.method,
            report.setting_in_words(),
            digits(best),
            report.least,
            percent(error.median),
            percent(error.worst)
        ),
        subtitle: report.title.clone(),
        footnote: Some(format!(
            "E: error of the mean force of each period. Leak: energy that the held force creates or takes \
             away. {} start heights within ±{} % of the scene's gap; chosen by the median.",
            report.start_heights,
            100.0 * report.height_range
        )),
        x_label: format!("{} [N s/m]", report.setting_in_words()),
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
