//! `World`: several devices, bodies and contacts in a loop that Python owns.

use std::path::PathBuf;

use numpy::{PyArray2, PyReadonlyArray2};
use palpate_device::Wrench;
use palpate_rt::BoundedWorld;
use palpate_rt::safety::SafetyParams;
use palpate_scene::SceneFile;
use palpate_scene::world::{WorldFile, WorldScene};
use palpate_world::{Effort, Quaternion, Tool, Vector, WorldErrors, WorldPart, WorldState};
use pyo3::prelude::*;

use crate::arrays;
use crate::bounded::{Now, Placed, Poses};
use crate::contact::safety_params;
use crate::names::refused;
use crate::scene::messages;

/// Whether the world renderer renders the scene of a text, rather than the closed form of one contact along one axis.
/// `False` too for a text without the tables of a scene.
#[pyfunction]
pub fn is_world(text: &str) -> bool {
    SceneFile::is_world(text)
}

/// A checked world, its renderer and its state.
#[pyclass(subclass, name = "World", module = "palpate._palpate")]
pub struct PyWorld {
    file: WorldFile,
    text: String,
    /// Whether the text is a user's file, so that messages can point at its lines.
    is_file: bool,
    pub name: String,
    folder: PathBuf,
    pub method: String,
    /// Largest norm of a force `[N]`; None: no limit.
    pub force_limit: Option<f64>,
    /// Soft-start time `[s]`.
    pub soft_start: f64,
    now: Now,
    poses: Poses,
}

/// State of a world at a sample.
#[pyclass(frozen, name = "WorldState", module = "palpate._palpate")]
pub struct PyWorldState(pub Now);

/// Sub-steps, refined and unrefined ones, whether a contact is too fast, and the number of ignored triangles and points.
pub type EffortValues = (u32, u32, u32, bool, u32);

/// Converts to the tuple for Python.
pub fn effort_values(effort: Effort) -> EffortValues {
    let Effort {
        sub_steps,
        refined,
        unrefined,
        too_fast,
        left_out,
        ..
    } = effort;
    (sub_steps, refined, unrefined, too_fast, left_out)
}

/// Forces or wrenches, slopes, limits, effort, fault and its device.
type WorldResult<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
    Vec<&'static str>,
    EffortValues,
    Option<&'static str>,
    Option<String>,
);

impl PyWorld {
    /// Returns the described world and its loop.
    pub fn scene(&self) -> &WorldScene {
        &self.file.scene
    }

    /// Returns the text of the scene.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Returns the state of the world at the last sample.
    pub fn state(&self) -> &WorldState {
        self.now.bounded.state()
    }

    /// Returns the world at the last sample.
    pub fn now(&self) -> &Now {
        &self.now
    }

    /// Returns one row per wrench: only the force if no device gives a torque.
    fn held<'py>(
        &self,
        py: Python<'py>,
        wrenches: &[Wrench],
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let gives_torque = self.gives_torque();
        let rows = wrenches.iter().map(|wrench| {
            let torque = wrench.torque.into_iter().filter(|_| gives_torque);
            wrench.force.into_iter().chain(torque).collect()
        });
        let rows: Vec<Vec<f64>> = rows.collect();
        Ok(PyArray2::from_vec2(py, &rows)?)
    }

    /// Returns the error of the first fault, with its source location if it is known.
    pub fn wrong(&self, faults: &WorldErrors) -> PyErr {
        wrong(&self.file, self.is_file, faults)
    }
}

/// Returns the error of the first fault, with its source location if it is known and the text is a user's file.
pub fn wrong(file: &WorldFile, is_file: bool, faults: &WorldErrors) -> PyErr {
    let first = faults.first();
    if is_file && first.part != WorldPart::Method {
        return refused(file.at(first.part, first.field, first.to_string()));
    }
    refused(faults.to_string())
}

#[pymethods]
impl PyWorld {
    /// Parses a world. `name` is its name in messages and reports; mesh files are searched in `folder`.
    #[new]
    #[pyo3(signature = (text, name, folder, method, limits))]
    fn new(
        text: String,
        name: Option<String>,
        folder: PathBuf,
        method: Option<String>,
        limits: (Option<f64>, Option<f64>, f64),
    ) -> PyResult<Self> {
        let (force_limit, torque_limit, soft_start) = limits;
        let called = name.clone().unwrap_or_else(|| "world".into());
        let file = WorldFile::parse_in(&called, &text, &folder).map_err(|errors| {
            refused(if name.is_some() {
                errors.to_string()
            } else {
                messages(&errors)
            })
        })?;
        let is_file = name.is_some();
        let mut scene = file.scene.clone();
        let method = method.unwrap_or_else(|| scene.render.method.clone());
        let default = SafetyParams::default();
        scene.settle_limits(
            [force_limit, torque_limit],
            [default.largest_force, default.largest_torque],
        );
        let limits = safety_params(
            scene.render.force_limit,
            scene.render.torque_limit,
            soft_start,
        )?;
        let renderer = scene
            .renderer(&method)
            .map_err(|faults| wrong(&file, is_file, &faults))?;
        Ok(Self {
            force_limit: scene.render.force_limit,
            soft_start,
            now: Now::new(BoundedWorld::new(renderer, limits).map_err(refused)?),
            poses: Poses::default(),
            name: name.unwrap_or_else(|| file.scene.title.clone()),
            is_file,
            file,
            text,
            folder,
            method,
        })
    }

