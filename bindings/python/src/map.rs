//! `map`: contacts that each method can render, as a whole map or in parts.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use palpate_core::MethodName;
use palpate_record::map::{Format, Map, Row, merge};
use palpate_study::map::report::{MapReport, Speed};
use palpate_study::map::{Forces, MapParams, compute, metadata};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::checked::{DEVIATION, FACTOR, NOT_NEGATIVE, PERIODS, within};
use crate::fields::read;
use crate::figures::drawn;
use crate::interrupt::{Stop, interruptible};
use crate::methods::chosen;
use crate::names::refused;

/// A report as JSON, as text and as a figure, and the text of the map file.
type Mapped = (String, String, String, String);

/// Arguments of `map`.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct MapArguments {
    cells: usize,
    viscous_friction: Option<f64>,
    encoder_quantum: f64,
    model_mass: f64,
    model_period: f64,
    delay_periods: f64,
    lag_periods: f64,
    delay_deviation_periods: f64,
    lag_deviation_periods: f64,
    forces: String,
}

/// Returns the parameters of a map.
fn params(method: &Bound<'_, PyAny>, arguments: &MapArguments) -> PyResult<MapParams> {
    let named = chosen(method)?;
    let defaults = MapParams::default();
    let mut device = defaults.device;
    if let Some(friction) = arguments.viscous_friction {
        device.viscous_friction = within("viscous_friction", friction, NOT_NEGATIVE, " N s/m")?;
    }
    let quantum = arguments.encoder_quantum;
    device.encoder_quantum = within("encoder_quantum", quantum, NOT_NEGATIVE, " m")?;
    device.model_mass = within("model_mass", arguments.model_mass, FACTOR, "")?;
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
        // In canonical order, so that the same methods give the same map.
        methods: MethodName::ALL
            .into_iter()
            .filter(|method| named.contains(method))
            .collect(),
        device,
        delay: within(
            "delay_periods",
            arguments.delay_periods,
            PERIODS,
            " periods",
        )?,
        lag: within("lag_periods", arguments.lag_periods, PERIODS, " periods")?,
        delay_deviation: within(
            "delay_deviation_periods",
            arguments.delay_deviation_periods,
            DEVIATION,
            " periods",
        )?,
        lag_deviation: within(
            "lag_deviation_periods",
            arguments.lag_deviation_periods,
            DEVIATION,
            " periods",
        )?,
        model_period: within("model_period", arguments.model_period, FACTOR, "")?,
        forces,
        ..defaults
    };
    params.check().map_err(refused)?;
    Ok(params)
}

/// Computes a part of a map on `threads` threads and returns it with its speed.
fn part(
    params: &MapParams,
    (number, of): (usize, usize),
    threads: usize,
    stop: &Stop,
) -> Result<(Map, Speed), String> {
    let begin = Instant::now();
    let cells = params.shard(number, of);
    let (mut ticks, mut rows) = (0, BTreeMap::new());
    let never = AtomicBool::new(false);
    let is_over = AtomicBool::new(false);
    let computed = thread::scope(|scope| {
        // Running cells are finished, and no new ones are started.
        let look = scope.spawn(|| {
            while !is_over.load(Ordering::Relaxed) {
                if stop.is_raised() {
                    never.store(true, Ordering::Relaxed);
                    break;
                }
                thread::sleep(Duration::from_millis(20));
            }
        });
        let computed = compute(params, &cells, threads, &never, |result| {
            ticks += result.ticks;
            rows.insert(result.index, result.rows(params));
            ControlFlow::Continue(())
        });
        is_over.store(true, Ordering::Relaxed);
        let _ = look.join();
        computed
    });
    stop.leave_if_raised();
    computed.map_err(|error| error.to_string())?;
    let map = Map {
        metadata: metadata::of(params, (number, of)),
        rows: rows.into_values().flatten().collect(),
    };
    let seconds = begin.elapsed().as_secs_f64();
    Ok((
        map,
        Speed {
            ticks,
            seconds,
            threads,
        },
    ))
}

/// Returns the report, the figure and the file of a whole map.
fn mapped(map: &Map, speed: Option<Speed>) -> Result<Mapped, String> {
    let report = MapReport::new(map, speed).map_err(|error| error.to_string())?;
    let figure = palpate_plot::map::figure(map, &[], None).map_err(|error| error.to_string())?;
    let mut text = Vec::new();
    map.write(&mut text).map_err(|error| error.to_string())?;
    Ok((
        palpate_study::json(&report),
        report.to_string(),
        drawn(&figure)?,
        String::from_utf8(text).map_err(|error| error.to_string())?,
    ))
}

/// Computes a map.
#[pyfunction]
pub fn map(
    py: Python<'_>,
    method: &Bound<'_, PyAny>,
    arguments: &Bound<'_, PyDict>,
) -> PyResult<Mapped> {
    let params = params(method, &read(arguments)?)?;
    let found = interruptible(py, move |stop| {
        let threads = thread::available_parallelism().map_or(1, Into::into);
        let (map, speed) = part(&params, (1, 1), threads, stop)?;
        mapped(&map, Some(speed))
    })?;
    found.map_err(refused)
}

/// A part of a map: its metadata by key and value, and its lines.
type Part = (Vec<(String, String)>, Vec<String>);

/// Computes part `number` of `of` of a map in one thread.
#[pyfunction]
pub fn map_part(
    py: Python<'_>,
    method: &Bound<'_, PyAny>,
    arguments: &Bound<'_, PyDict>,
    number: usize,
    of: usize,
) -> PyResult<Part> {
    let params = params(method, &read(arguments)?)?;
    let (map, _) =
        interruptible(py, move |stop| part(&params, (number, of), 1, stop))?.map_err(refused)?;
    let lines = map.rows.iter().map(Row::to_line).collect();
    Ok((map.metadata, lines))
}

/// Checks the parameters of a map and returns its number of cells.
#[pyfunction]
pub fn map_check(method: &Bound<'_, PyAny>, arguments: &Bound<'_, PyDict>) -> PyResult<usize> {
    Ok(params(method, &read(arguments)?)?.len())
}

/// Returns the columns of a line of a map.
#[pyfunction]
pub fn map_columns() -> Vec<&'static str> {
    Format::BouncesAndStays.columns().to_vec()
}

/// Joins all parts of a map, each with a name for messages.
#[pyfunction]
pub fn map_of_parts(parts: Vec<(String, Part)>) -> PyResult<Mapped> {
    let read = |(name, (metadata, lines)): (String, Part)| {
        let rows: Result<Vec<Row>, String> = lines
            .iter()
            .map(|line| Row::from_line(line, Format::BouncesAndStays))
            .collect();
        match rows {
            Ok(rows) => Ok((name, Map { metadata, rows })),
            Err(error) => Err(refused(format!("{name}: {error}"))),
        }
    };
    let parts: PyResult<Vec<_>> = parts.into_iter().map(read).collect();
    let map = merge(parts?).map_err(refused)?;
    mapped(&map, None).map_err(refused)
}
