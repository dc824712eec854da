//! `World`: several devices, bodies and contacts, in a loop of Python's own.

use std::path::PathBuf;

use numpy::{PyArray2, PyReadonlyArray2};
use palpate_rt::safety::{Safety, SafetyParams};
use palpate_scene::world::{WorldFile, WorldScene};
use palpate_world::{Effort, Place, Sample, Vector, WorldError, WorldRenderer, WorldState};
use pyo3::prelude::*;

use crate::bounded::{Answered, bound};
use crate::names::refused;
use crate::renderer::safety;
use crate::scene::messages;

/// Whether the text of a scene file says a world.
#[pyfunction]
pub fn is_world(text: &str) -> bool {
    WorldFile::is_one(text)
}

/// A world that has been read and checked, its renderer and its state.
#[pyclass(subclass, name = "World", module = "palpate._palpate")]
pub struct PyWorld {
    file: WorldFile,
    text: String,
    /// Whether its text is a file of somebody, at whose lines messages can point.
    is_file: bool,
    pub name: String,
    folder: PathBuf,
    pub method: String,
    limits: Limits,
    renderer: WorldRenderer,
    pub state: WorldState,
    safety: Vec<Safety>,
    last: Option<Answer>,
}

/// The limits of `palpate pipe`.
#[derive(Clone, Copy)]
struct Limits {
    /// None: infinite `[N]`.
    force: Option<f64>,
    soft_start: f64,
}

/// What a sample was answered.
struct Answer {
    forces: Vec<Vector>,
    limited: Vec<&'static str>,
    effort: Effort,
    fault: Option<String>,
    faulty: Option<String>,
}

/// Forces, limits, effort, fault and the device that it is of.
type Told<'py> = (
    Bound<'py, PyArray2<f64>>,
    Vec<&'static str>,
    (u32, u32, u32, bool),
    Option<String>,
    Option<String>,
);

impl PyWorld {
    /// The world and its loop as they were described.
    pub fn scene(&self) -> &WorldScene {
        &self.file.scene
    }

    /// The first of these faults, with its place where that is known.
    pub fn wrong(&self, faults: &[WorldError]) -> PyErr {
        wrong(&self.file, self.is_file, faults)
    }
}

fn wrong(file: &WorldFile, is_file: bool, faults: &[WorldError]) -> PyErr {
    let Some(first) = faults.first() else {
        return refused("the world cannot be rendered");
    };
    if is_file && first.place != Place::Method {
        return refused(file.at(first.place, first.field, first.to_string()));
    }
    let lines: Vec<_> = faults.iter().map(ToString::to_string).collect();
    refused(lines.join("\n"))
}

#[pymethods]
impl PyWorld {
    /// A world from its text; `name` is what messages and reports call it.
    #[new]
    #[pyo3(signature = (text, name, folder, method, force_limit, soft_start))]
    fn new(
        text: String,
        name: Option<String>,
        folder: PathBuf,
        method: Option<String>,
        force_limit: Option<f64>,
        soft_start: f64,
    ) -> PyResult<Self> {
        let called = name.clone().unwrap_or_else(|| "world".into());
        let file = WorldFile::parse(&called, &text).map_err(|errors| {
            refused(if name.is_some() {
                errors.to_string()
            } else {
                messages(&errors)
            })
        })?;
        let is_file = name.is_some();
        let mut scene = file.scene.clone();
        let method = method.unwrap_or_else(|| scene.render.method.clone());
        let default = SafetyParams::default().largest_force;
        let force = force_limit.or(scene.render.force_limit).unwrap_or(default);
        let limits = Limits {
            // An infinite limit is none.
            force: (force != f64::INFINITY).then_some(force),
            soft_start,
        };
        scene.render.force_limit = limits.force;
        let renderer = scene
            .renderer(&method)
            .map_err(|faults| wrong(&file, is_file, &faults))?;
        let mut world = Self {
            state: renderer.start(),
            renderer,
            name: name.unwrap_or_else(|| file.scene.title.clone()),
            is_file,
            file,
            text,
            folder,
            method,
            limits,
            safety: Vec::new(),
            last: None,
        };
        world.reset()?;
        Ok(world)
    }

