//! `LowRateSimulator`: simulator side of a local model: publishes models to a real-time loop and reads its progress.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use numpy::{PyReadonlyArray2, PyUntypedArrayMethods as _};
use palpate_core::Actuation;
use palpate_device::Vector;
use palpate_rt::{LocalWorld, WorldFrame, local_world};
use palpate_scene::world::{Drivetrain, WorldDevice, WorldHand};
use palpate_world::engine::local::{LocalContact, LocalParams, LocalRenderer, ModelRefusal};
use palpate_world::{ContactLaw, CoupledParams, Shape, Tool, WorldLoop};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays;
use crate::contact::safety_params;
use crate::engine::{BODY, body, wrong};
use crate::fields::read;
use crate::names::refused;
use crate::real_time::heard::Heard;

/// Tool, capacities for models, and loop, as passed by the Python files.
#[derive(Clone, Copy, FromPyObject)]
#[pyo3(from_item_all)]
struct Given {
    tool_radius: f64,
    bodies: usize,
    contacts: usize,
    period: f64,
    device_mass: Vector,
    position: Vector,
    stale_after: f64,
    fade: f64,
    settle: f64,
    return_time: f64,
    encoder_quantum: f64,
    delay: f64,
    lag: f64,
    gain: f64,
    force_limit: f64,
    soft_start: f64,
}

/// Indices of the body with the sphere and of the body with the surface; position, normal, curvature; centre and
/// radius of a body's sphere; stiffness, damping, friction and its stiffness.
type GivenContact = (
    (Option<usize>, Option<usize>),
    (Vector, Vector, f64),
    (Vector, f64),
    [f64; 5],
);

/// Tick and period, whether the contacts fade, tick of the last model and the reason for rejecting the last one;
/// position and velocity of the tool; impulse, its moment, and position of the copy of each body.
type ProgressValues = (
    (u64, f64, bool, Option<u64>, Option<&'static str>),
    (Vector, Vector),
    Vec<(Vector, Vector, Vector)>,
);

/// Simulator side of a local model.
#[pyclass(
    frozen,
    subclass,
    name = "LowRateSimulator",
    module = "palpate._palpate"
)]
pub struct LowRateSimulator {
    given: Given,
    /// None before a loop uses it.
    end: Mutex<Option<End>>,
}

/// Simulator side, and the ticks of its loop.
struct End {
    own: palpate_rt::LowRateSimulator,
    heard: Arc<Heard>,
}

#[pymethods]
impl LowRateSimulator {
    /// Creates a simulator side from a dictionary; the Python file documents its keys.
    #[new]
    fn new(given: &Bound<'_, PyDict>) -> PyResult<Self> {
        let given: Given = read(given)?;
        given.renderer([true; 3])?;
        safety_params(None, None, given.soft_start)?;
        Ok(Self {
            given,
            end: Mutex::new(None),
        })
    }

    /// Returns the progress of the loop at its last tick.
    fn progress_now(&self) -> PyResult<ProgressValues> {
        let mut end = self.end();
        let progress = taken(&mut end)?.own.progress();
        let first = |vectors: &[Vector]| vectors.first().copied().unwrap_or_default();
        let bodies = progress.impulses.iter().zip(&progress.copies);
        Ok((
            (
                progress.tick,
                progress.period,
                progress.is_stale,
                progress.model_tick,
                progress.refusal.map(in_words),
            ),
            (first(&progress.positions), first(&progress.velocities)),
            bodies
                .map(|(impulse, copy)| (impulse.linear, impulse.angular, *copy))
                .collect(),
        ))
    }

    /// Publishes bodies, one row each, and contacts for a tick.
    fn publish_model(
        &self,
        tick: u64,
        bodies: PyReadonlyArray2<'_, f64>,
        contacts: Vec<Option<GivenContact>>,
    ) -> PyResult<()> {
        let rows = arrays::rows("bodies", &bodies)?;
        if bodies.shape()[1] != BODY {
            return Err(refused(format!(
                "bodies has rows of {} numbers, but must have {BODY}: a palpate.engines.body_row for each",
                bodies.shape()[1]
            )));
        }
        let rows: Vec<Vec<f64>> = rows.outer_iter().map(|row| row.to_vec()).collect();
        let bodies: Vec<_> = rows.iter().map(|row| body(row)).collect();
        let contacts = contacts.into_iter().map(|contact| contact.map(local));
        let contacts: Vec<_> = contacts.collect();
        let mut end = self.end();
        let End { own, heard } = taken(&mut end)?;
        if heard.is_closed() {
            return Err(PyRuntimeError::new_err(
                "the Loop of the LowRateSimulator has ended",
            ));
        }
        own.publish(tick, &bodies, &contacts)
            .map_err(|faults| wrong(&faults))
    }

