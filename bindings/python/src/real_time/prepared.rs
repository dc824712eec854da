//! A prepared loop before its start: open devices and a ready renderer.

use std::slice;
use std::time::Duration;

use palpate_device::Device;
use palpate_device::clock::MonotonicClock;
use palpate_record::recording::RecordingMetadata;
use palpate_rt::safety::SafetyParams;
use palpate_rt::{ControlLoop, OnDevice, changing_world, metadata, metadata_of_devices};
use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::InWorld;
use super::control::Control;
use super::devices::{Opened, open};
use super::ended::Closed;
use super::held::Held;
use super::in_world::{self, OpenedInWorld};
use super::low_rate_simulator::LowRateSimulator;
use super::options::Options;
use crate::names::refused;
use crate::renderer::rendering;
use crate::world::PyWorld;

/// A prepared loop and its properties.
pub struct Prepared {
    /// The loop.
    pub control: Control,
    /// Period `[s]`.
    pub period: f64,
    /// Handles of each device outside the loop.
    pub devices: Vec<Beside>,
    /// Change channel of the world, and its devices.
    pub in_world: Option<InWorld>,
    /// Simulator side of the local model.
    pub low_rate_simulator: Option<palpate_rt::LowRateSimulator>,
    /// Metadata for a recording.
    pub metadata: RecordingMetadata,
    /// Names of several devices in the world.
    pub names: Vec<String>,
    /// Description of the devices.
    pub runs_on: String,
    /// Largest commanded force of any device `[N]`.
    pub largest_force: f64,
}

/// Handles of a device outside its loop.
pub struct Beside {
    /// Force that the device holds.
    pub held: Held,
    /// Message at the end.
    pub closed: Closed,
}

