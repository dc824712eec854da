//! Rendering methods written in Python: a function that the bench calls at each sample.

use std::cell::RefCell;
use std::collections::HashSet;
use std::sync::{Mutex, PoisonError};

use palpate_core::{
    Contact, LoopParams, Method, MethodParams, ObjectMotion, ParameterError, Plan, Situation,
};
use palpate_study::sim::closed_loop::{Bench, LoopError};
use palpate_study::sim::run::Run;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;

use crate::interrupt::Stop;
use crate::names::refused;

/// A Python function as a method, with its name in reports.
pub struct OwnMethod {
    /// Name in reports.
    pub name: &'static str,
    function: Py<PyAny>,
}

/// Reason why a Python method did not run.
pub enum OwnError {
    /// The function raised an exception or did not return a number.
    Raised(PyErr),
    /// The scene cannot be run.
    Loop(LoopError),
}

/// The active function and the exception that it raised.
struct Called {
    name: &'static str,
    function: Py<PyAny>,
    raised: Option<PyErr>,
    stop: Stop,
}

thread_local! {
    /// Methods of the core are plain data, so the function is stored here. A run uses one thread.
    static CALLED: RefCell<Option<Called>> = const { RefCell::new(None) };
}

impl OwnMethod {
    /// Creates the method of a `function`, with the function's name.
    pub fn new(function: &Bound<'_, PyAny>) -> PyResult<Self> {
        let name: String = match function.getattr("__name__") {
            Ok(name) => name.extract()?,
            Err(_) => function.get_type().name()?.to_string(),
        };
        Ok(Self {
            name: kept(name),
            function: function.clone().unbind(),
        })
    }

    /// Runs the method on a bench.
    pub fn run(self, bench: &Bench<'_>, stop: &Stop) -> Result<Run, OwnError> {
        CALLED.set(Some(Called {
            name: self.name,
            function: self.function,
            raised: None,
            stop: stop.clone(),
        }));
        let run = bench.run_own(OwnParams { name: self.name });
        match CALLED.take().and_then(|called| called.raised) {
            Some(error) => Err(OwnError::Raised(error)),
            None => run.map_err(OwnError::Loop),
        }
    }
}

/// Returns a static copy of a name; equal names share one copy.
fn kept(name: String) -> &'static str {
    static NAMES: Mutex<Option<HashSet<&'static str>>> = Mutex::new(None);
    let mut names = NAMES.lock().unwrap_or_else(PoisonError::into_inner);
    let names = names.get_or_insert_default();
    if let Some(known) = names.get(name.as_str()) {
        return known;
    }
    let name: &'static str = name.leak();
    names.insert(name);
    name
}

/// Parameters of a Python method: none that could be checked.
#[derive(Clone, Copy)]
struct OwnParams {
    name: &'static str,
}

/// Calls the function.
#[derive(Clone, Copy, Debug)]
struct Calls;

impl MethodParams<f64> for OwnParams {
    type Method = Calls;

    fn check(self, _: &Contact<f64>, _: &LoopParams<f64>) -> Result<Calls, ParameterError> {
        Ok(Calls)
    }

    fn name(&self) -> &'static str {
        self.name
    }
}

impl Method<f64> for Calls {
    type Memory = ();

    fn plan(&self, motion: &ObjectMotion<f64>, now: &Situation<'_, f64>, (): &mut ()) -> Plan<f64> {
        // In contact or free throughout the interval, as the object in the paper.
        now.unswitched(motion, || {
            CALLED.with_borrow_mut(|called| called.as_mut().map_or(0.0, |called| called.force(now)))
        })
    }
}

impl Called {
    /// Returns the force of the function, or 0 after it has raised an exception.
    fn force(&mut self, now: &Situation<'_, f64>) -> f64 {
        self.stop.leave_if_raised();
        if self.raised.is_some() {
            return 0.0;
        }
        Python::attach(|py| self.ask(py, now)).unwrap_or_else(|error| {
            self.raised = Some(error);
            0.0
        })
    }

    fn ask(&self, py: Python<'_>, now: &Situation<'_, f64>) -> PyResult<f64> {
        static SITUATION: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
        let situation = SITUATION
            .import(py, "palpate._values", "Situation")?
            .call1((
                now.start.penetration,
                now.start.device_velocity,
                now.start.object_velocity,
                now.start.virtual_force,
                now.previous_penetration,
                now.elapsed,
                now.port_work,
                now.held_leak,
            ))?;
        let answer = self.function.call1(py, (situation,))?;
        let answer = answer.bind(py);
        let force = answer
            .extract()
            .ok()
            .filter(|force: &f64| force.is_finite());
        force.ok_or_else(|| {
            let said = answer
                .repr()
                .map_or_else(|_| "an unprintable value".into(), |said| said.to_string());
            let name = self.name;
            let message =
                format!("{name} returned {said}, but must return a finite number: a force [N]");
            if answer.extract::<f64>().is_ok() {
                refused(message)
            } else {
                PyTypeError::new_err(message)
            }
        })
    }
}
