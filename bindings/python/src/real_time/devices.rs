//! Opens the devices of a loop from the descriptions of the Python files.

use std::path::PathBuf;
use std::time::Duration;

use palpate_core::AlongAxis;
use palpate_device::clock::MonotonicClock;
use palpate_device::{Capabilities, Device};
use palpate_drivers::inverse3::{Inverse3, Inverse3Options, Pace, SERVICE};
use palpate_drivers::prepared::{Axis, FIRST_AXIS};
use palpate_study::sim::device::{PointerDevice, PointerHand, PointerParams, SimulatedDevice};
use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::ended::Closed;
use super::external::{
    ExternalGiven, ForceDimensionGiven, PluginGiven, external, force_dimension, plugin,
};
use super::held::{Held, Telling};
use super::own_device::OwnDevice;
use crate::names::{refused, wrong_on_bench};
use crate::scene::PyScene;

/// An open device.
pub struct Opened {
    /// The device.
    pub device: Box<dyn Device>,
    /// Origin and direction of the contact's axis in the device's frame.
    pub axis: AlongAxis<f64, 3>,
    /// Force that the device holds.
    pub held: Held,
    /// Message at the end.
    pub closed: Closed,
}

/// Target position of a simulated hand, which Python can set at any time.
#[pyclass(frozen, name = "Hand", module = "palpate._palpate")]
pub struct Hand(PointerHand);

#[pymethods]
impl Hand {
    /// Creates a hand that holds its device at `target` `[m]`; None: a hand that has released the device.
    #[new]
    #[pyo3(signature = (target=None))]
    fn new(target: Option<f64>) -> PyResult<Self> {
        let hand = Self(PointerHand::free());
        if let Some(target) = target {
            hand.move_to(target)?;
        }
        Ok(hand)
    }

    /// Sets the target `[m]` and grasps the device if it was released.
    fn move_to(&self, target: f64) -> PyResult<()> {
        if !target.is_finite() {
            return Err(refused(format!("target is {target} m, but must be finite")));
        }
        self.0.move_to(target);
        Ok(())
    }

    /// Releases the device.
    fn disable_output(&self) {
        self.0.disable_output();
    }

    /// Target `[m]`; None if the device is released.
    #[getter]
    fn target(&self) -> Option<f64> {
        self.0.target()
    }
}

/// Arguments of the device `pointer`.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct Pointer {
    hand: Py<Hand>,
    mass: f64,
    position: f64,
    viscous_friction: f64,
    dry_friction: f64,
    encoder_quantum: f64,
    largest_force: Option<f64>,
    hand_mass: f64,
    hand_stiffness: f64,
    hand_damping: f64,
}

/// Arguments that locate the contact's axis in a device; None: default.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct Placed {
    origin: Option<Vec<f64>>,
    normal: Option<Vec<f64>>,
    world_axes: Option<Vec<String>>,
}

/// Arguments of the device `haply-2diy`.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct TwoDiyGiven {
    pub port: Option<PathBuf>,
    pub generation: u8,
    pub board: Option<String>,
    pub start_pose: StartPose,
    /// Command of the watchdog process; None: no watchdog process.
    pub watchdog: Option<Vec<String>>,
}

/// Pose of the arm while it is opened.
#[derive(FromPyObject)]
pub enum StartPose {
    Word(String),
    Angles([f32; 2]),
}

/// Arguments of the device `inverse3`.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Inverse3Given {
    service: Option<String>,
    events: Option<String>,
    device_id: Option<String>,
}

