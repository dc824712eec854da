//! `map` and `advise`: what can be rendered.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use palpate::MethodName;
use palpate_calibrate::{Calibration, Quantity};
use palpate_figure::{Size, svg};
use palpate_record::map::Map;
use palpate_scene::SetupError;
use palpate_study::advise::Advice;
use palpate_study::map::report::{MapReport, Speed};
use palpate_study::map::{
    Bounce, BounceDevice, BounceError, Forces, MapParams, SEARCHED, compute, receipt,
};
use pyo3::prelude::*;

use crate::interrupt::interruptible;
use crate::methods::chosen;
use crate::names::{refused, wrong_argument, wrong_on_bench};

/// A report as JSON, as text and as a figure, and a map as the text of its file.
type Mapped = (String, String, String, String);

/// The arguments of a map.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct MapArguments {
    cells: usize,
    viscous_friction: Option<f64>,
    encoder_quantum: f64,
    told_mass: f64,
    told_period: f64,
    delay: f64,
    lag: f64,
    forces: String,
}

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
    device_file: Option<PathBuf>,
}

fn within(name: &str, value: f64, [least, most]: [f64; 2], unit: &str) -> PyResult<f64> {
    if value.is_finite() && value >= least && value <= most {
        return Ok(value);
    }
    let allowed = if most == f64::INFINITY {
        format!("finite and not below {least}")
    } else {
        format!("{least} to {most}")
    };
    Err(refused(format!(
        "{name} is {value}{unit}, but must be {allowed}"
    )))
}

fn above_zero(name: &str, value: f64, unit: &str) -> PyResult<f64> {
    if value.is_finite() && value > 0.0 {
        return Ok(value);
    }
    Err(refused(format!(
        "{name} is {value}{unit}, but must be finite and greater than 0"
    )))
}

const NOT_NEGATIVE: [f64; 2] = [0.0, f64::INFINITY];
const FACTOR: [f64; 2] = [1e-3, 1e3];
const PERIODS: [f64; 2] = [0.0, 100.0];

/// Computes a map.
#[pyfunction]
pub fn map(py: Python<'_>, method: &Bound<'_, PyAny>, arguments: MapArguments) -> PyResult<Mapped> {
    let named = chosen(method)?;
    let defaults = MapParams::default();
    let mut device = defaults.device;
    if let Some(friction) = arguments.viscous_friction {
        device.viscous_friction = within("viscous_friction", friction, NOT_NEGATIVE, " N s/m")?;
    }
    let quantum = arguments.encoder_quantum;
    device.encoder_quantum = within("encoder_quantum", quantum, NOT_NEGATIVE, " m")?;
    device.told_mass = within("told_mass", arguments.told_mass, FACTOR, "")?;
    let forces = match arguments.forces.as_str() {
        "balanced" => defaults.forces,
        "weight" => Forces::Weight {
            user_force: 1.0,
            gravity: 9.81,
        },
        other => {
            return Err(refused(format!(
                "forces is \"{other}\", but must be \"balanced\" or \"weight\""
            )));
        }
    };
    let params = MapParams {
        cells: arguments.cells,
        // In their own order, so that the same methods make the same map.
        methods: MethodName::ALL
            .into_iter()
            .filter(|method| named.contains(method))
            .collect(),
        device,
        delay: within("delay", arguments.delay, PERIODS, " periods")?,
        lag: within("lag", arguments.lag, PERIODS, " periods")?,
        told_period: within("told_period", arguments.told_period, FACTOR, "")?,
        forces,
        ..defaults
    };
    params.check().map_err(refused)?;
    let mapped = interruptible(py, move |stop| {
        let begin = Instant::now();
        let threads = thread::available_parallelism().map_or(1, Into::into);
        let cells = params.shard(1, 1);
        let (mut ticks, mut rows) = (0, BTreeMap::new());
        let never = AtomicBool::new(false);
        let is_over = AtomicBool::new(false);
        let computed = thread::scope(|scope| {
            // Cells that are being run are finished, and none is begun after.
            let look = scope.spawn(|| {
                while !is_over.load(Ordering::Relaxed) {
                    if stop.is_raised() {
                        never.store(true, Ordering::Relaxed);
                        break;
                    }
                    thread::sleep(Duration::from_millis(20));
                }
            });
            let computed = compute(&params, &cells, threads, &never, |result| {
                ticks += result.ticks;
                rows.insert(result.index, result.rows(&params));
                ControlFlow::Continue(())
            });
            is_over.store(true, Ordering::Relaxed);
            let _ = look.join();
            computed
        });
        stop.leave_if_raised();
        computed.map_err(|error| error.to_string())?;
        let map = Map {
            receipt: receipt::of(&params, (1, 1)),
            rows: rows.into_values().flatten().collect(),
        };
        let speed = Speed {
            ticks,
            seconds: begin.elapsed().as_secs_f64(),
            threads,
        };
        let report = MapReport::new(&map, Some(speed)).map_err(|error| error.to_string())?;
        let figure =
            palpate_plot::map::figure(&map, &[], None).map_err(|error| error.to_string())?;
        let figure = svg(&figure, Size::NATURAL).map_err(|error| error.to_string())?;
        let mut text = Vec::new();
        map.write(&mut text).map_err(|error| error.to_string())?;
        let text = String::from_utf8(text).map_err(|error| error.to_string())?;
        Ok::<_, String>((
            palpate_study::json(&report),
            report.to_string(),
            figure,
            text,
        ))
    })?;
    mapped.map_err(refused)
}

/// Says what can be rendered on a device: a report as JSON and as text.
#[pyfunction]
pub fn advise(
    py: Python<'_>,
    method: &Bound<'_, PyAny>,
    arguments: AdviseArguments,
) -> PyResult<(String, String)> {
    let methods = chosen(method)?;
    let file = match &arguments.device_file {
        None => None,
        Some(path) => {
            let text = std::fs::read_to_string(path)?;
            let name = path.display().to_string();
            Some(Calibration::parse(&name, &text).map_err(refused)?)
        }
    };
    let bounce = bounce(&arguments, file.as_ref())?;
    let is_stiffness_given = arguments.stiffness.is_some();
    let advised = interruptible(py, move |stop| {
        let mut advice = Advice::on(&bounce, is_stiffness_given, &methods, || {
            stop.leave_if_raised();
        })?;
        let stiffest =
            file.and_then(|file| file.stiffest_contact(bounce.object_mass, bounce.period));
        if let Some(stiffest) = stiffest {
            advice.bounded_by_a_resonance(stiffest);
        }
        Ok((palpate_study::json(&advice), advice.to_string()))
    })?;
    advised.map_err(|error: BounceError| match error {
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
    })
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