const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Prepares a loop of one contact: method, parameters, soft start and settings.
pub fn prepare_contact(
    py: Python<'_>,
    devices: &[Bound<'_, PyDict>],
    rendered: &Bound<'_, PyAny>,
    clock: MonotonicClock,
    options: &Options,
) -> PyResult<Prepared> {
    let [device] = devices else {
        return Err(refused(format!(
            "{} devices are given; a Renderer runs on one device, a World on several",
            devices.len()
        )));
    };
    let (method, parameters, soft_start, settings): (
        Bound<'_, PyAny>,
        Bound<'_, PyDict>,
        f64,
        Bound<'_, PyDict>,
    ) = rendered.extract()?;
    let (setup, rendering) = rendering(&method, &parameters, &settings)?;
    let seconds = setup.loop_params.period;
    let period = Duration::try_from_secs_f64(seconds).map_err(refused)?;
    let silence = options.patient(SafetyParams::default()).stall_after(period);
    let Opened {
        device,
        axis,
        held,
        closed,
    } = open(py, device, clock, period, silence)?;
    let capabilities = device.capabilities().clone();
    let limits = options.limits(&capabilities, setup.loop_params.force_limit, soft_start);
    let control = ControlLoop::new(device, clock, rendering, limits).map_err(refused)?;
    let metadata = metadata(VERSION, &capabilities, &limits, &options.request());
    Ok(Prepared {
        control: Control::Contact(Box::new(control.along(axis))),
        period: seconds,
        devices: vec![Beside { held, closed }],
        in_world: None,
        low_rate_simulator: None,
        metadata: match &options.scene {
            Some(text) => metadata.with("scene", text),
            None => metadata,
        },
        names: Vec::new(),
        runs_on: capabilities.name,
        largest_force: limits.largest_force,
    })
}

/// Prepares a loop of a world, with one device for each of the world's devices, in their order.
pub fn prepare_world(
    py: Python<'_>,
    devices: &[Bound<'_, PyDict>],
    world: &PyWorld,
    clock: MonotonicClock,
    options: &Options,
) -> PyResult<Prepared> {
    let scene = world.scene();
    let seconds = scene.timing.period;
    let period = Duration::try_from_secs_f64(seconds).map_err(refused)?;
    let silence = options.patient(SafetyParams::default()).stall_after(period);
    if scene.devices.len() != devices.len() {
        return Err(refused(format!(
            "{} for a world of {}; give one device for each device of the world",
            counted(devices.len()),
            counted(scene.devices.len())
        )));
    }
    let OpenedDevices { driven, beside, on } =
        open_devices(py, devices, world, clock, options, (period, silence))?;
    let rendered = in_world::rendered(world, &on)?;
    let (worlds, rendered) = changing_world(scene.world.clone(), rendered);
    let control = ControlLoop::of_changing_devices(driven, clock, rendered);
    let control = control.map_err(refused)?;
    let metadata = metadata_of_devices(VERSION, &on, &options.request());
    let are_several = on.len() > 1;
    let most = on.iter().map(|on| on.limits.largest_force);
    Ok(Prepared {
        control: Control::World(Box::new(control)),
        period: seconds,
        devices: beside,
        metadata: metadata
            .with("world", world.text())
            .with("method", &format!("name = \"{}\"\n", world.method)),
        names: on
            .iter()
            .filter(|_| are_several)
            .map(|on| on.name.clone())
            .collect(),
        runs_on: devices_in_words(&on),
        largest_force: most.fold(0.0, f64::max),
        in_world: Some(InWorld { worlds, on }),
        low_rate_simulator: None,
    })
}

/// Open devices of a world, in its order.
struct OpenedDevices {
    /// The devices, with their limits.
    driven: Vec<(Box<dyn Device>, SafetyParams)>,
    /// Handles of each device outside the loop.
    beside: Vec<Beside>,
    /// Names, capabilities, limits and frames of the devices.
    on: Vec<OnDevice>,
}

/// Opens one device for each of the world's devices, for a loop of `period` with at most `silence` between commands.
fn open_devices(
    py: Python<'_>,
    devices: &[Bound<'_, PyDict>],
    world: &PyWorld,
    clock: MonotonicClock,
    options: &Options,
    (period, silence): (Duration, Duration),
) -> PyResult<OpenedDevices> {
    let scene = world.scene();
    let (mut driven, mut beside, mut on) = (Vec::new(), Vec::new(), Vec::<OnDevice>::new());
    let mut identities = Vec::<Option<String>>::new();
    let own = scene.world.tools.iter().zip(&scene.devices);
    for ((tool, own), given) in own.zip(devices) {
        let opening = in_world::open(py, given, (&tool.name, own), clock, (period, silence));
        let opened = opening.map_err(|error| of_device(py, error, &tool.name, devices.len()))?;
        let OpenedInWorld {
            device,
            frame,
            held,
            closed,
            identity,
        } = opened;
        let is_the_same = |before: &Option<String>| before.is_some() && *before == identity;
        if let Some(before) = identities.iter().position(is_the_same) {
            return Err(refused(format!(
                "{} and {} are one device, {}; each needs a separate device",
                on[before].name,
                tool.name,
                identity.unwrap_or_default()
            )));
        }
        identities.push(identity);
        let capabilities = device.capabilities().clone();
        let limits = options.limits(&capabilities, world.force_limit, world.soft_start);
        driven.push((device, limits));
        beside.push(Beside { held, closed });
        on.push(OnDevice {
            name: tool.name.clone(),
            capabilities,
            limits,
            frame,
        });
    }
    Ok(OpenedDevices { driven, beside, on })
}

/// Describes the devices; several by their names.
fn devices_in_words(on: &[OnDevice]) -> String {
    let are_several = on.len() > 1;
    let runs_on = on.iter().map(|on| {
        let kind = &on.capabilities.name;
        if are_several {
            format!("{}: {kind}", on.name)
        } else {
            kind.clone()
        }
    });
    runs_on.collect::<Vec<_>>().join(", ")
}

/// Prepares a loop of a low-rate simulator's local model on one device.
pub fn prepare_low_rate_simulator(
    py: Python<'_>,
    devices: &[Bound<'_, PyDict>],
    host: &LowRateSimulator,
    clock: MonotonicClock,
    options: &Options,
) -> PyResult<Prepared> {
    let [device] = devices else {
        return Err(refused(format!(
            "{} devices are given; a LowRateSimulator runs on one device",
            devices.len()
        )));
    };
    let own = host.device();
    let period = Duration::try_from_secs_f64(host.period()).map_err(refused)?;
    let silence = options.patient(SafetyParams::default()).stall_after(period);
    let OpenedInWorld {
        device,
        frame,
        held,
        closed,
        ..
    } = in_world::open(
        py,
        device,
        (LowRateSimulator::TOOL, &own),
        clock,
        (period, silence),
    )?;
    let capabilities = device.capabilities().clone();
    let (force_limit, soft_start) = host.limits();
    let limits = options.limits(&capabilities, force_limit, soft_start);
    let (low_rate_simulator, rendered) = host.ends(frame)?;
    let control = ControlLoop::of_local_world(device, clock, rendered, limits).map_err(refused)?;
    let on = OnDevice {
        name: LowRateSimulator::TOOL.to_owned(),
        capabilities,
        limits,
        frame,
    };
    Ok(Prepared {
        control: Control::Local(Box::new(control)),
        period: host.period(),
        devices: vec![Beside { held, closed }],
        in_world: None,
        low_rate_simulator: Some(low_rate_simulator),
        metadata: metadata_of_devices(VERSION, slice::from_ref(&on), &options.request()),
        names: Vec::new(),
        runs_on: on.capabilities.name,
        largest_force: limits.largest_force,
    })
}

/// Prefixes an error with the device name if there are several devices.
fn of_device(py: Python<'_>, error: PyErr, name: &str, devices: usize) -> PyErr {
    if devices == 1 {
        return error;
    }
    let text = format!("{name}: {}", error.value(py));
    if error.is_instance_of::<PyOSError>(py) {
        PyOSError::new_err(text)
    } else if error.is_instance_of::<PyValueError>(py) {
        PyValueError::new_err(text)
    } else {
        error
    }
}

/// Returns `1 device`, `2 devices`.
fn counted(devices: usize) -> String {
    format!("{devices} device{}", if devices == 1 { "" } else { "s" })
}
