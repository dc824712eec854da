//! `Renderer`: one contact in a loop that Python owns, sample by sample.

use palpate_core::{
    AnyMemory, AnyRenderer, Leak, LoopParams, MethodName, MethodParams as _, ObjectState, Output,
    ParameterValue, Rendering, Sample, State,
};
use palpate_device::Wrench;
use palpate_rt::safety::{self, Safety, SafetyParams};
use palpate_scene::SetupError;
use palpate_scene::named_parameters::named_parameters;
use palpate_study::sim::replay::ReplaySetup;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyTuple};

use crate::checked::finite;
use crate::columns::limits;
use crate::methods::{chosen, settings};
use crate::names::{refused, wrong_argument, wrong_setup};
use crate::setup::{check_delay, setup};

/// A renderer and its state.
#[pyclass(subclass, module = "palpate._palpate")]
pub struct Renderer {
    renderer: AnyRenderer<f64>,
    state: State<f64, AnyMemory<f64>>,
    safety: Safety,
    setup: ReplaySetup,
    soft_start: f64,
    method: &'static str,
    method_parameters: Vec<(&'static str, ParameterValue<f64>)>,
    last: Option<Answer>,
}

/// Result of a sample.
struct Answer {
    output: Output<f64>,
    /// Force to command, after the soft start `[N]`.
    force_on_device: f64,
    /// Its slope `[N/s]`.
    slope_on_device: f64,
    softened: bool,
    /// Whether generated energy has caused a safety stop.
    stopped: bool,
}

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
        let renderer = rendering
            .renderer()
            .map_err(|error| wrong_argument(&error))?;
        Ok(Self {
            state: renderer
                .start(setup.object)
                .map_err(|error| wrong_argument(&error))?,
            safety: safety_of(&setup, soft_start)?,
            method: chosen_one(method)?.name(),
            method_parameters: named_parameters(&rendering.params.derived(renderer.method())),
            renderer,
            setup,
            soft_start,
            last: None,
        })
    }

    /// Executes one tick: returns the force on the device for a position.
    #[pyo3(signature = (position, elapsed=None, force=None))]
    fn step(&mut self, position: f64, elapsed: Option<f64>, force: Option<f64>) -> f64 {
        let sample = Sample {
            elapsed,
            ..Sample::at(position).with_virtual_force(force.unwrap_or(self.setup.virtual_force))
        };
        let mut output = self.renderer.step(&mut self.state, sample);
        let is_used = output.fault.is_none();
        // The renderer has rejected the position, so the safety layer must not use it.
        let coordinate = if is_used { position } else { 0.0 };
        let verdict = self.safety.evaluate(&safety::Rendered {
            elapsed,
            position: [coordinate, 0.0, 0.0],
            coordinate,
            wrench: Wrench::of_force([output.force_on_device, 0.0, 0.0]),
            slope: [output.slope_on_device, 0.0, 0.0],
            created_energy: self.state.ledger().created(),
            refused: !is_used,
            stalled: false,
        });
        output.limited.force |= verdict.bounded.force;
        output.limited.slew |= verdict.bounded.slew;
        let [force_on_device, ..] = verdict.wrench.force;
        // Adding 0.0 normalises -0.0, which the soft start produces.
        let force_on_device = force_on_device + 0.0;
        let slope_on_device = verdict.slope[0] + 0.0;
        self.renderer
            .report_sent_line(&mut self.state, -force_on_device, -slope_on_device);
        self.last = Some(Answer {
            output,
            force_on_device,
            slope_on_device,
            softened: verdict.bounded.soft_start,
            stopped: verdict.bounded.stopped,
        });
        force_on_device
    }

    /// Reports the force `[N]` and the slope `[N/s]` that were actually sent to the device for the last sample.
    #[pyo3(signature = (force_on_device, slope_on_device=0.0))]
    fn report_sent(&mut self, force_on_device: f64, slope_on_device: f64) -> PyResult<()> {
        let force = finite("force_on_device", force_on_device, " N")?;
        let slope = finite("slope_on_device", slope_on_device, " N/s")?;
        self.renderer
            .report_sent_line(&mut self.state, -force, -slope);
        Ok(())
    }

    /// Moves the object at the next sample and records the energy in the ledger.
    #[pyo3(signature = (position, velocity=0.0))]
    fn teleport(&mut self, position: f64, velocity: f64) -> PyResult<()> {
        let object = ObjectState { position, velocity };
        self.renderer
            .teleport(&mut self.state, object)
            .map_err(|error| wrong_argument(&error))
    }

    /// Resets the state: the object at its start, no sample, an empty energy ledger.
    fn reset(&mut self) -> PyResult<()> {
        self.state = self
            .renderer
            .start(self.setup.object)
            .map_err(|error| wrong_argument(&error))?;
        self.safety = safety_of(&self.setup, self.soft_start)?;
        self.last = None;
        Ok(())
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
        }) = &self.last
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
        let ledger = self.state.ledger();
        let leak = LEAK.import(py, "palpate._values", "Leak")?;
        let leak = |of: &Leak<f64>| leak.call1((of.last, of.accumulated, of.absolute));
        LEDGER.import(py, "palpate._values", "Ledger")?.call1((
            ledger.stored,
            ledger.port_work,
            ledger.virtual_force_work,
            ledger.outside_work,
            leak(&ledger.original_leak)?,
            leak(&ledger.held_leak)?,
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

/// Returns the limits of `palpate pipe`: largest force, soft-start time and generated energy.
fn safety_of(setup: &ReplaySetup, soft_start: f64) -> PyResult<Safety> {
    let LoopParams {
        force_limit,
        period,
        ..
    } = setup.loop_params;
    let limits = safety_params(force_limit, None, soft_start)?;
    let known = setup.known_loop();
    let slew_limit = known.slew_limit.unwrap_or(f64::INFINITY);
    let safety = Safety::new(limits, period).map_err(refused)?;
    Ok(safety.rendering(&known.actuation, slew_limit))
}

/// Returns these limits with a torque limit.
pub fn safety_params(
    force_limit: Option<f64>,
    torque_limit: Option<f64>,
    soft_start: f64,
) -> PyResult<SafetyParams> {
    if !(0.0..=60.0).contains(&soft_start) {
        return Err(refused(format!(
            "soft_start is {soft_start} s, but must be 0 to 60"
        )));
    }
    Ok(SafetyParams::bounding(
        force_limit,
        torque_limit,
        soft_start,
    ))
}
