//! `simulate` for worlds.

use numpy::PyArray3;
use palpate_scene::world::WorldScene;
use palpate_sim::world::{WorldBench, WorldBenchError};
use palpate_study::world::WorldReport;
use palpate_world::{Vector, WorldError};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyString;

use crate::interrupt::interruptible;
use crate::names::refused;
use crate::world::PyWorld;

/// Forces of all devices over all intervals.
type Forces<'py> = Bound<'py, PyArray3<f64>>;
/// The report as JSON and text; the edges of the intervals; the forces of each method; and the mean forces of the ideal.
type Judged<'py> = (
    String,
    String,
    Vec<f64>,
    Vec<(String, Forces<'py>)>,
    Forces<'py>,
);

/// Simulates a world by each method; by its own where none is named.
#[pyfunction]
pub fn simulate_world<'py>(
    py: Python<'py>,
    world: &Bound<'py, PyWorld>,
    method: Option<&Bound<'py, PyAny>>,
) -> PyResult<Judged<'py>> {
    let scene = world.borrow().scene().clone();
    let methods = methods(&world.borrow(), method)?;
    let mut renderers = Vec::with_capacity(methods.len());
    for method in methods {
        // What is wrong with a method is said before the ideal is computed.
        let renderer = scene
            .renderer(&method)
            .map_err(|faults: Vec<WorldError>| world.borrow().wrong(&faults))?;
        renderers.push((method, renderer));
    }
    let judged = interruptible(py, move |stop| {
        let bench = WorldBench::new(&scene)?;
        let mut runs = Vec::with_capacity(renderers.len());
        for (method, renderer) in &renderers {
            stop.leave_if_raised();
            runs.push(bench.run(method, renderer)?);
        }
        let report = WorldReport::new(&scene, &bench, &runs);
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
        let ideal: Vec<_> = ideal.collect();
        let forces: Vec<_> = runs
            .into_iter()
            .map(|run| (run.method, run.delivered))
            .collect();
        Ok::<_, WorldBenchError>((
            palpate_study::json(&report),
            report.to_string(),
            edges,
            forces,
            ideal,
        ))
    })?;
    let (json, text, edges, forces, ideal) =
        judged.map_err(|error| refused(format!("{}: {error}", world.borrow().name)))?;
    let forces: PyResult<Vec<_>> = forces
        .into_iter()
        .map(|(method, forces)| Ok((method, of_devices(py, &forces)?)))
        .collect();
    Ok((json, text, edges, forces?, of_devices(py, &ideal)?))
}

fn of_devices<'py>(py: Python<'py>, forces: &[Vec<Vector>]) -> PyResult<Forces<'py>> {
    let of_device = |forces: &Vec<Vector>| forces.iter().map(|force| force.to_vec()).collect();
    let forces: Vec<Vec<Vec<f64>>> = forces.iter().map(of_device).collect();
    Ok(PyArray3::from_vec3(py, &forces)?)
}

/// The names of the methods: those that are given, or the world's own. All are those for which it has every setting.
fn methods(world: &PyWorld, given: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<String>> {
    let Some(given) = given else {
        return Ok(vec![world.method.clone()]);
    };
    let scene = world.scene();
    if given.is_callable() {
        return Err(PyTypeError::new_err(
            "a method of your own runs on scenes of one contact, not on worlds",
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
        return Err(refused("method names no method"));
    }
    Ok(names)
}
