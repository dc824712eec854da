//! `advise`: contacts that can be rendered on a device.

use palpate_core::MethodName;
use palpate_scene::SetupError;
use palpate_study::advise::{Advice, FAITHFUL_PERCENT, Question};
use palpate_study::calibrate::Calibration;
use palpate_study::map::{Bounce, BounceError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::calibration::{NamedText, parse};
use crate::checked::{NOT_NEGATIVE, above_zero, within};
use crate::fields::read;
use crate::figures::drawn;
use crate::interrupt::{Stop, interruptible};
use crate::methods::chosen;
use crate::names::{refused, wrong_argument, wrong_on_bench};
use crate::studies::threads;

/// Arguments of `advise`.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct AdviseArguments {
    period: f64,
    device_mass: Option<f64>,
    stiffness: Option<f64>,
    mass: f64,
    viscous_friction: f64,
    coulomb_friction: f64,
    encoder_quantum: Option<f64>,
    delay: Option<f64>,
    lag: Option<f64>,
    delay_deviation: Option<f64>,
    lag_deviation: Option<f64>,
    device_file: Option<NamedText>,
}

/// Returns the report on the contacts that a device can render, as JSON and as text.
#[pyfunction]
pub fn advise(
    py: Python<'_>,
    method: &Bound<'_, PyAny>,
    arguments: &Bound<'_, PyDict>,
) -> PyResult<(String, String)> {
    let methods = chosen(method)?;
    let asked = Asked::new(&read(arguments)?)?;
    let advised = interruptible(py, move |stop| {
        let advice = asked.advice(&methods, stop)?;
        Ok((palpate_study::json(&advice), advice.to_string()))
    })?;
    advised.map_err(wrong_bounce)
}

/// Returns the figure of an advice: largest stiffness over the object's mass.
#[pyfunction]
pub fn advice_figure(
    py: Python<'_>,
    method: &Bound<'_, PyAny>,
    arguments: &Bound<'_, PyDict>,
) -> PyResult<String> {
    let methods = chosen(method)?;
    let asked = Asked::new(&read(arguments)?)?;
    let threads = threads()?;
    let figure = interruptible(py, move |stop| {
        let advice = asked.advice(&methods, stop)?;
        let shown = palpate_plot::shown_of(&methods);
        let look = || stop.leave_if_raised();
        let reach = threads.install(|| asked.bounce.reach(&shown, FAITHFUL_PERCENT, look))?;
        Ok(drawn(&palpate_plot::advice(&advice, &reach)))
    })?;
    figure.map_err(wrong_bounce)?.map_err(refused)
}

/// Checked question: the device and the contact.
struct Asked {
    file: Option<Calibration>,
    bounce: Bounce,
    is_stiffness_given: bool,
}

impl Asked {
    fn new(arguments: &AdviseArguments) -> PyResult<Self> {
        let file = arguments.device_file.as_ref().map(parse).transpose()?;
        Ok(Self {
            bounce: bounce(arguments, file.as_ref())?,
            is_stiffness_given: arguments.stiffness.is_some(),
            file,
        })
    }

    fn advice(&self, methods: &[MethodName], stop: &Stop) -> Result<Advice, BounceError> {
        let bounce = &self.bounce;
        let mut advice = Advice::on(bounce, self.is_stiffness_given, methods, || {
            stop.leave_if_raised();
        })?;
        let file = self.file.as_ref();
        let stiffest =
            file.and_then(|file| file.stiffest_contact(bounce.object_mass, bounce.period));
        if let Some(stiffest) = stiffest {
            advice.bounded_by_a_resonance(stiffest);
        }
        Ok(advice)
    }
}

fn wrong_bounce(error: BounceError) -> PyErr {
    match error {
        BounceError::Bench(error) => wrong_on_bench(&error),
        BounceError::Method {
            error: SetupError::Parameter(error),
            ..
        } => match error.parameter {
            palpate_scene::SceneParameter::Rendered(parameter) => {
                wrong_argument(&palpate_core::ParameterError {
                    parameter,
                    value: error.value,
                    allowed: error.allowed,
                })
            }
            _ => refused(error),
        },
        BounceError::TooLong(_) => refused(format!(
            "stiffness: {error}; a stiffer contact or a longer period is needed"
        )),
        other => refused(other),
    }
}

/// Returns the scene of the question.
fn bounce(arguments: &AdviseArguments, file: Option<&Calibration>) -> PyResult<Bounce> {
    let asked = Question {
        file,
        device_mass: arguments.device_mass,
        viscous_friction: arguments.viscous_friction,
        coulomb_friction: arguments.coulomb_friction,
        encoder_quantum: arguments.encoder_quantum,
        period: arguments.period,
        delay: arguments.delay,
        lag: arguments.lag,
        delay_deviation: arguments.delay_deviation,
        lag_deviation: arguments.lag_deviation,
        stiffness: arguments.stiffness,
        object_mass: arguments.mass,
    };
    let bounce = asked.bounce().ok_or_else(|| {
        refused("device_mass is missing: give it, or a device file with device_mass_kg")
    })?;
    let device = &bounce.device;
    above_zero("device_mass", device.mass, " kg")?;
    above_zero("period", bounce.period, " s")?;
    if bounce.object_mass != f64::INFINITY {
        above_zero("mass", bounce.object_mass, " kg")?;
    }
    if let Some(stiffness) = arguments.stiffness {
        above_zero("stiffness", stiffness, " N/m")?;
    }
    for (name, value, allowed, unit) in [
        (
            "viscous_friction",
            device.viscous_friction,
            NOT_NEGATIVE,
            " N s/m",
        ),
        (
            "coulomb_friction",
            device.coulomb_friction,
            NOT_NEGATIVE,
            " N",
        ),
        (
            "encoder_quantum",
            device.encoder_quantum,
            NOT_NEGATIVE,
            " m",
        ),
        ("delay", arguments.delay.unwrap_or(0.0), NOT_NEGATIVE, " s"),
        ("lag", bounce.lag, NOT_NEGATIVE, " s"),
        (
            "delay_deviation",
            arguments.delay_deviation.unwrap_or(0.0),
            NOT_NEGATIVE,
            " s",
        ),
        (
            "lag_deviation",
            arguments.lag_deviation.unwrap_or(0.0),
            NOT_NEGATIVE,
            " s",
        ),
    ] {
        within(name, value, allowed, unit)?;
    }
    Ok(bounce)
}