    /// Executes one tick: takes one row per device and returns one row per device. A sample row has three
    /// coordinates, or a pose if a device rotates; a result row has three force components, or a wrench if a device
    /// gives a torque.
    #[pyo3(signature = (poses, elapsed=None))]
    fn tick<'py>(
        &mut self,
        py: Python<'py>,
        poses: PyReadonlyArray2<'py, f64>,
        elapsed: Option<f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let poses = arrays::rows("positions", &poses)?;
        let (devices, width) = (self.scene().world.tools.len(), self.width());
        if poses.shape() != [devices, width] {
            return Err(refused(format!(
                "positions has {} rows of {} numbers, but must have {devices} of {width}, one for each device",
                poses.shape()[0],
                poses.shape()[1],
            )));
        }
        self.poses.take(poses.outer_iter(), width);
        let Self { now, poses, .. } = self;
        now.step(poses, elapsed);
        self.held(
            py,
            self.now.last.as_ref().map_or(&[], |last| &last.wrenches),
        )
    }

    /// Reports the wrench that was actually sent to a device for the last sample `[N]`, `[N m]`, and the slope of its
    /// force `[N/s]`.
    fn tell_sent(&mut self, tool: usize, force: Vector, torque: Vector, slope: Vector) {
        self.now
            .bounded
            .report_sent(tool, Wrench { force, torque }, slope);
    }

    /// Whether a device gives a torque: result rows then have 6 numbers instead of 3.
    pub fn gives_torque(&self) -> bool {
        self.scene().world.tools.iter().any(Tool::feels_torque)
    }

    /// Returns the number of entries of a sample row: 3, or 7 if a device has six axes.
    pub fn width(&self) -> usize {
        let tools = &self.scene().world.tools;
        if tools.iter().any(|tool| tool.turns) {
            7
        } else {
            3
        }
    }

    /// Resets the state: bodies at their start, no sample, an empty energy ledger.
    fn reset(&mut self) {
        self.now.reset();
    }

    /// Moves a body, by its number, to what is given of a position, an orientation, a velocity and an angular velocity.
    fn place(
        &mut self,
        body: usize,
        position: Option<Vector>,
        orientation: Option<Quaternion>,
        velocity: Option<Vector>,
        angular_velocity: Option<Vector>,
    ) -> PyResult<()> {
        let given = Placed {
            position,
            orientation,
            velocity,
            angular_velocity,
        };
        let to = self.now.moved(body, &given).map_err(refused)?;
        self.now.bounded.place(body, &to).map_err(refused)
    }

    /// Returns the state at the last sample.
    fn held_state(&self) -> PyWorldState {
        PyWorldState(self.now.clone())
    }

    /// Continues from a state of the same world.
    fn hold_state(&mut self, state: &PyWorldState) {
        self.now = state.0.clone();
    }

    /// Returns the result of the last sample, or None before the first.
    fn result<'py>(&self, py: Python<'py>) -> PyResult<Option<WorldResult<'py>>> {
        let Some(answer) = &self.now.last else {
            return Ok(None);
        };
        let tools = &self.scene().world.tools;
        let faulty = answer.fault.and_then(|fault| fault.tool);
        Ok(Some((
            self.held(py, &answer.wrenches)?,
            rows(py, &answer.slopes)?,
            answer.limits(),
            effort_values(answer.effort),
            answer.fault.map(|fault| fault.fault.name()),
            faulty.map(|tool| tools[tool].name.clone()),
        )))
    }

    /// Title for tables and figures.
    #[getter]
    fn title(&self) -> &str {
        &self.scene().title
    }

    /// Name of the method.
    #[getter]
    fn method(&self) -> &str {
        &self.method
    }

    /// Nominal sampling period `[s]`.
    #[getter]
    fn period(&self) -> f64 {
        self.scene().timing.period
    }

    /// Returns the names of devices and bodies, in the order of the file.
    fn names(&self) -> (Vec<&str>, Vec<&str>) {
        let world = &self.scene().world;
        (
            world.tools.iter().map(|tool| tool.name.as_str()).collect(),
            world.bodies.iter().map(|body| body.name.as_str()).collect(),
        )
    }

    /// Returns text, name if the text is a file, and folder, from which the world can be made again.
    fn parts(&self) -> (&str, Option<&str>, &PathBuf) {
        (
            &self.text,
            self.is_file.then_some(&*self.name),
            &self.folder,
        )
    }
}

/// Returns one row per vector.
pub fn rows<'py>(py: Python<'py>, vectors: &[Vector]) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let rows: Vec<Vec<f64>> = vectors.iter().map(|row| row.to_vec()).collect();
    Ok(PyArray2::from_vec2(py, &rows)?)
}
