//! `simulate` and `replay` for worlds.

use numpy::PyArray3;
use palpate_record::recording::Recording;
use palpate_scene::world::WorldScene;
use palpate_study::device_loop::{RecordedWorld, RecordedWorldError};
use palpate_study::recording::WorldPathError;
use palpate_study::sim::world::{WorldBench, WorldBenchError};
use palpate_study::world::WorldReport;
use palpate_world::{Vector, WorldErrors, WorldRenderer};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyString;

use crate::figures::drawn;
use crate::interrupt::{Stop, interruptible};
use crate::names::refused;
use crate::replay::{lacking, unread};
use crate::world::{PyWorld, wrong};

/// Forces of all devices over all intervals.
type Forces<'py> = Bound<'py, PyArray3<f64>>;
/// Report as JSON and text, and its figure; edges of the intervals; forces of each method; mean forces of the reference
/// solution.
pub type Evaluated<'py> = (
    String,
    String,
    Option<String>,
    Vec<f64>,
    Vec<(String, Forces<'py>)>,
    Forces<'py>,
);

/// Simulates a world by each method, by default by its own.
#[pyfunction]
pub fn simulate_world<'py>(
    py: Python<'py>,
    world: &Bound<'py, PyWorld>,
    method: Option<&Bound<'py, PyAny>>,
) -> PyResult<Evaluated<'py>> {
    let scene = world.borrow().scene().clone();
    let is_all = is_all(method);
    let methods = methods(&scene, &world.borrow().method, method)?;
    let renderers = renderers(&scene, methods).map_err(|faults| world.borrow().wrong(&faults))?;
    let evaluated = interruptible(py, move |stop| {
        evaluate(WorldBench::new(&scene)?, &scene, (&renderers, is_all), stop)
    })?;
    let evaluated =
        evaluated.map_err(|error| refused(format!("{}: {error}", world.borrow().name)))?;
    evaluated.into_python(py)
}

/// Renders the recorded motion of a world by each method, by default by its own, and returns the result with warnings.
pub fn replay_world<'py>(
    py: Python<'py>,
    recording: Recording,
    method: Option<&Bound<'py, PyAny>>,
) -> PyResult<(Evaluated<'py>, Vec<String>)> {
    let name = recording.path().display().to_string();
    let recorded = py.detach(|| RecordedWorld::new(&recording));
    let recorded = recorded.map_err(|error| match error {
        RecordedWorldError::Path(WorldPathError::Recording(error)) => unread(error),
        other => refused(other),
    })?;
    let gaps = recorded.gaps().map(|gaps| format!("{name}: {gaps}"));
    let RecordedWorld { file, path, .. } = recorded;
    let scene = file.scene.led();
    let is_all = is_all(method);
    let methods = methods(&scene, &scene.render.method, method)?;
    let renderers = renderers(&scene, methods).map_err(|faults| wrong(&file, true, &faults))?;
    let (evaluated, warnings) = interruptible(py, move |stop| {
        let mut warnings: Vec<_> = gaps.into_iter().collect();
        warnings.extend(lacking(&recording));
        let evaluated = WorldBench::led(&scene, path)
            .and_then(|bench| evaluate(bench, &scene, (&renderers, is_all), stop))
            .map_err(|error| refused(format!("{name}: {error}")))?;
        Ok::<_, PyErr>((evaluated, warnings))
    })??;
    Ok((evaluated.into_python(py)?, warnings))
}

/// Creates a renderer for each method, so that a wrong method is reported before the reference solution is computed.
fn renderers(
    scene: &WorldScene,
    methods: Vec<String>,
) -> Result<Vec<(String, WorldRenderer)>, WorldErrors> {
    let named = methods.into_iter().map(|method| {
        let renderer = scene.renderer(&method)?;
        Ok((method, renderer))
    });
    named.collect()
}

/// Results of a world before their conversion to Python.
struct OfAWorld {
    json: String,
    text: String,
    /// None if it does not fit its size.
    figure: Option<String>,
    edges: Vec<f64>,
    forces: Vec<(String, Vec<Vec<Vector>>)>,
    ideal: Vec<Vec<Vector>>,
}

/// Runs each method on a bench.
fn evaluate(
    bench: WorldBench,
    scene: &WorldScene,
    (renderers, is_all): (&[(String, WorldRenderer)], bool),
    stop: &Stop,
) -> Result<OfAWorld, WorldBenchError> {
    let mut runs = Vec::with_capacity(renderers.len());
    for (method, renderer) in renderers {
        stop.leave_if_raised();
        runs.push(bench.run(method, renderer)?);
    }
    let mut report = WorldReport::new(scene, &bench, &runs);
    if is_all {
        report.all_methods(scene);
    }
    let grid = &bench.ideal().grid;
    let edges = (0..=grid.intervals()).map(|edge| grid.edge(edge)).collect();
    let ideal = bench.ideal().devices.iter().map(|device| {
        let impulses = device.impulses.iter().enumerate();
        let means = impulses.map(|(interval, impulse)| {
            let duration = grid.edge(interval + 1) - grid.edge(interval);
            impulse.map(|component| component / duration)
        });
        means.collect::<Vec<Vector>>()
    });
    Ok(OfAWorld {
        json: palpate_study::json(&report),
        text: report.to_string(),
        figure: drawn(&palpate_plot::world(scene, &bench, &runs)).ok(),
        edges,
        ideal: ideal.collect(),
        forces: runs
            .into_iter()
            .map(|run| (run.method, run.delivered))
            .collect(),
    })
}

impl OfAWorld {
    fn into_python(self, py: Python<'_>) -> PyResult<Evaluated<'_>> {
        let forces = self.forces.into_iter();
        let forces = forces.map(|(method, forces)| Ok((method, of_devices(py, &forces)?)));
        let forces: PyResult<Vec<_>> = forces.collect();
        let ideal = of_devices(py, &self.ideal)?;
        Ok((
            self.json,
            self.text,
            self.figure,
            self.edges,
            forces?,
            ideal,
        ))
    }
}

fn of_devices<'py>(py: Python<'py>, forces: &[Vec<Vector>]) -> PyResult<Forces<'py>> {
    let of_device = |forces: &Vec<Vector>| forces.iter().map(|force| force.to_vec()).collect();
    let forces: Vec<Vec<Vec<f64>>> = forces.iter().map(of_device).collect();
    Ok(PyArray3::from_vec3(py, &forces)?)
}

/// Whether `all` selects every method for which the world has settings.
fn is_all(given: Option<&Bound<'_, PyAny>>) -> bool {
    let name = given.and_then(|given| given.extract::<String>().ok());
    name.as_deref() == Some("all")
}

/// Returns the names of the given methods, by default the world's own. `all` selects every method with all its
/// settings.
fn methods(
    scene: &WorldScene,
    own: &str,
    given: Option<&Bound<'_, PyAny>>,
) -> PyResult<Vec<String>> {
    let Some(given) = given else {
        return Ok(vec![own.to_owned()]);
    };
    if given.is_callable() {
        return Err(PyTypeError::new_err(
            "a user-defined method runs on scenes of one contact, not on worlds",
        ));
    }
    let names: Vec<String> = match given.cast::<PyString>() {
        Ok(name) => vec![name.to_string()],
        Err(_) => given.extract()?,
    };
    if names == ["all"] {
        let all = WorldScene::METHODS.into_iter();
        let possible = all.filter(|name| scene.method(name).is_ok());
        return Ok(possible.map(str::to_owned).collect());
    }
    if names.is_empty() {
        return Err(refused("method is empty; name a method"));
    }
    Ok(names)
}
