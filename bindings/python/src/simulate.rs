//! `simulate` and `compare`: scenes in closed loop.

use palpate::MethodName;
use palpate_scene::SetupError;
use palpate_sim::closed_loop::{Bench, LoopError};
use palpate_study::compare::{Comparison, SceneRows};
use palpate_study::report::{Report, Subject, actuator_of};
use pyo3::prelude::*;

use crate::columns::of_ideal;
use crate::interrupt::interruptible;
use crate::methods::chosen;
use crate::render::{Rendered, RenderedInPython};
use crate::scene::PyScene;

/// A method that cannot be run on a scene.
type Wrong = (MethodName, LoopError);

/// Simulates a scene by each method; by its own where none is named.
#[pyfunction]
pub fn simulate<'py>(
    py: Python<'py>,
    scene: &Bound<'py, PyScene>,
    method: Option<&Bound<'py, PyAny>>,
) -> PyResult<RenderedInPython<'py>> {
    let own = scene.get().scene();
    let methods = method.map_or_else(|| Ok(vec![own.method]), chosen)?;
    let simulated = own.clone();
    let rendered = interruptible(py, move |stop| {
        let scene = &simulated;
        let bench = Bench::new(scene).map_err(|error| (scene.method, error))?;
        let mut runs = Vec::with_capacity(methods.len());
        for method in methods {
            // Nobody waits for the others any more.
            if stop.is_raised() {
                break;
            }
            runs.push(bench.run(method).map_err(|error| (method, error))?);
        }
        let mut report = Report::new(&Subject::of(scene), bench.reference(), &runs);
        report.actuated(actuator_of(scene));
        let ideal = of_ideal(bench.reference());
        Ok::<_, Wrong>(Rendered::of(&report, ideal, runs))
    })?;
    let rendered = rendered.map_err(|(method, error)| scene.get().wrong(method, &error))?;
    rendered.into_python(py)
}

/// Runs each method on each scene: the report as JSON and as text.
#[pyfunction]
pub fn compare(
    py: Python<'_>,
    scenes: Vec<Py<PyScene>>,
    method: &Bound<'_, PyAny>,
) -> PyResult<(String, String)> {
    let methods = chosen(method)?;
    let compared: Vec<_> = scenes
        .iter()
        .map(|scene| (scene.get().name.clone(), scene.get().scene().clone()))
        .collect();
    let compared = interruptible(py, move |stop| {
        let mut rows = Vec::with_capacity(compared.len());
        for (place, (name, scene)) in compared.into_iter().enumerate() {
            let wrong = |method, error| (place, (method, error));
            let bench = Bench::new(&scene).map_err(|error| wrong(scene.method, error))?;
            let mut outcomes = Vec::with_capacity(methods.len());
            for &method in methods.iter().take_while(|_| !stop.is_raised()) {
                outcomes.push(match bench.run(method) {
                    Ok(run) => (method, Ok(run)),
                    Err(LoopError::Setup(error)) => (method, Err(cannot(&error))),
                    Err(error) => return Err(wrong(method, error)),
                });
            }
            rows.push(SceneRows::of(
                name,
                &Subject::of(&scene),
                bench.reference(),
                outcomes,
            ));
        }
        let comparison = Comparison::of(rows);
        Ok((palpate_study::json(&comparison), comparison.to_string()))
    })?;
    compared.map_err(|(place, (method, error)): (usize, Wrong)| {
        scenes[place].get().wrong(method, &error)
    })
}

fn cannot(error: &SetupError) -> String {
    match error {
        SetupError::Parameter(parameter) => parameter.to_string(),
        SetupError::Settings(settings) => settings.to_string(),
    }
}
