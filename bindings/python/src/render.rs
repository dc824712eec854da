//! `render`: a motion, rendered by some methods.

use numpy::{PyArray1, PyReadonlyArray1};
use palpate::{MethodName, Settings};
use palpate_plot::Devices;
use palpate_record::unit::{HandMotion, LengthUnit};
use palpate_sim::replay::{Replay, ReplayError, ReplaySetup};
use palpate_sim::run::Run;
use palpate_study::report::{Replayed, Report, Subject, told_lines};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::columns::{Words, array, of_ideal, of_run};
use crate::figures::of_runs;
use crate::interrupt::{Stop, interruptible};
use crate::methods::{chosen, settings};
use crate::names::{refused, wrong_replay};
use crate::setup::setup;

/// What some methods did: the report as JSON and as text, the ticks of each run, and the ideal.
pub struct Rendered {
    /// The report as JSON.
    pub json: String,
    /// The report as text.
    pub text: String,
    /// What each method did.
    pub runs: Vec<Run>,
    /// Points of the ideal.
    pub ideal: Words,
}

/// [`Rendered`], for Python.
pub type RenderedInPython<'py> = (
    String,
    String,
    Vec<(&'static str, Bound<'py, PyArray1<u64>>)>,
    Bound<'py, PyArray1<u64>>,
);

impl Rendered {
    /// The report of some runs, and the runs.
    pub fn of(report: &Report, ideal: Words, runs: Vec<Run>) -> Self {
        Self {
            json: report.json(),
            text: report.to_string(),
            runs,
            ideal,
        }
    }

    /// As Python takes it; each run goes as soon as its ticks are taken.
    pub fn into_python(self, py: Python<'_>) -> PyResult<RenderedInPython<'_>> {
        let runs = self.runs.into_iter();
        let ticks = runs.map(|run| Ok((run.method.name(), of_run(py, run)?)));
        let ticks: PyResult<Vec<_>> = ticks.collect();
        Ok((self.json, self.text, ticks?, array(py, self.ideal)))
    }
}

/// A motion, with what it is rendered with.
struct MotionToRender {
    setup: ReplaySetup,
    settings: Settings,
    methods: Vec<MethodName>,
    times: Vec<f64>,
    positions: Vec<f64>,
    title: String,
}

/// A motion as Python gives it: times `[s]`, positions `[m]` or in `unit`, its name, and the unit.
type Given<'py> = (
    PyReadonlyArray1<'py, f64>,
    PyReadonlyArray1<'py, f64>,
    String,
    Option<String>,
);

impl MotionToRender {
    /// Checks what was given.
    fn of(
        (t, x, title, unit): &Given<'_>,
        method: &Bound<'_, PyAny>,
        parameters: &Bound<'_, PyDict>,
        settings_given: &Bound<'_, PyDict>,
    ) -> PyResult<Self> {
        let methods = chosen(method)?;
        let settings = settings(settings_given, &methods)?;
        let setup = setup(parameters)?;
        let unit = unit.as_deref().map(length_unit).transpose()?;
        // Copies: while Python is let go, its arrays may change.
        let times = t.as_array().to_vec();
        let positions = x.as_array();
        let positions = positions.iter();
        let positions: Vec<f64> = match unit {
            None | Some(LengthUnit::Metre) => positions.copied().collect(),
            Some(unit) => positions.map(|position| unit.metres(*position)).collect(),
        };
        if unit.is_none() {
            check_motion(&times, &positions)?;
        }
        Ok(Self {
            setup,
            settings,
            methods,
            times,
            positions,
            title: format!("{}: {title}", Replayed::Motion.title()),
        })
    }

    /// Renders it by each method, and gives what `make` makes of that.
    fn rendered<T>(
        self,
        stop: &Stop,
        make: impl FnOnce(&str, &ReplaySetup, &Replay, Vec<Run>) -> T,
    ) -> Result<T, ReplayError> {
        let replay = Replay::new(self.setup, &self.times, &self.positions)?;
        drop((self.times, self.positions));
        let mut runs = Vec::with_capacity(self.methods.len());
        for method in self.methods {
            stop.leave_if_raised();
            runs.push(replay.run(method, &self.settings)?);
        }
        Ok(make(&self.title, &self.setup, &replay, runs))
    }
}

/// Renders a motion by each method.
#[pyfunction]
#[pyo3(signature = (motion, method, parameters, settings_given))]
pub fn render<'py>(
    py: Python<'py>,
    motion: Given<'py>,
    method: &Bound<'py, PyAny>,
    parameters: &Bound<'py, PyDict>,
    settings_given: &Bound<'py, PyDict>,
) -> PyResult<RenderedInPython<'py>> {
    let motion = MotionToRender::of(&motion, method, parameters, settings_given)?;
    let rendered = interruptible(py, move |stop| {
        motion.rendered(stop, |title, setup, replay, runs| {
            let subject = Subject::of_replay(title.to_owned(), setup);
            let mut report = Report::new(&subject, replay.reference(), &runs);
            let (samples, period) = (setup.delay().whole_samples(), setup.loop_params.period);
            report.actuated(told_lines(&setup.actuation, samples, period));
            report.replayed(Replayed::Motion);
            let ideal = of_ideal(replay.reference());
            Rendered::of(&report, ideal, runs)
        })
    })?;
    let rendered = rendered.map_err(|error| wrong_replay(&error))?;
    rendered.into_python(py)
}

/// The figure of a motion that is rendered by each method.
#[pyfunction]
#[pyo3(signature = (motion, method, parameters, settings_given))]
pub fn render_figure(
    py: Python<'_>,
    motion: Given<'_>,
    method: &Bound<'_, PyAny>,
    parameters: &Bound<'_, PyDict>,
    settings_given: &Bound<'_, PyDict>,
) -> PyResult<String> {
    let motion = MotionToRender::of(&motion, method, parameters, settings_given)?;
    let figure = interruptible(py, move |stop| {
        motion.rendered(stop, |title, _, replay, runs| {
            of_runs(title, replay.reference(), &runs, Devices::Recorded)
        })
    })?;
    figure
        .map_err(|error| wrong_replay(&error))?
        .map_err(refused)
}

fn length_unit(symbol: &str) -> PyResult<LengthUnit> {
    LengthUnit::of_symbol(symbol).ok_or_else(|| {
        let units = LengthUnit::ALL.map(LengthUnit::symbol).join("\" or \"");
        refused(format!("unit is \"{symbol}\", but must be \"{units}\""))
    })
}

/// Refuses a motion that no hand has made, where nobody has said its unit.
fn check_motion(times: &[f64], positions: &[f64]) -> PyResult<()> {
    let mut motion = HandMotion::default();
    for (time, position) in times.iter().zip(positions) {
        motion.add(*time, *position);
    }
    match motion.excess() {
        None => Ok(()),
        Some(excess) => Err(refused(format!(
            "{excess} unit=\"{}\" takes it so, and unit=\"m\" says that metres are right",
            excess.likely_unit()
        ))),
    }
}
