//! `EngineContact`: contacts with the bodies of another physics engine, which Python steps.

use numpy::{PyArray2, PyReadonlyArray2};
use palpate_core::Actuation;
use palpate_device::Wrench;
use palpate_rt::{Answered, WorldSafety};
use palpate_world::engine::{
    BodyNow, BodyWrench, EngineBody, EngineRenderer, EngineState, PlacedShape, Stepping,
};
use palpate_world::{
    ContactLaw, CoupledParams, Mesh, Quaternion, Sample, Shape, Tool, Vector, WorldErrors,
    WorldLoop,
};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays;
use crate::bounded;
use crate::checked::above_zero;
use crate::contact::safety_params;
use crate::fields::read;
use crate::names::refused;
use crate::world::{EffortValues, effort_values, rows};

/// Shape name, its lengths, its pose in body axes, and points.
type GivenShape = (String, Vec<f64>, Vector, Quaternion, Vec<Vector>);
/// Number of entries in a body's row: position, orientation, velocity, angular velocity, acceleration, angular
/// acceleration, and the rows of its mobility.
pub const BODY: usize = 55;

/// Tools, bodies, their law and the loop, as passed by the Python files.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Description {
    tools: Vec<(String, f64)>,
    bodies: Vec<(String, Vec<GivenShape>)>,
    stiffness: f64,
    damping: f64,
    friction: f64,
    friction_stiffness: f64,
    friction_damping: f64,
    end_velocity: bool,
    period: f64,
    device_mass: Vec<Vector>,
    encoder_quantum: f64,
    delay: f64,
    lag: f64,
    gain: f64,
    force_limit: f64,
    soft_start: f64,
}

/// Contacts of tools with an engine's bodies, and their state.
#[pyclass(subclass, module = "palpate._palpate")]
pub struct EngineContact {
    renderer: EngineRenderer,
    state: EngineState,
    tools: Vec<String>,
    bodies: usize,
    safety: WorldSafety,
    sampled: Option<Sampled>,
    last: Option<Answer>,
}

/// Sample at the start of a period.
struct Sampled {
    positions: Vec<Vector>,
    elapsed: Option<f64>,
}

/// Result of a sample.
struct Answer {
    forces: Vec<Vector>,
    limited: Vec<&'static str>,
    effort: EffortValues,
    fault: Option<&'static str>,
}

