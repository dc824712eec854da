//! `calibrate`: an excitation of a device in a loop that Python owns, or of a scene's device in simulated time.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use palpate_study::calibrate::{Calibration, ExcitationParams, Phase, Quantity, measure};
use palpate_study::calibrated::{NotCalibrated, excite};
use palpate_study::calibration::{CalibrationReport, ExcitedMotion, GainFrom, shown};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::checked::finite;
use crate::fields::read;
use crate::figures::drawn;
use crate::interrupt::interruptible;
use crate::names::refused;
use crate::scene::PyScene;

/// A calibration: report as JSON, as text and as a figure, the device file, and the report with an excerpt of the
/// motion as JSON.
type Calibrated = (String, String, String, String, String);

/// A text and the name of its source.
pub type NamedText = (String, String);

/// Known values in addition to the motion, and their sources.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Beside {
    gain: Option<f64>,
    spring: Option<f64>,
    added_mass: Option<f64>,
    before: Option<NamedText>,
    axis: Option<String>,
    command: Option<String>,
    date: Option<String>,
}

/// A running excitation with its samples so far.
#[pyclass(frozen, subclass, name = "Excitation", module = "palpate._palpate")]
pub struct PyExcitation {
    params: ExcitationParams,
    motion: Mutex<ExcitedMotion>,
}

impl PyExcitation {
    fn motion(&self) -> MutexGuard<'_, ExcitedMotion> {
        self.motion.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn of(params: ExcitationParams, motion: ExcitedMotion) -> Self {
        Self {
            params,
            motion: Mutex::new(motion),
        }
    }
}

#[pymethods]
impl PyExcitation {
    /// Creates an excitation: period `[s]`, largest force `[N]`, duration `[s]`, excursion `[m]`,
    /// tremor `[m]`, seed.
    #[new]
    fn new(
        period: f64,
        largest_force: f64,
        duration: f64,
        excursion: f64,
        tremor: f64,
        seed: u64,
    ) -> PyResult<Self> {
        let params = ExcitationParams {
            period,
            largest_force,
            duration,
            excursion,
            tremor,
            seed,
        };
        let motion = ExcitedMotion::new(params).map_err(refused)?;
        Ok(Self::of(params, motion))
    }

    /// Returns the force on the device `[N]` to hold after the sample `position` `[m]`; `time` `[s]` is the sampling
    /// time if it was measured.
    #[pyo3(signature = (position, time=None))]
    fn step(&self, position: f64, time: Option<f64>) -> PyResult<f64> {
        if let Some(time) = time {
            finite("time", time, " s")?;
        }
        let mut motion = self.motion();
        match motion.phase() {
            Phase::Running => {}
            Phase::Done => return Ok(0.0),
            Phase::Stopped(why) => return Err(refused(format!("the excitation stopped: {why}"))),
        }
        if let (Some(time), Some(last)) = (time, motion.times.last())
            && time.partial_cmp(last) != Some(std::cmp::Ordering::Greater)
        {
            return Err(refused(format!(
                "time is {time} s, but must be after that of the last sample, {last} s"
            )));
        }
        let force = motion.take(time, position);
        match motion.phase() {
            Phase::Stopped(why) => Err(refused(format!("the excitation stopped: {why}"))),
            _ => Ok(force),
        }
    }

    /// Reports the force that was actually sent for the last sample `[N]`.
    fn report_sent(&self, force: f64) -> PyResult<()> {
        self.motion().really_sent(finite("force", force, " N")?);
        Ok(())
    }

    /// Whether the excitation is complete.
    #[getter]
    fn done(&self) -> bool {
        self.motion().phase() == Phase::Done
    }

    /// Returns the number of samples of a complete excitation.
    fn __len__(&self) -> usize {
        self.motion().length()
    }

    /// Positions so far `[m]`.
    #[getter]
    fn positions(&self) -> Vec<f64> {
        self.motion().positions.clone()
    }

    /// Forces for these positions `[N]`.
    #[getter]
    fn forces(&self) -> Vec<f64> {
        self.motion().forces.clone()
    }
}

