//! `simulate` and `compare`: scenes in closed loop.

use palpate_core::MethodName;
use palpate_plot::Devices;
use palpate_scene::SetupError;
use palpate_study::compare::{Comparison, SceneRows};
use palpate_study::report::{Report, Subject, actuator_of};
use palpate_study::sim::closed_loop::{Bench, LoopError};
use pyo3::prelude::*;

use crate::columns::of_ideal;
use crate::figures::{drawn, of_runs};
use crate::interrupt::interruptible;
use crate::methods::{Chosen, chosen, chosen_or_own};
use crate::names::refused;
use crate::own_method::OwnError;
use crate::render::{Rendered, RenderedInPython};
use crate::scene::PyScene;

/// Reason why a method did not run on a scene.
enum Wrong {
    /// The scene cannot be run, or not by this method.
    Scene(MethodName, LoopError),
    /// Exception of a Python function.
    Raised(PyErr),
}

impl Wrong {
    fn on(self, scene: &PyScene) -> PyErr {
        match self {
            Self::Scene(method, error) => scene.wrong(method, &error),
            Self::Raised(error) => error,
        }
    }
}

/// Simulates a scene by each method, by default by its own.
#[pyfunction]
pub fn simulate<'py>(
    py: Python<'py>,
    scene: &Bound<'py, PyScene>,
    method: Option<&Bound<'py, PyAny>>,
) -> PyResult<RenderedInPython<'py>> {
    let own = scene.get().scene();
    let methods = method.map_or_else(|| Ok(vec![Chosen::BuiltIn(own.method)]), chosen_or_own)?;
    let simulated = own.clone();
    let rendered = interruptible(py, move |stop| {
        let scene = &simulated;
        let bench = Bench::new(scene).map_err(|error| Wrong::Scene(scene.method, error))?;
        let mut runs = Vec::with_capacity(methods.len());
        for method in methods {
            stop.leave_if_raised();
            runs.push(match method {
                Chosen::BuiltIn(method) => bench
                    .run(method)
                    .map_err(|error| Wrong::Scene(method, error))?,
                Chosen::Own(own) => own.run(&bench, stop).map_err(|error| match error {
                    OwnError::Loop(error) => Wrong::Scene(scene.method, error),
                    OwnError::Raised(error) => Wrong::Raised(error),
                })?,
            });
        }
        let mut report = Report::new(&Subject::new(scene), bench.reference(), &runs);
        report.actuated(actuator_of(scene));
        let ideal = of_ideal(bench.reference());
        Ok::<_, Wrong>(Rendered::of(&report, ideal, runs))
    })?;
    let rendered = rendered.map_err(|error| error.on(scene.get()))?;
    rendered.into_python(py)
}

/// Returns the figure of a scene simulated by built-in methods, by default by its own.
#[pyfunction]
pub fn simulate_figure(
    py: Python<'_>,
    scene: &Bound<'_, PyScene>,
    method: Option<&Bound<'_, PyAny>>,
) -> PyResult<String> {
    let own = scene.get().scene();
    let methods = method.map_or_else(|| Ok(vec![own.method]), chosen)?;
    let simulated = own.clone();
    let figure = interruptible(py, move |stop| {
        let scene = &simulated;
        let bench = Bench::new(scene).map_err(|error| Wrong::Scene(scene.method, error))?;
        let mut runs = Vec::with_capacity(methods.len());
        for method in methods {
            stop.leave_if_raised();
            let run = bench.run(method);
            runs.push(run.map_err(|error| Wrong::Scene(method, error))?);
        }
        Ok(of_runs(
            &scene.title,
            bench.reference(),
            &runs,
            Devices::OfEachRun,
        ))
    })?;
    let figure = figure.map_err(|error: Wrong| error.on(scene.get()))?;
    figure.map_err(refused)
}

/// Runs each method on each scene and returns the report as JSON, as text and as a figure.
#[pyfunction]
pub fn compare(
    py: Python<'_>,
    scenes: Vec<Py<PyScene>>,
    method: &Bound<'_, PyAny>,
) -> PyResult<(String, String, String)> {
    let methods = chosen(method)?;
    if scenes.is_empty() {
        return Err(refused("scenes is empty, but must have 1 scene or more"));
    }
    let compared: Vec<_> = scenes
        .iter()
        .map(|scene| (scene.get().name.clone(), scene.get().scene().clone()))
        .collect();
    let compared = interruptible(py, move |stop| {
        let mut rows = Vec::with_capacity(compared.len());
        for (place, (name, scene)) in compared.into_iter().enumerate() {
            let wrong = |method, error| (place, Wrong::Scene(method, error));
            let bench = Bench::new(&scene).map_err(|error| wrong(scene.method, error))?;
            let mut outcomes = Vec::with_capacity(methods.len());
            for &method in &methods {
                stop.leave_if_raised();
                outcomes.push(match bench.run(method) {
                    Ok(run) => (method, Ok(run)),
                    Err(LoopError::Setup(error)) => (method, Err(cannot(&error))),
                    Err(error) => return Err(wrong(method, error)),
                });
            }
            rows.push(SceneRows::new(
                name,
                &Subject::new(&scene),
                bench.reference(),
                outcomes,
            ));
        }
        let comparison = Comparison::new(rows);
        Ok(comparison)
    })?;
    let comparison =
        compared.map_err(|(place, error): (usize, Wrong)| error.on(scenes[place].get()))?;
    let figure = drawn(&palpate_plot::compared(&comparison)).map_err(refused)?;
    let json = palpate_study::json(&comparison);
    Ok((json, comparison.to_string(), figure))
}

fn cannot(error: &SetupError) -> String {
    error.to_string()
}
