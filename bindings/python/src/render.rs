//! `render`: a motion rendered by several methods.

use numpy::{PyArray1, PyReadonlyArray1};
use palpate_core::{MethodName, Settings};
use palpate_plot::Devices;
use palpate_record::trace::{Delimiter, Layout, Part, TraceError, Ways, read_part};
use palpate_record::unit::{HandMotion, LengthUnit, Spacing, TimeUnit};
use palpate_study::report::{RecordedMotion, Replayed, Report, Subject, actuation_lines};
use palpate_study::sim::replay::{Replay, ReplayError, ReplaySetup};
use palpate_study::sim::run::Run;
use pyo3::exceptions::{PyOSError, PyUserWarning};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::columns::{Words, array, of_ideal, of_run};
use crate::figures::of_runs;
use crate::interrupt::{Stop, interruptible};
use crate::methods::{chosen, settings};
use crate::names::{refused, wrong_replay};
use crate::setup::setup;

/// Results of several methods: report as JSON and as text, ticks of each run, and the reference solution.
pub struct Rendered {
    /// The report as JSON.
    pub json: String,
    /// The report as text.
    pub text: String,
    /// Run of each method.
    pub runs: Vec<Run>,
    /// Points of the reference solution.
    pub ideal: Words,
}

/// [`Rendered`] as passed to Python.
pub type RenderedInPython<'py> = (
    String,
    String,
    Vec<(&'static str, Bound<'py, PyArray1<u64>>)>,
    Bound<'py, PyArray1<u64>>,
);

impl Rendered {
    /// Combines a report with its runs.
    pub fn of(report: &Report, ideal: Words, runs: Vec<Run>) -> Self {
        Self {
            json: report.json(),
            text: report.to_string(),
            runs,
            ideal,
        }
    }

    /// Converts to Python and frees each run after its ticks are copied.
    pub fn into_python(self, py: Python<'_>) -> PyResult<RenderedInPython<'_>> {
        let runs = self.runs.into_iter();
        let ticks = runs.map(|run| Ok((run.method.name(), of_run(py, run)?)));
        let ticks: PyResult<Vec<_>> = ticks.collect();
        Ok((self.json, self.text, ticks?, array(py, self.ideal)))
    }
}

/// A motion and the rendering parameters.
struct MotionToRender {
    setup: ReplaySetup,
    settings: Settings,
    methods: Vec<MethodName>,
    times: Vec<f64>,
    positions: Vec<f64>,
    /// Virtual force of each sample in addition to that of the setup `[N]`; empty: 0.
    forces: Vec<f64>,
    title: String,
    left_out: usize,
}

/// A motion from Python: times `[s]` or in `time_unit`, positions `[m]` or in `unit`, virtual forces `[N]` or none, name,
/// the two units, and the number of skipped samples.
type Given<'py> = (
    PyReadonlyArray1<'py, f64>,
    PyReadonlyArray1<'py, f64>,
    PyReadonlyArray1<'py, f64>,
    String,
    Option<String>,
    Option<String>,
    usize,
);

impl MotionToRender {
    /// Checks the arguments.
    fn new(
        (t, x, forces, title, unit, time_unit, left_out): &Given<'_>,
        method: &Bound<'_, PyAny>,
        parameters: &Bound<'_, PyDict>,
        settings_given: &Bound<'_, PyDict>,
    ) -> PyResult<Self> {
        let methods = chosen(method)?;
        let settings = settings(settings_given, &methods)?;
        let setup = setup(parameters)?;
        let unit = unit.as_deref().map(length_unit).transpose()?;
        // Copy: Python may change its arrays while the GIL is released.
        let time_unit = time_unit.as_deref().map(time_unit_named).transpose()?;
        let times = t.as_array();
        let times: Vec<f64> = match time_unit {
            None => times.to_vec(),
            Some(unit) => times.iter().map(|time| unit.seconds(*time)).collect(),
        };
        let positions = x.as_array();
        let positions = positions.iter();
        let positions: Vec<f64> = match unit {
            None | Some(LengthUnit::Metre) => positions.copied().collect(),
            Some(unit) => positions.map(|position| unit.metres(*position)).collect(),
        };
        if time_unit.is_none() {
            check_times(&times)?;
        }
        if unit.is_none() {
            check_motion(&times, &positions)?;
        }
        Ok(Self {
            setup,
            settings,
            methods,
            times,
            positions,
            forces: forces.as_array().to_vec(),
            title: format!("{}: {title}", Replayed::Motion.title()),
            left_out: *left_out,
        })
    }