/// Forces, limits, effort and fault.
type EngineResult<'py> = (
    Bound<'py, PyArray2<f64>>,
    Vec<&'static str>,
    EffortValues,
    Option<&'static str>,
);
/// Indices of tool and body, mode, point, normal, penetration and force.
type ContactNow = (usize, usize, &'static str, Vector, Vector, f64, Vector);
/// Entries of the energy ledger: contacts and devices.
type LedgerNow = (Vec<[f64; 9]>, Vec<[f64; 2]>);

/// Returns an error with all faults, one per line.
pub fn wrong(faults: &WorldErrors) -> PyErr {
    refused(faults.to_string())
}

fn shape((kind, lengths, position, orientation, points): GivenShape) -> PyResult<PlacedShape> {
    let shape = match (kind.as_str(), lengths.as_slice()) {
        ("sphere", &[radius]) => Shape::Sphere { radius },
        ("box", &[x, y, z]) => Shape::Box {
            half_extents: [x, y, z],
        },
        ("capsule", &[radius, half_length]) => Shape::Capsule {
            radius,
            half_length,
        },
        ("cylinder", &[radius, half_length]) => Shape::Cylinder {
            radius,
            half_length,
        },
        ("half-space", &[]) => Shape::HalfSpace {
            normal: [0.0, 0.0, 1.0],
            offset: 0.0,
        },
        ("hull", &[]) => Shape::Mesh(
            Mesh::convex(&points)
                .map_err(|error| refused(error.to_string()))?
                .into(),
        ),
        _ => {
            return Err(refused(format!(
                "there is no shape \"{kind}\" with {} lengths",
                lengths.len()
            )));
        }
    };
    Ok(PlacedShape {
        shape,
        position,
        orientation,
    })
}

/// Returns the body of a row of [`BODY`] numbers.
pub fn body(row: &[f64]) -> BodyNow {
    let three = |from: usize| [row[from], row[from + 1], row[from + 2]];
    let mut mobility = [[0.0; 6]; 6];
    for (numbers, row) in mobility.iter_mut().zip(row[19..].chunks_exact(6)) {
        numbers.copy_from_slice(row);
    }
    BodyNow {
        position: three(0),
        orientation: [row[3], row[4], row[5], row[6]],
        velocity: three(7),
        angular_velocity: three(10),
        acceleration: three(13),
        angular_acceleration: three(16),
        mobility,
    }
}

#[pymethods]
impl EngineContact {
    /// Creates the contacts that a dictionary describes; the Python files document its keys.
    #[new]
    fn new(given: &Bound<'_, PyDict>) -> PyResult<Self> {
        let given: Description = read(given)?;
        let tools: Vec<_> = given
            .tools
            .iter()
            .map(|(name, radius)| Tool::new(name, Shape::Sphere { radius: *radius }))
            .collect();
        let law = ContactLaw {
            stiffness: given.stiffness,
            damping: given.damping,
            friction: given.friction,
            friction_stiffness: given.friction_stiffness,
            friction_damping: given.friction_damping,
        };
        let bodies = given
            .bodies
            .into_iter()
            .map(|(name, shapes)| {
                let shapes = shapes.into_iter().map(shape).collect::<PyResult<_>>()?;
                Ok(EngineBody { name, shapes, law })
            })
            .collect::<PyResult<Vec<_>>>()?;
        let stepping = if given.end_velocity {
            Stepping::EndVelocity
        } else {
            Stepping::MeanVelocity
        };
        let force_limit = (given.force_limit != f64::INFINITY).then_some(given.force_limit);
        let loop_params = WorldLoop::new(given.period).with_actuation(Actuation {
            delay: given.delay,
            lag: given.lag,
            gain: given.gain,
            ..Actuation::default()
        });
        let loop_params = match force_limit {
            Some(limit) => loop_params.with_force_limits(vec![limit; tools.len()]),
            None => loop_params,
        };
        let params =
            CoupledParams::new(given.device_mass).with_encoder_quantum(given.encoder_quantum);
        let renderer = EngineRenderer::new(&tools, &bodies, stepping, loop_params, params)
            .map_err(|faults| wrong(&faults))?;
        let limits = safety_params(force_limit, None, given.soft_start)?;
        let safety = WorldSafety::new(tools.len(), limits, given.period).map_err(refused)?;
        let safety = safety.rendering(&renderer.loop_params().actuation);
        Ok(Self {
            state: renderer.start(),
            renderer,
            bodies: bodies.len(),
            tools: given.tools.into_iter().map(|(name, _)| name).collect(),
            safety,
            sampled: None,
            last: None,
        })
    }

    /// Starts a period: one row of three coordinates per device.
    #[pyo3(signature = (positions, elapsed=None))]
    fn take(&mut self, positions: PyReadonlyArray2<'_, f64>, elapsed: Option<f64>) -> PyResult<()> {
        let positions = arrays::rows("position", &positions)?;
        if positions.shape() != [self.tools.len(), 3] {
            return Err(refused(format!(
                "position has the shape {:?}, but must have ({}, 3)",
                positions.shape(),
                self.tools.len()
            )));
        }
        let rows = positions.outer_iter();
        let positions: Vec<Vector> = rows.map(|row| [row[0], row[1], row[2]]).collect();
        let sample = Sample {
            elapsed,
            ..Sample::at(&positions)
        };
        self.renderer.sample(&mut self.state, &sample);
        self.sampled = Some(Sampled { positions, elapsed });
        Ok(())
    }

    /// Renders an engine step of `h` `[s]` with one row per body, and returns the wrenches to hold on the bodies,
    /// one row each.
    fn meet<'py>(
        &mut self,
        py: Python<'py>,
        h: f64,
        bodies: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        above_zero("h", h, " s")?;
        if self.sampled.is_none() {
            return Err(refused("there is no sample: call sample() before meet()"));
        }
        let bodies = arrays::rows("bodies", &bodies)?;
        if bodies.shape() != [self.bodies, BODY] {
            return Err(refused(format!(
                "bodies has the shape {:?}, but must have ({}, {BODY})",
                bodies.shape(),
                self.bodies
            )));
        }
        let rows = bodies.outer_iter();
        let bodies: Vec<BodyNow> = rows.map(|row| body(&row.to_vec())).collect();
        let mut wrenches = vec![BodyWrench::default(); bodies.len()];
        self.renderer
            .advance(&mut self.state, h, &bodies, &mut wrenches);
        let rows: Vec<Vec<f64>> = wrenches
            .iter()
            .map(|wrench| [wrench.force, wrench.torque].concat())
            .collect();
        Ok(PyArray2::from_vec2(py, &rows)?)
    }

    /// Ends the period and returns one force row per device.
    fn answer<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let Some(Sampled { positions, elapsed }) = self.sampled.take() else {
            return Err(refused("there is no sample: call sample() before hold()"));
        };
        let output = self.renderer.hold(&mut self.state);
        let (fault, effort, limited) = (output.fault, output.effort, output.limited);
        let forces = output.forces.iter().copied();
        let mut wrenches: Vec<_> = forces.map(Wrench::of_force).collect();
        let answered = Answered {
            elapsed,
            positions: &positions,
            refused: fault.is_some(),
            created_energy: self.state.created_at_ports(),
        };
        let limited = bounded::names(limited, self.safety.bound(&answered, &mut wrenches));
        let forces: Vec<_> = wrenches.iter().map(|wrench| wrench.force).collect();
        for (tool, force) in forces.iter().enumerate() {
            self.renderer.report_sent(&mut self.state, tool, *force);
        }
        let held = rows(py, &forces)?;
        self.last = Some(Answer {
            forces,
            limited,
            effort: effort_values(effort),
            fault: fault.map(|fault| fault.fault.name()),
        });
        Ok(held)
    }

    /// Reports the force that was actually sent to a device for the last sample `[N]`.
    fn tell_sent(&mut self, tool: usize, force: Vector) {
        self.renderer.report_sent(&mut self.state, tool, force);
    }

    /// Resets the state: no sample, no contact, an empty energy ledger.
    fn forget(&mut self) {
        self.safety.restart();
        self.state = self.renderer.start();
        self.sampled = None;
        self.last = None;
    }

    /// Returns the result of the last sample, or None before the first.
    fn result<'py>(&self, py: Python<'py>) -> PyResult<Option<EngineResult<'py>>> {
        let Some(answer) = &self.last else {
            return Ok(None);
        };
        Ok(Some((
            rows(py, &answer.forces)?,
            answer.limited.clone(),
            answer.effort,
            answer.fault,
        )))
    }

    /// Returns the proxy positions at the end of the period, one row each.
    fn proxies<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        rows(py, &self.state.proxies())
    }

    /// Returns the state of each tool: seven vectors and, if known, its mass.
    fn tools_now(&self) -> Vec<([Vector; 7], Option<Vector>)> {
        let tools = self.state.tools().iter();
        tools.map(crate::world_state::tool).collect()
    }

    /// Returns each contact point.
    fn contacts_now(&self) -> Vec<ContactNow> {
        let contacts = self.state.contacts().iter();
        contacts
            .map(|contact| {
                let mode = crate::world_state::mode(contact.mode);
                (
                    contact.tool,
                    contact.body,
                    mode,
                    contact.point,
                    contact.normal,
                    contact.penetration,
                    contact.force,
                )
            })
            .collect()
    }

    /// Returns the energy ledger.
    fn ledger_now(&self) -> LedgerNow {
        let ledger = self.state.ledger();
        (
            ledger
                .contacts
                .iter()
                .map(crate::world_state::contact_ledger)
                .collect(),
            ledger
                .devices
                .iter()
                .map(|entry| [entry.port_work, entry.held])
                .collect(),
        )
    }
}
