//! `advise`: what can be rendered on a device.

use palpate::MethodName;
use palpate_calibrate::{Calibration, Quantity};
use palpate_scene::SetupError;
use palpate_study::advise::{Advice, FAITHFUL_PERCENT};
use palpate_study::map::{Bounce, BounceDevice, BounceError, MapParams, SEARCHED};
use pyo3::prelude::*;

use crate::calibration::{NamedText, parse};
use crate::checked::{NOT_NEGATIVE, PERIODS, above_zero, within};
use crate::figures::drawn;
use crate::interrupt::{Stop, interruptible};
use crate::methods::chosen;
use crate::names::{refused, wrong_argument, wrong_on_bench};
use crate::studies::threads;

/// The arguments of an advice.
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
    device_file: Option<NamedText>,
}

/// Says what can be rendered on a device: a report as JSON and as text.
#[pyfunction]
pub fn advise(
    py: Python<'_>,
    method: &Bound<'_, PyAny>,
    arguments: AdviseArguments,
) -> PyResult<(String, String)> {
    let methods = chosen(method)?;
    let asked = Asked::of(&arguments)?;
    let advised = interruptible(py, move |stop| {
        let advice = asked.advice(&methods, stop)?;
        Ok((palpate_study::json(&advice), advice.to_string()))
    })?;
    advised.map_err(wrong_bounce)
}

/// The figure of an advice: how stiff a contact can be over the object's mass.
#[pyfunction]
pub fn advice_figure(
    py: Python<'_>,
    method: &Bound<'_, PyAny>,
    arguments: AdviseArguments,
) -> PyResult<String> {
    let methods = chosen(method)?;
    let asked = Asked::of(&arguments)?;
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

/// What is asked about, and on which device.
struct Asked {
    file: Option<Calibration>,
    bounce: Bounce,
    is_stiffness_given: bool,
}

impl Asked {
    fn of(arguments: &AdviseArguments) -> PyResult<Self> {
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
                wrong_argument(&palpate::ParameterError {
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

/// The scene that is asked about; a softest stiffness stands in where none is.
fn bounce(arguments: &AdviseArguments, file: Option<&Calibration>) -> PyResult<Bounce> {
    let known = |quantity| file.and_then(|file| file.value(quantity));
    let defaults = MapParams::default();
    let mass = arguments.device_mass.or(known(Quantity::DeviceMass));
    let mass = mass.ok_or_else(|| {
        refused("device_mass is needed: there is no device file that has device_mass_kg")
    })?;
    let mass = above_zero("device_mass", mass, " kg")?;
    let period = above_zero("period", arguments.period, " s")?;
    let object_mass = match arguments.mass {
        f64::INFINITY => f64::INFINITY,
        mass => above_zero("mass", mass, " kg")?,
    };
    let stiffness = match arguments.stiffness {
        Some(stiffness) => above_zero("stiffness", stiffness, " N/m")?,
        None => SEARCHED.0 * mass / (period * period),
    };
    let quantum = arguments
        .encoder_quantum
        .or(known(Quantity::SensorQuantum))
        .unwrap_or(0.0);
    // Where the two are known only together, the sum is the better delay.
    let of_file = known(Quantity::Delay).or(known(Quantity::DelayPlusLag));
    let of_file = of_file.map(|seconds| seconds / period);
    let delay = arguments.delay.or(of_file).unwrap_or(0.0);
    let lag = arguments.lag.or(known(Quantity::Lag)).unwrap_or(0.0);
    Ok(Bounce {
        device: BounceDevice {
            mass,
            viscous_friction: within(
                "viscous_friction",
                arguments.viscous_friction,
                NOT_NEGATIVE,
                " N s/m",
            )?,
            coulomb_friction: within(
                "coulomb_friction",
                arguments.coulomb_friction,
                NOT_NEGATIVE,
                " N",
            )?,
            encoder_quantum: within("encoder_quantum", quantum, NOT_NEGATIVE, " m")?,
            told_mass: 1.0,
        },
        stiffness,
        object_mass,
        forces: defaults.forces,
        gap: defaults.gap,
        period,
        told_period: 1.0,
        delay: within("delay", delay, PERIODS, " periods")?,
        lag: within("lag", lag, NOT_NEGATIVE, " s")?,
    })
}