    /// One tick: a row of three coordinates for each device in, its force out, row by row.
    #[pyo3(signature = (positions, elapsed=None))]
    fn tick<'py>(
        &mut self,
        py: Python<'py>,
        positions: PyReadonlyArray2<'py, f64>,
        elapsed: Option<f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let positions = positions.as_array();
        let tools = &self.scene().world.tools;
        if let Some(tool) = tools.iter().find(|tool| tool.turns) {
            return Err(refused(format!(
                "device \"{}\" has six axes, and step() takes devices of three so far; palpate pipe takes it",
                tool.name
            )));
        }
        if positions.shape() != [tools.len(), 3] {
            return Err(refused(format!(
                "positions has {} rows of {} numbers, but must have {} of 3, one for each device",
                positions.shape()[0],
                positions.shape()[1],
                tools.len()
            )));
        }
        let positions: Vec<Vector> = positions
            .outer_iter()
            .map(|row| [row[0], row[1], row[2]])
            .collect();
        let sample = Sample {
            elapsed,
            ..Sample::at(&positions)
        };
        let output = self.renderer.step(&mut self.state, &sample);
        let (fault, effort, limited) = (output.fault, output.effort, output.limited);
        let mut forces = output.forces.to_vec();
        let answered = Answered {
            elapsed,
            positions: &positions,
            is_refused: fault.is_some(),
            limited,
        };
        let limited = bound(&answered, &mut self.safety, &mut forces);
        for (tool, force) in forces.iter().enumerate() {
            self.renderer.report_sent(&mut self.state, tool, *force);
        }
        let name = |tool: usize| self.file.scene.world.tools[tool].name.clone();
        let answer = Answer {
            limited,
            effort,
            fault: fault.map(|fault| fault.fault.name().to_owned()),
            faulty: fault.and_then(|fault| fault.tool).map(name),
            forces,
        };
        let held = rows(py, &answer.forces)?;
        self.last = Some(answer);
        Ok(held)
    }

    /// Says what was really sent to a device for the last sample `[N]`.
    fn tell_sent(&mut self, tool: usize, force: Vector) {
        self.renderer.report_sent(&mut self.state, tool, force);
    }

    /// Begins anew: bodies at their start, nothing sampled, the books empty.
    fn reset(&mut self) -> PyResult<()> {
        let period = self.scene().timing.period;
        let Limits { force, soft_start } = self.limits;
        let devices = 0..self.scene().devices.len();
        self.safety = devices
            .map(|_| safety(force, soft_start, period))
            .collect::<PyResult<_>>()?;
        self.state = self.renderer.start();
        self.last = None;
        Ok(())
    }

    /// What was answered to the last sample: None before the first.
    fn told<'py>(&self, py: Python<'py>) -> PyResult<Option<Told<'py>>> {
        let Some(answer) = &self.last else {
            return Ok(None);
        };
        let Effort {
            sub_steps,
            refined,
            unrefined,
            too_fast,
            ..
        } = answer.effort;
        Ok(Some((
            rows(py, &answer.forces)?,
            answer.limited.clone(),
            (sub_steps, refined, unrefined, too_fast),
            answer.fault.clone(),
            answer.faulty.clone(),
        )))
    }

    /// A line for tables and figures.
    #[getter]
    fn title(&self) -> &str {
        &self.scene().title
    }

    /// Name of the method.
    #[getter]
    fn method(&self) -> &str {
        &self.method
    }

    /// Nominal time from sample to sample `[s]`.
    #[getter]
    fn period(&self) -> f64 {
        self.scene().timing.period
    }

    /// Names of the devices and of the bodies, in the order of the file.
    fn names(&self) -> (Vec<&str>, Vec<&str>) {
        let world = &self.scene().world;
        (
            world.tools.iter().map(|tool| tool.name.as_str()).collect(),
            world.bodies.iter().map(|body| body.name.as_str()).collect(),
        )
    }

    /// Its text, its name if its text is a file, and its folder: what it is made from.
    fn parts(&self) -> (&str, Option<&str>, &PathBuf) {
        (
            &self.text,
            self.is_file.then_some(&*self.name),
            &self.folder,
        )
    }
}

/// A row for each vector.
pub fn rows<'py>(py: Python<'py>, vectors: &[Vector]) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let rows: Vec<Vec<f64>> = vectors.iter().map(|row| row.to_vec()).collect();
    Ok(PyArray2::from_vec2(py, &rows)?)
}