    /// Sampling period of its loop `[s]`.
    #[getter]
    pub fn period(&self) -> f64 {
        self.given.period
    }
}

impl LowRateSimulator {
    /// Name of its tool in messages and recordings.
    pub const TOOL: &'static str = "tool";

    /// Returns the initial device.
    pub fn device(&self) -> WorldDevice {
        WorldDevice {
            own_axes: None,
            mass: self.given.device_mass,
            position: self.given.position,
            velocity: [0.0; 3],
            quantum: [self.given.encoder_quantum; 3],
            hand: WorldHand {
                rest: self.given.position,
                ..WorldHand::default()
            },
            drivetrain: Drivetrain::default(),
            turning: None,
        }
    }

    /// Returns the largest force `[N]`, if limited, and the soft-start time `[s]`.
    pub fn limits(&self) -> (Option<f64>, f64) {
        (finite(self.given.force_limit), self.given.soft_start)
    }

    /// Creates both sides of a local model on a device with this frame; pass the simulator side to [`Self::belong`].
    pub fn ends(&self, frame: WorldFrame) -> PyResult<(palpate_rt::LowRateSimulator, LocalWorld)> {
        free(&self.end())?;
        let axes = [0, 1, 2].map(|axis| frame.has(axis));
        local_world(self.given.renderer(axes)?, frame).map_err(refused)
    }

    /// Connects this object to the loop with the other side. Call it last, after everything that can fail, so that a
    /// failed loop leaves it unconnected.
    pub fn belong(&self, own: palpate_rt::LowRateSimulator, heard: Arc<Heard>) -> PyResult<()> {
        let mut end = self.end();
        free(&end)?;
        *end = Some(End { own, heard });
        Ok(())
    }

    fn end(&self) -> MutexGuard<'_, Option<End>> {
        self.end.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Given {
    fn renderer(&self, axes: [bool; 3]) -> PyResult<LocalRenderer> {
        let shape = Shape::Sphere {
            radius: self.tool_radius,
        };
        let mut tool = Tool::new(LowRateSimulator::TOOL, shape);
        tool.axes = axes;
        let params = LocalParams {
            stale_after: self.stale_after,
            fade: self.fade,
            settle: self.settle,
            return_time: self.return_time,
            ..LocalParams::new(self.bodies, self.contacts)
        };
        let loop_params = WorldLoop::new(self.period).with_actuation(Actuation {
            delay: self.delay,
            lag: self.lag,
            gain: self.gain,
            ..Actuation::default()
        });
        let loop_params = match finite(self.force_limit) {
            Some(limit) => loop_params.with_force_limits(vec![limit]),
            None => loop_params,
        };
        let mass = [0, 1, 2].map(|axis| {
            if axes[axis] {
                self.device_mass[axis]
            } else {
                f64::INFINITY
            }
        });
        let coupled = CoupledParams::new(vec![mass]).with_encoder_quantum(self.encoder_quantum);
        LocalRenderer::new(&[tool], params, loop_params, coupled).map_err(|faults| wrong(&faults))
    }
}

fn free(end: &Option<End>) -> PyResult<()> {
    if end.is_some() {
        return Err(PyRuntimeError::new_err(
            "the LowRateSimulator belongs to another Loop; make another LowRateSimulator",
        ));
    }
    Ok(())
}

fn finite(limit: f64) -> Option<f64> {
    (limit != f64::INFINITY).then_some(limit)
}

fn taken(end: &mut Option<End>) -> PyResult<&mut End> {
    end.as_mut().ok_or_else(|| {
        PyRuntimeError::new_err("the LowRateSimulator is not in a Loop; make a Loop with it first")
    })
}

fn local(given: GivenContact) -> LocalContact {
    let (numbers, surface, (centre, radius), law) = given;
    let (of, on) = numbers;
    let (place, normal, curvature) = surface;
    let [
        stiffness,
        damping,
        friction,
        friction_stiffness,
        friction_damping,
    ] = law;
    let law = ContactLaw {
        stiffness,
        damping,
        friction,
        friction_stiffness,
        friction_damping,
    };
    let contact = match of {
        None => LocalContact::of_tool(0, on, place, normal, law),
        Some(body) => LocalContact::of_body((body, centre, radius), on, place, normal, law),
    };
    contact.curved(curvature)
}

fn in_words(refusal: ModelRefusal) -> &'static str {
    match refusal {
        ModelRefusal::NotYet => "its tick is in the future",
        ModelRefusal::OutOfOrder => "its tick is before that of the previous model",
        ModelRefusal::TooOld => "older than stale_after",
        ModelRefusal::OtherRoom => "of another host",
    }
}
