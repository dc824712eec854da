//! `Renderer`: one contact in a loop that Python owns, sample by sample.

use palpate_core::{MethodName, MethodParams as _, ObjectState, ParameterValue, Rendering};
use palpate_scene::SetupError;
use palpate_scene::named_parameters::named_parameters;
use palpate_study::sim::replay::ReplaySetup;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyTuple};

use crate::checked::finite;
use crate::columns::limits;
use crate::contact::{Answer, Contact, Now};
use crate::methods::{chosen, settings};
use crate::names::{refused, wrong_setup};
use crate::setup::{check_delay, setup};

/// A renderer and its state.
#[pyclass(subclass, module = "palpate._palpate")]
pub struct Renderer {
    contact: Contact,
    method: &'static str,
    method_parameters: Vec<(&'static str, ParameterValue<f64>)>,
}

/// State of a renderer at a sample.
#[pyclass(frozen, module = "palpate._palpate")]
pub struct RendererState(Now);

#[pymethods]
impl Renderer {
    /// Creates a renderer of one contact; the Python file documents the arguments.
    #[new]
    #[pyo3(signature = (method, parameters, soft_start, settings_given))]
    fn new(
        method: &Bound<'_, PyAny>,
        parameters: &Bound<'_, PyDict>,
        soft_start: f64,
        settings_given: &Bound<'_, PyDict>,
    ) -> PyResult<Self> {
        let (setup, rendering) = rendering(method, parameters, settings_given)?;
        let contact = Contact::new(&setup, &rendering, soft_start)?;
        Ok(Self {
            method: chosen_one(method)?.name(),
            method_parameters: named_parameters(
                &rendering.params.derived(contact.renderer.method()),
            ),
            contact,
        })
    }

    /// Executes one tick: returns the force on the device for a position.
    #[pyo3(signature = (position, elapsed=None, force=None))]
    fn step(&mut self, position: f64, elapsed: Option<f64>, force: Option<f64>) -> f64 {
        self.contact.step(position, elapsed, force)
    }

    /// Returns the state at the last sample.
    fn held_state(&self) -> RendererState {
        RendererState(self.contact.now.clone())
    }

    /// Continues from a state of a renderer with the same parameters.
    fn hold_state(&mut self, state: &RendererState) {
        self.contact.now = state.0.clone();
    }

    /// Reports the force `[N]` and the slope `[N/s]` that were actually sent to the device for the last sample.
    #[pyo3(signature = (force_on_device, slope_on_device=0.0))]
    fn report_sent(&mut self, force_on_device: f64, slope_on_device: f64) -> PyResult<()> {
        let force = finite("force_on_device", force_on_device, " N")?;
        let slope = finite("slope_on_device", slope_on_device, " N/s")?;
        self.contact.report_sent(force, slope);
        Ok(())
    }

    /// Moves the object at the next sample and records the energy in the ledger.
    #[pyo3(signature = (position, velocity=0.0))]
    fn teleport(&mut self, position: f64, velocity: f64) -> PyResult<()> {
        self.contact.teleport(ObjectState { position, velocity })
    }

    /// Resets the state: the object at its start, no sample, an empty energy ledger.
    fn reset(&mut self) {
        self.contact.reset();
    }

    /// Result of the last sample; None before the first.
    #[getter]
    fn output<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let Some(Answer {
            output,
            force_on_device,
            slope_on_device,
            softened,
            stopped,
        }) = &self.contact.now.last
        else {
            return Ok(None);
        };
        let soft_start = softened.then_some("soft-start");
        let stop = stopped.then_some("safety-stop");
        let limited = limits(output.limited).chain(soft_start).chain(stop);
        let limited: Vec<_> = limited.collect();
        static OUTPUT: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
        let values = (
            *force_on_device,
            -*force_on_device + 0.0,
            *slope_on_device,
            output.object_position,
            output.object_velocity,
            output.penetration,
            output.phase.name(),
            output.transition_after,
            output.proxy_shift,
            PyTuple::new(py, limited)?,
            output.fault.map(|fault| fault.name()),
        );
        OUTPUT
            .import(py, "palpate._values", "Output")?
            .call1(values)
            .map(Some)
    }

    /// Energy ledger of the object up to the last sample.
    #[getter]
    fn ledger<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        static LEDGER: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
        static LEAK: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
        let ([stored, port, virtual_force, outside], leaks) = self.contact.ledger();
        let leak = LEAK.import(py, "palpate._values", "Leak")?;
        let [original, held] = leaks.map(|of| leak.call1((of.last, of.accumulated, of.absolute)));
        LEDGER.import(py, "palpate._values", "Ledger")?.call1((
            stored,
            port,
            virtual_force,
            outside,
            original?,
            held?,
        ))
    }

    /// Name of the method.
    #[getter]
    fn method(&self) -> &'static str {
        self.method
    }

    /// Parameters of the method by key with its unit suffix, including derived ones.
    #[getter]
    fn method_parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let named = PyDict::new(py);
        for (key, value) in &self.method_parameters {
            match value {
                ParameterValue::Number(number) => named.set_item(key, number)?,
                ParameterValue::Word(word) => named.set_item(key, word)?,
                ParameterValue::Switch(on) => named.set_item(key, on)?,
                ParameterValue::ToBeDerived => named.set_item(key, py.None())?,
            }
        }
        Ok(named)
    }
}

/// Returns the single method of a renderer.
fn chosen_one(method: &Bound<'_, PyAny>) -> PyResult<MethodName> {
    match chosen(method)?[..] {
        [method] => Ok(method),
        _ => Err(refused(
            "a Renderer renders by one method; name it with method",
        )),
    }
}

/// Returns the checked arguments of a renderer and the rendering.
pub fn rendering(
    method: &Bound<'_, PyAny>,
    parameters: &Bound<'_, PyDict>,
    settings_given: &Bound<'_, PyDict>,
) -> PyResult<(ReplaySetup, Rendering<f64>)> {
    let method = chosen_one(method)?;
    let settings = settings(settings_given, &[method])?;
    let setup = setup(parameters)?;
    check_delay(&setup)?;
    // Until the first sample the device position is unknown, and the object is assumed to be out of contact.
    let params = setup
        .params(method, &settings, setup.object.position, false)
        .map_err(|error| wrong_setup(&SetupError::from(error)))?;
    let rendering = Rendering {
        contact: setup.contact,
        loop_params: setup.known_loop(),
        params,
        virtual_force: setup.virtual_force,
        object: setup.object,
    };
    Ok((setup, rendering))
}
