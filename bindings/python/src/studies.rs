//! Studies of many runs: `tune`, `heights` and `sweep`.

use palpate_core::MethodName;
use palpate_scene::Scene;
use palpate_study::heights::over_heights;
use palpate_study::heights::report::{HeightsReport, SceneReport};
use palpate_study::studied::{Studied, StudyError};
use palpate_study::suite::Column;
use palpate_study::sweep::report::SweepReport;
use palpate_study::sweep::{Quantity, SweepError, sweep as swept};
use palpate_study::tune as tuning;
use palpate_study::tune::report::TuneReport;
use palpate_study::tune::{Objective, TuneError};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::figures::drawn;
use crate::interrupt::interruptible;
use crate::methods::chosen;
use crate::names::refused;
use crate::scene::PyScene;

/// A report as JSON and as text.
type Said = (String, String);

/// A report as JSON, as text and as a figure.
pub type Shown = (String, String, String);

/// Creates threads for one study. A shared pool would be lost in a forked process.
pub fn threads() -> PyResult<ThreadPool> {
    ThreadPoolBuilder::new()
        .build()
        .map_err(|error| PyRuntimeError::new_err(format!("cannot start threads: {error}")))
}

/// Evaluates a method at values of its damping `[N s/m]`, by default at `steps` standard values.
#[pyfunction]
pub fn tune(
    py: Python<'_>,
    scene: &Bound<'_, PyScene>,
    method: Option<&Bound<'_, PyAny>>,
    values: Option<Vec<f64>>,
    steps: u32,
    least: &str,
) -> PyResult<Shown> {
    let own: Scene = scene.get().scene().clone();
    let methods = method.map_or_else(|| Ok(vec![own.method]), chosen)?;
    let &[method] = methods.as_slice() else {
        return Err(refused("tune evaluates one method; name it with method"));
    };
    let setting = tuning::tunable(method).ok_or_else(|| {
        refused(format!(
            "{}; name one with method",
            TuneError::NothingToTune(method)
        ))
    })?;
    let objective = [Objective::Error, Objective::Leak]
        .into_iter()
        .find(|objective| objective.name() == least)
        .ok_or_else(|| {
            refused(format!(
                "least is \"{least}\", but must be \"error\" or \"leak\""
            ))
        })?;
    let values = match values {
        Some(values) if values.is_empty() => return Err(refused("values is empty")),
        Some(values) => values,
        None if steps < 2 => {
            return Err(refused(format!("steps is {steps}, but must be 2 or more")));
        }
        None => {
            let to = tuning::usual_most(&own, method, setting.key);
            let from = tuning::usual_least(setting.key, to, steps);
            let last = f64::from(steps - 1);
            (0..steps)
                .map(|i| from + (to - from) * (f64::from(i) / last))
                .collect()
        }
    };
    let tuned = interruptible(py, move |stop| {
        let points = tuning::tune(&own, method, &values, || stop.leave_if_raised())?;
        Ok(TuneReport::new(&own, method, setting, objective, points))
    })?;
    let report = tuned.map_err(|error| match error {
        TuneError::Loop(error) => scene.get().wrong(method, &error),
        other => refused(other),
    })?;
    let figure = drawn(&palpate_plot::tune(&report)).map_err(refused)?;
    Ok((palpate_study::json(&report), report.to_string(), figure))
}

/// Evaluates methods on scenes from every start height.
#[pyfunction]
pub fn heights(
    py: Python<'_>,
    scenes: Vec<Py<PyScene>>,
    method: &Bound<'_, PyAny>,
    model_mass_factor: f64,
) -> PyResult<Said> {
    if !(model_mass_factor.is_finite() && model_mass_factor > 0.0) {
        return Err(refused(format!(
            "model_mass_factor is {model_mass_factor}, but must be finite and greater than 0"
        )));
    }
    let columns: Vec<_> = chosen(method)?.into_iter().map(Column::new).collect();
    let evaluated: Vec<Scene> = scenes
        .iter()
        .map(|scene| scene.get().scene().clone())
        .collect();
    let threads = threads()?;
    let found = interruptible(py, move |stop| {
        let mut reports = Vec::with_capacity(evaluated.len());
        for (place, scene) in evaluated.into_iter().enumerate() {
            let scene = scene.with_model_mass_factor(model_mass_factor);
            let found = threads
                .install(|| over_heights(&scene, &columns, || stop.leave_if_raised()))
                .map_err(|error| (place, scene.method, error))?;
            reports.push(SceneReport::new(&scene, &columns, &found));
        }
        let report = HeightsReport::new(model_mass_factor, reports);
        Ok((palpate_study::json(&report), report.to_string()))
    })?;
    found.map_err(|(place, method, error): (usize, MethodName, StudyError)| {
        let scene = scenes[place].get();
        match error {
            StudyError::Contact(error) => scene.wrong(method, &error),
            other => refused(format!("{}: {other}", scene.name)),
        }
    })
}

/// Evaluates methods on a scene at several values of one quantity.
#[pyfunction]
pub fn sweep(
    py: Python<'_>,
    scene: &Bound<'_, PyScene>,
    over: &str,
    values: Vec<f64>,
    method: Option<&Bound<'_, PyAny>>,
    heights: bool,
) -> PyResult<Said> {
    let quantity = Quantity::ALL.into_iter().find(|known| known.name() == over);
    let quantity = quantity.ok_or_else(|| {
        let names = Quantity::ALL.map(Quantity::name).join("\", \"");
        refused(format!(
            "over is \"{over}\", but must be one of \"{names}\""
        ))
    })?;
    if values.is_empty() {
        return Err(refused("values is empty"));
    }
    let methods = match method {
        Some(method) => chosen(method)?,
        // By default, all methods that have the varied quantity.
        None => MethodName::ALL
            .into_iter()
            .filter(|method| quantity != Quantity::Damping || tuning::tunable(*method).is_some())
            .collect(),
    };
    let columns: Vec<_> = methods.iter().copied().map(Column::new).collect();
    let own: Scene = scene.get().scene().clone();
    let threads = threads()?;
    let said = interruptible(py, move |stop| {
        let done = || stop.leave_if_raised();
        let found = threads.install(|| swept(&own, quantity, &values, &columns, heights, done))?;
        let report = SweepReport::new(&own, quantity, &values, &columns, &found);
        Ok((palpate_study::json(&report), report.to_string()))
    })?;
    said.map_err(|error: SweepError| refused(format!("{}: {error}", scene.get().name)))
}