/// Opens the device that `given` describes, for a loop of `period` with at most `silence` between commands.
pub fn open(
    py: Python<'_>,
    given: &Bound<'_, PyDict>,
    clock: MonotonicClock,
    period: Duration,
    silence: Duration,
) -> PyResult<Opened> {
    let kind: String = given.as_any().get_item("kind")?.extract()?;
    let closed = Closed::default();
    let (device, axis): (Box<dyn Device>, _) = match kind.as_str() {
        "pointer" => {
            let given: Pointer = given.extract()?;
            let device = PointerDevice::new(given.params(), &given.hand.get().0, clock);
            let device = device.map_err(|error| wrong_on_bench(&error))?;
            (Box::new(device), along(FIRST_AXIS)?)
        }
        "simulated" => {
            let scene: Py<PyScene> = given.as_any().get_item("scene")?.extract()?;
            let device = SimulatedDevice::new(scene.get().scene(), clock);
            let device = device.map_err(|error| wrong_on_bench(&error))?;
            (Box::new(device), along(FIRST_AXIS)?)
        }
        "haply-2diy" => {
            let (own, placed): (TwoDiyGiven, Placed) = (given.extract()?, given.extract()?);
            let opening = || two_diy(&own, clock, period, silence, &closed);
            let (device, usual, _) = py.detach(opening)?;
            let axis = placed.axis(device.capabilities(), usual)?;
            (device, axis)
        }
        "inverse3" => {
            let (own, placed): (Inverse3Given, Placed) = (given.extract()?, given.extract()?);
            let options = own.options(period);
            let device = py.detach(|| Inverse3::open(&options, clock));
            let device = device.map_err(|error| PyOSError::new_err(error.to_string()))?;
            // The current cursor position becomes coordinate 0 of the contact.
            let usual = (device.opened_at(), FIRST_AXIS.1);
            let axis = placed.axis(device.capabilities(), usual)?;
            (Box::new(device), axis)
        }
        "external" => {
            let (own, placed): (ExternalGiven, Placed) = (given.extract()?, given.extract()?);
            let opening = || external(&own, clock, period, silence, &closed);
            let (device, _) = py.detach(opening)?;
            let axis = placed.axis(device.capabilities(), FIRST_AXIS)?;
            (device, axis)
        }
        "force-dimension" => {
            let (own, placed): (ForceDimensionGiven, Placed) = (given.extract()?, given.extract()?);
            let opening = || force_dimension(&own, clock, period, silence, &closed);
            let (device, _) = py.detach(opening)?;
            let axis = placed.axis(device.capabilities(), FIRST_AXIS)?;
            (device, axis)
        }
        "plugin" => {
            let (own, placed): (PluginGiven, Placed) = (given.extract()?, given.extract()?);
            let (device, _) = py.detach(|| plugin(&own, clock, &closed))?;
            let axis = placed.axis(device.capabilities(), FIRST_AXIS)?;
            (device, axis)
        }
        "own" => {
            let placed: Placed = given.extract()?;
            let device = OwnDevice::new(given.as_any(), clock)?;
            let axis = placed.axis(device.capabilities(), FIRST_AXIS)?;
            (Box::new(device), axis)
        }
        "simulated-in-world" | "pointer-in-world" => {
            return Err(refused(
                "device is for a World, but a Renderer renders one contact; use a World, or a Pointer or a Simulated \
                 of a Scene",
            ));
        }
        other => return Err(refused(format!("there is no device \"{other}\""))),
    };
    let held = Held::default();
    Ok(Opened {
        device: Box::new(Telling::new(device, held.clone())),
        axis,
        held,
        closed,
    })
}

impl Pointer {
    fn params(&self) -> PointerParams {
        PointerParams {
            device_mass: self.mass,
            position: self.position,
            viscous_friction: self.viscous_friction,
            dry_friction: self.dry_friction,
            encoder_quantum: self.encoder_quantum,
            largest_force: self.largest_force,
            hand_mass: self.hand_mass,
            hand_stiffness: self.hand_stiffness,
            hand_damping: self.hand_damping,
            ..PointerParams::default()
        }
    }
}

impl Inverse3Given {
    /// Returns the driver options for a loop of this period.
    pub fn options(&self, period: Duration) -> Inverse3Options {
        Inverse3Options {
            service: self.service.clone().unwrap_or_else(|| SERVICE.to_owned()),
            events: self.events.clone(),
            device_id: self.device_id.clone(),
            pace: Pace::for_period(period),
            ..Inverse3Options::default()
        }
    }
}

impl Placed {
    fn axis(&self, device: &Capabilities, usual: Axis) -> PyResult<AlongAxis<f64, 3>> {
        if self.world_axes.is_some() {
            return Err(refused(
                "world_axes is for a World; for a Renderer, give normal",
            ));
        }
        palpate_drivers::prepared::axis(
            self.origin.as_deref(),
            self.normal.as_deref(),
            device,
            usual,
        )
        .map_err(|error| {
            let what = match error.what() {
                palpate_drivers::prepared::Placed::Origin => "origin",
                palpate_drivers::prepared::Placed::Normal => "normal",
            };
            refused(format!("{what}: {error}"))
        })
    }
}

fn along((origin, direction): Axis) -> PyResult<AlongAxis<f64, 3>> {
    AlongAxis::new(origin, direction).map_err(|error| refused(format!("origin: {error}")))
}

#[cfg(unix)]
pub use super::two_diy::two_diy;

/// Reports that this platform has no driver.
#[cfg(not(unix))]
pub fn two_diy(
    _: &TwoDiyGiven,
    _: MonotonicClock,
    _: Duration,
    _: Duration,
    _: &Closed,
) -> PyResult<(Box<dyn Device>, Axis, Option<String>)> {
    Err(refused("the driver of the 2DIY needs Linux or macOS"))
}