    /// Renders the motion by each method and passes the runs to `make`.
    fn rendered<T>(
        self,
        stop: &Stop,
        make: impl FnOnce(&str, &ReplaySetup, &Replay, RecordedMotion, Vec<Run>) -> T,
    ) -> Result<T, ReplayError> {
        let replay = Replay::pushed(self.setup, &self.times, &self.positions, &self.forces)?;
        // Takes as long as there are periods, whose number is checked by now.
        let period = self.setup.loop_params.period;
        let covers = RecordedMotion::new(&self.times, period, self.left_out);
        drop((self.times, self.positions));
        let mut runs = Vec::with_capacity(self.methods.len());
        for method in self.methods {
            stop.leave_if_raised();
            runs.push(replay.run(method, &self.settings)?);
        }
        Ok(make(&self.title, &self.setup, &replay, covers, runs))
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
    let motion = MotionToRender::new(&motion, method, parameters, settings_given)?;
    let rendered = interruptible(py, move |stop| {
        motion.rendered(stop, |title, setup, replay, covers, runs| {
            let subject = Subject::of_replay(title.to_owned(), setup);
            let mut report = Report::new(&subject, replay.reference(), &runs);
            let (samples, period) = (setup.delay().whole_samples(), setup.loop_params.period);
            report.actuated(actuation_lines(&setup.actuation, samples, period));
            report.replayed(Replayed::Motion);
            let warning = covers.warning();
            report.moved(covers);
            let ideal = of_ideal(replay.reference());
            (Rendered::of(&report, ideal, runs), warning)
        })
    })?;
    let (rendered, warning) = rendered.map_err(|error| wrong_replay(&error))?;
    if let Some(warning) = warning {
        warn(py, &warning)?;
    }
    rendered.into_python(py)
}

/// Returns the figure of a motion rendered by each method.
#[pyfunction]
#[pyo3(signature = (motion, method, parameters, settings_given))]
pub fn render_figure(
    py: Python<'_>,
    motion: Given<'_>,
    method: &Bound<'_, PyAny>,
    parameters: &Bound<'_, PyDict>,
    settings_given: &Bound<'_, PyDict>,
) -> PyResult<String> {
    let motion = MotionToRender::new(&motion, method, parameters, settings_given)?;
    let figure = interruptible(py, move |stop| {
        motion.rendered(stop, |title, _, replay, _, runs| {
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

fn time_unit_named(symbol: &str) -> PyResult<TimeUnit> {
    TimeUnit::of_symbol(symbol).ok_or_else(|| {
        let units = TimeUnit::ALL.map(TimeUnit::symbol).join("\" or \"");
        refused(format!(
            "time_unit is \"{symbol}\", but must be \"{units}\""
        ))
    })
}

fn warn(py: Python<'_>, words: &str) -> PyResult<()> {
    let words = std::ffi::CString::new(words)?;
    PyErr::warn(py, &py.get_type::<PyUserWarning>(), &words, 2)
}

/// Rejects an implausible sample spacing if the time unit was not given.
fn check_times(times: &[f64]) -> PyResult<()> {
    match Spacing::implausible(times) {
        None => Ok(()),
        Some(spacing) => {
            let take = spacing.likely_unit().map_or_else(
                || "; ".to_owned(),
                |unit| format!(" If so, pass time_unit=\"{unit}\"; "),
            );
            Err(refused(format!(
                "{spacing}{take}if the times are in seconds, pass time_unit=\"s\""
            )))
        }
    }
}

/// Layout of a table.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct TableLayout {
    columns: Vec<(String, String)>,
    unit: Option<String>,
    time_unit: Option<String>,
    delimiter: Option<String>,
    decimal_comma: bool,
    skip_missing: bool,
    begin: Option<f64>,
    end: Option<f64>,
}

/// Times and positions of a trace, the held force if the table has it, and the number of skipped samples.
type ReadTrace<'py> = (
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Option<Bound<'py, PyArray1<f64>>>,
    Option<Bound<'py, PyArray1<f64>>>,
    usize,
);

/// Reads the table of a recorded motion.
#[pyfunction]
#[pyo3(signature = (path, layout))]
pub fn read_trace<'py>(
    py: Python<'py>,
    path: std::path::PathBuf,
    layout: TableLayout,
) -> PyResult<ReadTrace<'py>> {
    let name = path.display().to_string();
    let delimiter = layout.delimiter.as_deref().map(|text| {
        Delimiter::named(text).ok_or_else(|| {
            refused(format!(
                "delimiter is {text:?}, but must be \",\", \";\" or \"\\t\""
            ))
        })
    });
    let mut read_as = Layout::in_unit(layout.unit.as_deref().map(length_unit).transpose()?);
    read_as.columns = layout.columns;
    read_as.time_unit = layout
        .time_unit
        .as_deref()
        .map(time_unit_named)
        .transpose()?;
    read_as.delimiter = delimiter.transpose()?;
    read_as.decimal_comma = layout.decimal_comma;
    read_as.skip_missing = layout.skip_missing;
    read_as.ways = Ways::Arguments;
    let part = Part {
        from: layout.begin.unwrap_or(Part::WHOLE.from),
        to: layout.end.unwrap_or(Part::WHOLE.to),
        ..Part::WHOLE
    };
    let file = std::fs::File::open(&path)
        .map_err(|error| PyOSError::new_err(format!("{name}: {error}")))?;
    let held = read_part(file, &name, &part, &read_as).map_err(|error| match error {
        TraceError::Unreadable { .. } => PyOSError::new_err(error.to_string()),
        error => refused(error),
    })?;
    let trace = held.trace;
    let named = |error: PyErr| refused(format!("{name}: {}", error.value(py)));
    if read_as.time_unit.is_none() {
        check_times(&trace.t_s).map_err(named)?;
    }
    if read_as.unit.is_none() {
        check_motion(&trace.t_s, &trace.position_m).map_err(named)?;
    }
    if let Some(number) = held.notes.unended {
        warn(
            py,
            &format!(
                "{name}: the last line has no line end, so its last number, {number}, may be cut off, and its sample is \
                 left out; if the file is complete, end it with a line end"
            ),
        )?;
    }
    let array = |numbers: Vec<f64>| PyArray1::from_vec(py, numbers);
    Ok((
        array(trace.t_s),
        array(trace.position_m),
        held.force_on_device_n.map(array),
        held.virtual_force_n.map(array),
        held.notes.left_out,
    ))
}

/// Rejects an implausible hand motion if its unit was not given.
fn check_motion(times: &[f64], positions: &[f64]) -> PyResult<()> {
    let mut motion = HandMotion::default();
    for (time, position) in times.iter().zip(positions) {
        motion.add(*time, *position);
    }
    match motion.excess() {
        None => Ok(()),
        Some(excess) => Err(refused(format!(
            "{excess} If so, pass unit=\"{}\"; if the positions are in metres, pass unit=\"m\"",
            excess.likely_unit()
        ))),
    }
}