/// Runs a whole excitation of a scene's device in simulated time.
#[pyfunction]
pub fn excite_scene(
    py: Python<'_>,
    scene: &Bound<'_, PyScene>,
    excitation: &Bound<'_, PyExcitation>,
) -> PyResult<()> {
    let params = excitation.get().params;
    let excited = scene.get().scene().clone();
    let motion = interruptible(py, move |stop| {
        excite(&excited, &params, || stop.leave_if_raised())
    })?;
    let motion = motion.map_err(|error| match error {
        NotCalibrated::Stopped(_) => refused(error),
        error => refused(format!("{}: {error}", scene.get().name)),
    })?;
    *excitation.get().motion() = motion;
    Ok(())
}

/// Fits the motion of a complete excitation.
#[pyfunction]
pub fn calibrate(
    py: Python<'_>,
    excitation: &Bound<'_, PyExcitation>,
    beside: &Bound<'_, PyDict>,
) -> PyResult<Calibrated> {
    let beside: Beside = read(beside)?;
    let excitation = excitation.get();
    let params = excitation.params;
    let motion = excitation.motion().clone();
    if motion.phase() != Phase::Done {
        return Err(refused(format!(
            "the excitation has {} of {} samples; it must be complete",
            motion.positions.len(),
            motion.length()
        )));
    }
    let before = beside.before.as_ref().map(parse).transpose()?;
    let from = gain_from(&beside, before.as_ref())?;
    let (positions, forces, excited) = (
        motion.positions.clone(),
        motion.forces.clone(),
        motion.excited(),
    );
    let (measured, seconds) = interruptible(py, move |_| {
        let begun = Instant::now();
        let measured = measure(&params, excited, &positions, &forces);
        (measured, begun.elapsed().as_secs_f64())
    })?;
    let declined = |why: &dyn std::fmt::Display| refused(format!("no calibration: {why}"));
    let mut measured = measured.map_err(|error| declined(&error))?;
    let found = &mut measured.fitted.calibration;
    (found.axis, found.command, found.date) = (beside.axis, beside.command, beside.date);
    if let Some(jitter) = motion.sample_jitter() {
        found.set(Quantity::SampleJitter, jitter);
    }
    if let Some(from) = from {
        let gain = from.gain(found).map_err(|error| declined(&error))?;
        found.set_gain(gain);
    }
    let mut report = CalibrationReport::new(found, &motion.positions, seconds);
    let (json, text) = (palpate_study::json(&report), report.to_string());
    let part = shown(&motion, &measured, params.period);
    let found = &measured.fitted.calibration;
    let figure = drawn(&palpate_plot::calibration(&part, found)).map_err(refused)?;
    report.motion = Some(part);
    let whole = palpate_study::json(&report);
    Ok((json, text, figure, found.to_string(), whole))
}

/// Parses a device file.
pub fn parse((name, text): &NamedText) -> PyResult<Calibration> {
    Calibration::parse(name, text).map_err(refused)
}

fn gain_from<'a>(
    beside: &Beside,
    before: Option<&'a Calibration>,
) -> PyResult<Option<GainFrom<'a>>> {
    for (name, value) in [
        ("gain", beside.gain),
        ("spring", beside.spring),
        ("added_mass", beside.added_mass),
    ] {
        if let Some(value) = value
            && !(value.is_finite() && value > 0.0)
        {
            return Err(refused(format!(
                "{name} is {value}, but must be finite and greater than 0"
            )));
        }
    }
    Ok(
        match (beside.gain, beside.spring, beside.added_mass, before) {
            (None, None, None, None) => None,
            (Some(gain), None, None, None) => Some(GainFrom::Given(gain)),
            (None, Some(stiffness), None, None) => Some(GainFrom::Spring(stiffness)),
            (None, None, Some(mass), Some(before)) => Some(GainFrom::AddedMass(mass, before)),
            _ => {
                return Err(PyTypeError::new_err(
                    "the gain follows from one of gain, spring, or added_mass with before",
                ));
            }
        },
    )
}
